#include "engine/scene/load_warnings.h"

#include "io/hidden_nodes.h"

namespace palpate {

std::vector<std::string> unapplied_lines(const Scene& scene) {
  std::vector<std::string> lines = scene.statistics().unapplied_extras;
  const auto add = [&](const DeclarationReport& declaration) {
    for (const IgnoredParameter& p : declaration.report.not_understood) {
      lines.push_back(p.element + ": " + p.key + " of \"" + declaration.name +
                      "\" is ignored: " + p.why);
    }
  };
  const SceneEffectsReport& report = scene.effects();
  for (const DeclarationReport& material : report.materials) add(material);
  add(report.scene);
  for (const DeclarationReport& region : report.regions) add(region);
  return lines;
}

std::vector<std::string> load_warnings(const Scene& scene) {
  std::vector<std::string> warnings = unapplied_lines(scene);
  std::string hidden = hidden_nodes_text(scene.statistics().hidden_nodes);
  if (!hidden.empty()) warnings.insert(warnings.begin(), std::move(hidden));
  return warnings;
}

}  // namespace palpate
