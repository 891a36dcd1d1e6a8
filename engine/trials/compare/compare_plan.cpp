#include "engine/trials/compare/compare_plan.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/plan_device.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// "my star.glb" becomes "my_star".
std::string object_name_of(const std::string& path) {
  std::string name = fs::path(path).stem().string();
  for (char& c : name) {
    const bool is_allowed = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                            (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    if (!is_allowed) c = '_';
  }
  if (name.empty() || name.front() == '.') name.insert(0, "_");
  constexpr std::size_t kNumberBytes = 4;  // "-100"
  return name.substr(0, kMostObjectNameBytes - kNumberBytes);
}

// A name for each scene, none twice.
std::vector<std::string> object_names(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const std::string& path : paths) {
    const std::string plain = object_name_of(path);
    std::string name = plain;
    for (int number = 2; !taken.insert(name).second; ++number) {
      name = plain + "-" + std::to_string(number);
    }
    names.push_back(name);
  }
  return names;
}

// A path from a folder to a file, or the absolute path if the system does not find the file by it.
std::string path_from(const std::string& folder, const std::string& file) {
  std::error_code failed;
  const fs::path target = fs::absolute(file, failed).lexically_normal();
  const fs::path from = fs::absolute(folder, failed).lexically_normal();
  const fs::path relative = target.lexically_relative(from);
  const bool is_found = !relative.empty() && fs::exists(from / relative, failed);
  return (is_found ? relative : target).generic_string();
}

Json object_json(const SceneSettings& scene, const std::string& file) {
  Json json{{"file", file}};
  if (!scene.node.empty()) json["node"] = scene.node;
  if (scene.fit_size_m > 0.0) {
    json["fit_size_m"] = scene.fit_size_m;
  } else {
    json["scale"] = scene.scale;
  }
  if (!scene.listed_scene.empty()) json["scene"] = scene.listed_scene;
  if (scene.feels_hidden) json["feel_hidden"] = true;
  if (!scene.pose.empty()) json["pose"] = scene.pose;
  if (scene.close_gaps_m > 0.0) json["close_gaps_m"] = scene.close_gaps_m;
  return json;
}

Json strategies_json(const CompareSettings& settings) {
  Json names = Json::array();
  for (const Strategy& strategy : settings.strategies) names.push_back(name_of(strategy));
  return names;
}

// path_of: converts a path from the current folder to one in the plan.
template <typename PathOf>
std::string plan_text(const CompareSettings& settings, const PathOf& path_of) {
  Json objects = Json::object();
  const auto names = object_names(settings.scenes);
  for (std::size_t i = 0; i < names.size(); ++i) {
    objects[names[i]] = object_json(settings.scene, path_of(settings.scenes[i]));
  }
  const bool is_shipped = !shipped_operator_text(settings.person).empty();
  Json followings = Json::array();
  for (std::size_t i = 0; i < (settings.has_all_followings ? kTurningFollowings : 1); ++i) {
    followings.push_back(kFollowingNames[i]);
  }
  Json plan = {{"palpate_plan", 1},
               {"name", "compare"},
               {"seed", settings.seed},
               {"participants", settings.hands},
               {"blocks", 1},
               {"practice_blocks", 0},
               {"device", plan_device_json(settings.device)},
               {"display_Hz", TrialSettings{}.display_Hz},
               {"sphere_radius_m", TrialSettings{}.sphere_radius_m},
               {"limit_s", TrialSettings{}.limit_s},
               {"strategies", strategies_json(settings)},
               {"objects", objects},
               {"operator", is_shipped ? settings.person : path_of(settings.person)},
               {"followings", followings}};
  if (settings.device.haptics.a4.align == Alignment::kForward) plan["align"] = "forward";
  return plan.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::vector<Strategy> anisotropic_strategies() {
  std::vector<Strategy> strategies;
  for (const double e : {1.0 / 16, 0.25, 0.5, 2.0, 4.0, 16.0}) {
    strategies.push_back({&kAnisotropicStrategy, e});
  }
  return strategies;
}

std::string every_strategy() {
  std::string list;
  for (const StrategyType* type : strategies()) {
    list += (list.empty() ? "" : ",") + std::string(type->name);
  }
  return list;
}

std::string strategies_help() {
  std::string text;
  for (const StrategyType* type : strategies()) {
    if (!text.empty()) text += type == strategies().back() ? " and " : ", ";
    if (type == &kAnisotropicStrategy) text += std::string(type->name) + ", ";
    text += name_with_symbol(*type);
  }
  return text;
}

Result<CompareSettings> with_strategies(CompareSettings settings, std::string_view list) {
  settings.strategies.clear();
  const auto refused = [](const std::string& problem, const std::string& hint) {
    return invalid_argument("strategies", problem, hint);
  };
  while (true) {
    const std::string_view name = list.substr(0, list.find(','));
    std::vector<Strategy> named = anisotropic_strategies();
    if (name != kAnisotropicStrategy.name) {
      const auto strategy = parse_strategy(name);
      if (!strategy) {
        return refused("has a name that " + strategy.error().problem +
                           ", or anisotropic, which stands for six E",
                       "separate the names by commas, as in mask,a4");
      }
      named = {*strategy};
    }
    for (const Strategy& strategy : named) {
      const auto& all = settings.strategies;
      if (std::find(all.begin(), all.end(), strategy) != all.end()) {
        return refused("has " + name_of(strategy) + " twice; expected each strategy once",
                       name == kAnisotropicStrategy.name ? "anisotropic stands for six E" : "");
      }
      settings.strategies.push_back(strategy);
    }
    if (name.size() == list.size()) return settings;
    list.remove_prefix(name.size() + 1);
  }
}

std::string compare_plan_text(const CompareSettings& settings, const std::string& folder) {
  return plan_text(settings, [&](const std::string& path) { return path_from(folder, path); });
}

Result<ExperimentPlan> compare_plan(const CompareSettings& settings) {
  const std::string text = plan_text(settings, [](const std::string& scene) { return scene; });
  return parse_plan(text, "", "");
}

}  // namespace palpate
