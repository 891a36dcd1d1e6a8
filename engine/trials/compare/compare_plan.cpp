#include "engine/trials/compare/compare_plan.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/key_hash.h"
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

Json strategies_json(const CompareSettings& settings, CompareHands hands) {
  Json names = Json::array();
  if (hands == CompareHands::kCompared) {
    for (const Strategy& strategy : settings.strategies) names.push_back(name_of(strategy));
  }
  if (settings.is_tuned) {
    for (const Strategy& level : tuned_levels()) names.push_back(name_of(level));
  }
  return names;
}

// path_of: converts a path from the current folder to one in the plan.
template <typename PathOf>
std::string plan_text(const CompareSettings& settings, CompareHands hands, const PathOf& path_of) {
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
               {"name", hands == CompareHands::kCompared ? "compare" : "compare, tuning"},
               {"seed", compare_seed(settings.seed, hands)},
               {"participants", settings.hands},
               {"blocks", 1},
               {"practice_blocks", 0},
               {"device", plan_device_json(settings.device)},
               {"display_Hz", TrialSettings{}.display_Hz},
               {"sphere_radius_m", TrialSettings{}.sphere_radius_m},
               {"limit_s", TrialSettings{}.limit_s},
               {"strategies", strategies_json(settings, hands)},
               {"objects", objects},
               {"operator", is_shipped ? settings.person : path_of(settings.person)},
               {"followings", followings}};
  if (settings.device.haptics.a4.align == Alignment::kForward) plan["align"] = "forward";
  return plan.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::vector<Strategy> tuned_levels() {
  std::vector<Strategy> levels;
  for (const double e : kTunedAnisotropies) levels.push_back({&kAnisotropicStrategy, e});
  return levels;
}

std::string every_strategy() {
  std::string list;
  for (const StrategyType* type : strategies()) {
    if (type->parameter && !type->parameter->value_of_name_alone && type->name != kTunedStrategy) {
      continue;
    }
    list += (list.empty() ? "" : ",") + std::string(type->name);
  }
  return list;
}

std::string strategies_help() {
  std::string text;
  for (const StrategyType* type : strategies()) {
    if (!text.empty()) text += type == strategies().back() ? " and " : ", ";
    if (type->name == kTunedStrategy) text += std::string(type->name) + ", ";
    text += name_with_symbol(*type);
  }
  return text;
}

Result<CompareSettings> with_strategies(CompareSettings settings, std::string_view list) {
  settings.strategies.clear();
  settings.is_tuned = false;
  const auto refused = [](const std::string& problem, const std::string& hint) {
    return invalid_argument("strategies", problem, hint);
  };
  bool is_repeated = false;
  while (true) {
    const std::string_view name = list.substr(0, list.find(','));
    if (name == kTunedStrategy) {
      is_repeated = settings.is_tuned;
      settings.is_tuned = true;
    } else {
      const auto strategy = parse_strategy(name);
      if (!strategy) {
        return refused("has a name that " + strategy.error().problem +
                           ", or anisotropic, which tries several E",
                       "separate the names by commas, as in mask,a4");
      }
      is_repeated = std::find(settings.strategies.begin(), settings.strategies.end(), *strategy) !=
                    settings.strategies.end();
      settings.strategies.push_back(*strategy);
    }
    if (is_repeated) {
      return refused("has " + std::string(name) + " twice; expected each strategy once", "");
    }
    if (name.size() == list.size()) break;
    list.remove_prefix(name.size() + 1);
  }
  for (const Strategy& level : settings.is_tuned ? tuned_levels() : std::vector<Strategy>{}) {
    if (std::find(settings.strategies.begin(), settings.strategies.end(), level) ==
        settings.strategies.end()) {
      continue;
    }
    return refused("has both anisotropic and " + name_of(level) + "; expected one of them",
                   "anisotropic tries this E, too");
  }
  return settings;
}

std::uint64_t compare_seed(std::uint64_t seed, CompareHands hands) {
  if (hands == CompareHands::kCompared) return seed;
  constexpr int kUnusedBits = 64 - 53;  // seeds of plans are below 2^53
  return KeyHash().add("tuning").add(seed).value() >> kUnusedBits;
}

std::string compare_plan_text(const CompareSettings& settings, CompareHands hands,
                              const std::string& folder) {
  return plan_text(settings, hands,
                   [&](const std::string& path) { return path_from(folder, path); });
}

Result<ExperimentPlan> compare_plan(const CompareSettings& settings, CompareHands hands) {
  const std::string text =
      plan_text(settings, hands, [](const std::string& scene) { return scene; });
  return parse_plan(text, "", "");
}

}  // namespace palpate
