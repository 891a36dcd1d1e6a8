#include "engine/cli/option_names.h"

#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/session/run_setting.h"

namespace palpate {
namespace {

struct OptionName {
  std::string_view owner;  // the struct
  std::string_view field;
  std::string_view option;
};

// Of settings that are none of a run.
constexpr OptionName kOtherNames[] = {
    {"SceneSettings", "node", "--node"},
    {"SceneSettings", "scale", "--scale"},
    {"SceneSettings", "fit_size_m", "--fit"},
    {"SceneSettings", "listed_scene", "--scene"},
    {"SceneSettings", "feels_hidden", "--feel-hidden"},
    {"SceneSettings", "pose", "--pose"},
    {"SceneSettings", "close_gaps_m", "--close-gaps"},
    {"SceneSettings", "overrides", "--material"},
    {"SceneSettings", "max_memory_bytes", "--max-memory"},
    {"HapticSettings", "strategy", "--strategy"},
    {"ExplorationSettings", "seconds", "--seconds"},
    {"GuardedRunSettings", "without_realtime", "--without-realtime"},
    {"ExplorationSettings", "seed", "--seed"},
    {"MeasurementEffort", "seed", "--seed"},
    {"OutputFiles", "folder", "--out"},
    {"Scene", "tree", "palpate info SCENE --list"},
};

// The settings of a run first.
const std::vector<OptionName>& option_names() {
  static const std::vector<OptionName> names = [] {
    std::vector<OptionName> all;
    for (const RunSetting& setting : run_settings()) {
      if (setting.option.empty()) continue;
      all.push_back(
          {setting.is_haptic() ? "HapticSettings" : "RunSettings", setting.field, setting.option});
    }
    all.insert(all.end(), std::begin(kOtherNames), std::end(kOtherNames));
    return all;
  }();
  return names;
}

void replace_all(std::string& text, std::string_view field, std::string_view option) {
  for (std::size_t at = text.find(field); at != std::string::npos; at = text.find(field, at)) {
    text.replace(at, field.size(), option);
    at += option.size();
  }
}

}  // namespace

std::string with_option_names(std::string text) {
  replace_all(text, "`fitting_size_m()`", "--fit auto");
  for (const OptionName& name : option_names()) {
    const std::string field = "`" + std::string(name.owner) + "::" + std::string(name.field) + "`";
    replace_all(text, field, name.option);
  }
  return text;
}

std::vector<std::string> with_option_names(std::vector<std::string> lines) {
  for (std::string& line : lines) line = with_option_names(std::move(line));
  return lines;
}

Error with_option_names(Error error) {
  // In other errors the element is a place in a file, and may have such a name by chance.
  const bool is_of_settings = error.code == ErrorCode::kInvalidArgument ||
                              error.code == ErrorCode::kOutOfMemory ||
                              error.code == ErrorCode::kLimitExceeded;
  for (const OptionName& name : option_names()) {
    if (is_of_settings && error.element == name.field) {
      error.element = name.option;
      break;
    }
  }
  error.element = with_option_names(std::move(error.element));
  error.problem = with_option_names(std::move(error.problem));
  error.hint = with_option_names(std::move(error.hint));
  return error;
}

}  // namespace palpate
