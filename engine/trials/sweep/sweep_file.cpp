#include "engine/trials/sweep/sweep_file.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/key_hash.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/sweep/sweep_points.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kPlanElement = "/plan";

Error sweep_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

// What every point needs of the base plan.
std::optional<Error> check_base_plan(const ExperimentPlan& plan) {
  const auto refused = [](const char* key, std::string problem, const char* hint) {
    return sweep_error(std::string(kPlanElement) + "/" + key, std::move(problem), hint);
  };
  const auto one = [&](const char* key, std::size_t count) {
    return refused(key, "is a list of " + std::to_string(count) + "; expected one level",
                   "name it among /parameters to vary it");
  };
  // First, because the view decides what other keys may be.
  if (plan.views != std::vector<View>{View::kTurning}) {
    return refused("view", "is not [\"turning\"]; expected it alone",
                   "the followings that a sweep varies are those of this view");
  }
  if (!plan.strategies.empty()) {
    return refused("strategies", "is present; expected haptic and rotation",
                   "every point compares the six conditions of haptic and rotation");
  }
  if (auto error = check_simulable(plan)) {
    error->path.clear();
    error->element = kPlanElement + error->element;
    return error;
  }
  if (plan.haptic.size() != kFeltHapticCount) {
    return refused("haptic", "lacks a level; expected NoH, UaH and H",
                   "every point compares the six conditions of haptic and rotation");
  }
  if (plan.rotation.size() != kRotationNames.size()) {
    return refused("rotation", "lacks a level; expected NoR and R",
                   "every point compares the six conditions of haptic and rotation");
  }
  if (plan.practice_blocks != 0) {
    return refused("practice_blocks", "is 1; expected 0", "a sweep does not analyse practice");
  }
  if (plan.followings.size() != 1) return one("followings", plan.followings.size());
  if (plan.start_orientation_deg.size() != 1) {
    return one("start_orientation_deg", plan.start_orientation_deg.size());
  }
  if (plan.scale.size() != 1) return one("scale", plan.scale.size());
  return std::nullopt;
}

void read_base_plan(ObjectReader& reader, const std::string& path, const std::string& folder,
                    Sweep& sweep) {
  const Json* const found = reader.find("plan");
  if (!found) return;
  if (!found->is_object()) {
    return reader.fail(unexpected_value(kPlanElement, *found, "an object, as in a plan's file"));
  }
  auto plan = parse_plan(found->dump(), path, folder);
  if (!plan) {
    Error error = plan.error();
    if (error.path == path) error.element = kPlanElement + error.element;
    return reader.fail(error);
  }
  sweep.plan = std::move(*plan);
  if (auto error = check_base_plan(sweep.plan)) reader.fail(*error);
}

// One level: a number within the parameter's limits, or one of its words.
Result<double> read_level(const Json& value, const std::string& element,
                          const SweepParameter& parameter) {
  if (parameter.words.empty()) {
    const bool is_number = value.is_number() && parameter.valid.contains(value.get<double>());
    if (is_number) return value.get<double>();
    return unexpected_value(element, value, text_of(parameter.valid));
  }
  const auto& words = parameter.words;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (value == words[i]) return static_cast<double>(i);
  }
  return unexpected_value(element, value, joined_words({words.begin(), words.end()}));
}

std::optional<Error> read_levels(const Json& list, const std::string& element,
                                 SweptParameter& swept) {
  const SweepParameter& parameter = sweep_parameters()[swept.parameter];
  const std::string expected = "a list of 2 to " + std::to_string(kMostLevels) + " levels";
  if (!list.is_array()) return unexpected_value(element, list, expected);
  if (list.size() < 2 || list.size() > kMostLevels) {
    return sweep_error(element,
                       "is a list of " + std::to_string(list.size()) + "; expected " + expected);
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string at = element + "/" + std::to_string(i);
    const auto level = read_level(list[i], at, parameter);
    if (!level) return level.error();
    if (std::find(swept.levels.begin(), swept.levels.end(), *level) != swept.levels.end()) {
      return sweep_error(at, "is " + sweep_value_text(swept.parameter, *level) +
                                 " again; expected each level once");
    }
    swept.levels.push_back(*level);
  }
  std::sort(swept.levels.begin(), swept.levels.end());
  return std::nullopt;
}

// The range of the hypercube: that of `literature`, or from the lowest to the highest level.
void set_range(const OperatorFile& literature, SweptParameter& swept) {
  swept.low = swept.levels.front();
  swept.high = swept.levels.back();
  const auto drawn = sweep_parameters()[swept.parameter].drawn;
  for (std::size_t i = 0; drawn && i < kPersonParameterCount; ++i) {
    if (person_parameters()[i].field != drawn) continue;
    swept.low = literature.ranges[i].low;
    swept.high = literature.ranges[i].high;
  }
}

void read_parameters(ObjectReader& reader, const OperatorFile& literature, Sweep& sweep) {
  const Json* const found = reader.find("parameters");
  if (!found) return;
  const std::string element = reader.element_of("parameters");
  ObjectReader parameters(*found, element);
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) {
    const std::string name(sweep_parameters()[i].name);
    const Json* const list = parameters.find(name.c_str(), ObjectReader::Key::kOptional);
    if (!list) continue;
    SweptParameter swept;
    swept.parameter = i;
    if (auto error = read_levels(*list, parameters.element_of(name), swept)) {
      parameters.fail(*error);
      continue;  // to ask for the other keys, which are then known
    }
    set_range(literature, swept);
    sweep.parameters.push_back(std::move(swept));
  }
  if (auto error = parameters.finish()) return reader.fail(*error);
  if (!sweep.parameters.empty()) return;
  reader.fail(sweep_error(element, "has no parameter; expected one or more"));
}

void read_hypercube(ObjectReader& reader, SweepHypercube& hypercube) {
  const Json* const found = reader.find("hypercube");
  if (!found) return;
  ObjectReader of(*found, reader.element_of("hypercube"));
  of.whole("points", hypercube.points, 2, kMostSweepPoints);
  of.whole("seed", hypercube.seed, 0, (std::uint64_t{1} << 53) - 1);
  of.whole("participants", hypercube.participants, 1, kMostParticipants);
  if (auto error = of.finish()) reader.fail(*error);
}

void check_counts(ObjectReader& reader, const Sweep& sweep) {
  if (!reader.ok()) return;
  const auto points = sweep_points(sweep);
  if (points.size() > static_cast<std::size_t>(kMostSweepPoints)) {
    return reader.fail(sweep_error("/hypercube/points",
                                   "gives a sweep of " + std::to_string(points.size()) +
                                       " points with those of /parameters; expected at most " +
                                       std::to_string(kMostSweepPoints),
                                   "divide it into several sweeps"));
  }
  std::uint64_t trials = 0;
  for (const SweepPoint& point : points) {
    trials += static_cast<std::uint64_t>(point.participants) * sweep.plan.trials_per_participant();
  }
  if (trials <= kMostTrials) return;
  reader.fail(sweep_error("/hypercube",
                          "gives a sweep of " + std::to_string(trials) +
                              " trials with those of /parameters; expected at most " +
                              std::to_string(kMostTrials),
                          "take fewer points or participants, or divide the sweep"));
}

// The hash of the content, with the canonical text of the base plan in place of the plan.
std::uint64_t hash_of(Json json, const Sweep& sweep, const OperatorFile& literature) {
  json.erase("plan");
  const std::string rest = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  return KeyHash().add(rest).add(sweep.plan.canonical).add(literature.hash).value();
}

}  // namespace

Result<Sweep> parse_sweep(std::string_view text, const std::string& path,
                          const std::string& folder) {
  const auto json = parse_strict_json(text, path);
  if (!json) return json.error();
  const auto literature = load_operator("literature");
  if (!literature) return literature.error();
  if (json->is_object() && json->contains("palpate_plan") && !json->contains("palpate_sweep")) {
    Error error = sweep_error("/palpate_plan", "is the key of a plan; expected palpate_sweep",
                              "`palpate experiment run` runs a plan");
    error.path = path;
    return error;
  }
  Sweep sweep;
  sweep.path = path;
  ObjectReader reader(*json, "");
  int format = 1;
  reader.whole("palpate_sweep", format, 1, 1);
  reader.text("name", sweep.name);
  read_base_plan(reader, path, folder, sweep);
  read_parameters(reader, *literature, sweep);
  read_hypercube(reader, sweep.hypercube);
  check_counts(reader, sweep);
  if (auto error = reader.finish()) {
    if (error->path.empty()) error->path = path;
    return *error;
  }
  for (const SweepPoint& point : sweep_points(sweep)) {
    if (auto error = check_operator(plan_at(sweep, point).person)) {
      return at_point(*error, sweep, point);
    }
  }
  sweep.hash = hash_of(*json, sweep, *literature);
  return sweep;
}

Result<Sweep> load_sweep(const std::string& name_or_path) {
  if (name_or_path == kShippedSweep) {
    const auto folder = models_folder();
    if (!folder) return folder.error();
    return parse_sweep(shipped_sweep_text(""), name_or_path, *folder);
  }
  const auto text = read_settings_text(name_or_path);
  if (!text) return text.error();
  return parse_sweep(*text, name_or_path, fs::path(name_or_path).parent_path().string());
}

}  // namespace palpate
