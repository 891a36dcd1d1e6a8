#include "engine/cli/option_names.h"

#include <string_view>
#include <utility>

namespace palpate {
namespace {

struct OptionName {
  std::string_view owner;  // the struct
  std::string_view field;
  std::string_view option;
};

constexpr OptionName kOptionNames[] = {
    {"SceneSettings", "node", "--node"},
    {"SceneSettings", "scale", "--scale"},
    {"SceneSettings", "fit_size_m", "--fit"},
    {"SceneSettings", "listed_scene", "--scene"},
    {"SceneSettings", "feels_hidden", "--feel-hidden"},
    {"SceneSettings", "pose", "--pose"},
    {"SceneSettings", "close_gaps_m", "--close-gaps"},
    {"SceneSettings", "overrides", "--material"},
    {"SceneSettings", "max_memory_bytes", "--max-memory"},
    {"RunSettings", "sensors", "--sensors"},
    {"RunSettings", "actuators", "--actuators"},
    {"RunSettings", "actuated_axes", "--actuated-axes"},
    {"RunSettings", "rate_Hz", "--rate"},
    {"RunSettings", "stiffness_N_per_m", "--stiffness"},
    {"HapticSettings", "coupling.stiffness_N_per_m", "--stiffness"},
    {"RunSettings", "damping_Ns_per_m", "--damping"},
    {"HapticSettings", "coupling.damping_Ns_per_m", "--damping"},
    {"RunSettings", "radius_m", "--radius"},
    {"HapticSettings", "god_object.radius_m", "--radius"},
    {"RunSettings", "work_budget", "--work-budget"},
    {"RunSettings", "align", "--align"},
    {"RunSettings", "table1", "--table1"},
    {"RunSettings", "velocity_estimator", "--velocity-estimator"},
    {"RunSettings", "velocity_window_ticks", "--velocity-window"},
    {"RunSettings", "encoder_quantum_m", "--encoder-quantum"},
    {"RunSettings", "max_force_N", "--max-force"},
    {"RunSettings", "plane_height_m", "--plane-height"},
    {"RunSettings", "place", "--place"},
    {"HapticSettings", "initial_pose", "--place"},
    {"RunSettings", "moves", "--move"},
    {"HapticSettings", "strategy", "--strategy"},
    {"RunSettings", "device.workspace", "--workspace"},
    {"RunSettings", "device.damping_Ns_per_m", "--device-damping"},
    {"ExplorationSettings", "seconds", "--seconds"},
    {"GuardedRunSettings", "without_realtime", "--without-realtime"},
    {"ExplorationSettings", "seed", "--seed"},
    {"MeasurementEffort", "seed", "--seed"},
    {"OutputFiles", "folder", "--out"},
    {"Scene", "tree", "palpate info SCENE --list"},
};

void replace_all(std::string& text, std::string_view field, std::string_view option) {
  for (std::size_t at = text.find(field); at != std::string::npos; at = text.find(field, at)) {
    text.replace(at, field.size(), option);
    at += option.size();
  }
}

}  // namespace

std::string with_option_names(std::string text) {
  replace_all(text, "`fitting_size_m()`", "--fit auto");
  for (const OptionName& name : kOptionNames) {
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
  for (const OptionName& name : kOptionNames) {
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
