#include "engine/scene/load_warnings.h"

#include "geometry/base/quoted.h"

namespace palpate {

std::string hidden_nodes_text(const HiddenNodes& hidden) {
  if (hidden.count == 0) return {};
  std::string names;
  for (const std::string& name : hidden.first_names) {
    names += (names.empty() ? "" : ", ") + in_quotes(name);
  }
  if (const std::size_t others = hidden.count - hidden.first_names.size(); others > 0) {
    names += " and " + std::to_string(others) + " more";
  }
  return std::to_string(hidden.count) +
         (hidden.count == 1 ? " node with a mesh is" : " nodes with a mesh are") +
         " hidden in the file (KHR_node_visibility) and cannot be felt: " + names +
         "; `SceneSettings::feels_hidden` loads hidden nodes, too";
}

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
