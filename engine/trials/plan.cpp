#include "engine/trials/plan.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/key_hash.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/plan_device.h"
#include "engine/trials/plan_operator.h"
#include "engine/trials/strict_json.h"
#include "geometry/base/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Key = ObjectReader::Key;
namespace fs = std::filesystem;

constexpr NumberRange kLengthRange_m{0.0, 1.0, true};
constexpr NumberRange kLimitRange_s{0.0, 3600.0, true};

Error plan_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

template <std::size_t count>
std::vector<std::string_view> words_of(const std::array<std::string_view, count>& names) {
  return {names.begin(), names.end()};
}

bool is_object_name(const std::string& name) {
  constexpr const char* kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.";
  return !name.empty() && name.size() <= kMostObjectNameBytes && name.front() != '.' &&
         name.find_first_not_of(kAllowed) == std::string::npos;
}

// The number or the name of one of the scenes of a file.
void read_listed_scene(ObjectReader& reader, std::string& scene) {
  constexpr std::uint64_t kMostScenes = std::uint64_t{1} << 32;
  const Json* const value = reader.find("scene", Key::kOptional);
  if (!value) return;
  if (value->is_string()) return reader.text("scene", scene, Key::kOptional, kMostProseBytes);
  if (!value->is_number()) {
    return reader.fail(
        unexpected_value(reader.element_of("scene"), *value,
                         "the number of a scene of the file, or its name as a text"));
  }
  std::uint64_t number = 0;
  reader.whole("scene", number, 0, kMostScenes, Key::kOptional);
  scene = std::to_string(number);
}

// The value of an object: a file name, or an object with the settings of the scene.
std::optional<Error> read_scene(const Json& value, const std::string& element, PlanObject& object) {
  if (value.is_string()) {
    const Json wrapped{{"file", value}};
    ObjectReader reader(wrapped, element);
    reader.text("file", object.file, Key::kRequired, kMostProseBytes);
    auto error = reader.finish();
    if (error) error->element = element;
    return error;
  }
  ObjectReader reader(value, element);
  reader.text("file", object.file, Key::kRequired, kMostProseBytes);
  reader.text("node", object.scene.node, Key::kOptional, kMostProseBytes);
  read_listed_scene(reader, object.scene.listed_scene);
  reader.flag("feel_hidden", object.scene.feels_hidden, Key::kOptional);
  reader.text("pose", object.scene.pose, Key::kOptional, kMostProseBytes);
  std::optional<double> scale;
  std::optional<double> fit_size_m;
  constexpr NumberRange kSize{0.0, 1e6, true};
  reader.number("scale", scale, kSize);
  reader.number("fit_size_m", fit_size_m, kSize);
  reader.number("close_gaps_m", object.scene.close_gaps_m, kSize, Key::kOptional);
  if (scale && fit_size_m) {
    reader.fail(plan_error(element, "has both scale and fit_size_m; expected one of them"));
  }
  object.scene.scale = scale.value_or(1.0);
  object.scene.fit_size_m = fit_size_m.value_or(0.0);
  return reader.finish();
}

void read_objects(ObjectReader& reader, const std::string& folder, ExperimentPlan& plan) {
  const Json* const found = reader.find("objects");
  if (!found) return;
  const std::string element = reader.element_of("objects");
  if (!found->is_object() || found->empty() || found->size() > kMostPlanObjects) {
    const std::string expected = "an object with 1 to " + std::to_string(kMostPlanObjects) +
                                 " entries, such as {\"O1\": \"star.glb\"}";
    if (!found->is_structured()) return reader.fail(unexpected_value(element, *found, expected));
    return reader.fail(plan_error(
        element, "has " + std::to_string(found->size()) + " entries; expected " + expected));
  }
  for (const auto& [name, value] : found->items()) {
    if (!is_object_name(name)) {
      return reader.fail(plan_error(
          element, "has the name " + in_quotes(name) + "; expected 1 to " +
                       std::to_string(kMostObjectNameBytes) +
                       " letters, digits, \"_\", \"-\" or \".\", not beginning with \".\""));
    }
    PlanObject object;
    object.name = name;
    if (auto error = read_scene(value, element + "/" + name, object)) return reader.fail(*error);
    object.path = (fs::path(folder) / object.file).string();
    plan.objects.push_back(std::move(object));
  }
}

void read_device(ObjectReader& reader, ExperimentPlan& plan) {
  const Json* const found = reader.find("device");
  if (!found) return;
  auto device = read_plan_device(*found, reader.element_of("device"));
  if (!device) return reader.fail(device.error());
  plan.device = std::move(*device);
}

void read_protocol(ObjectReader& reader, ExperimentPlan& plan) {
  int format = 1;
  reader.whole("palpate_plan", format, 1, 1);
  reader.text("name", plan.name);
  reader.whole("seed", plan.seed, 0, (std::uint64_t{1} << 53) - 1);
  reader.whole("participants", plan.participants, 1, kMostParticipants);
  reader.whole("blocks", plan.blocks, 1, kMostBlocks);
  reader.whole("practice_blocks", plan.practice_blocks, 0, 1);
  reader.number("sphere_radius_m", plan.trial.sphere_radius_m, kLengthRange_m);
  reader.number("limit_s", plan.trial.limit_s, kLimitRange_s);
}

// A trial has a tick or more, and not too many.
void check_limit(ObjectReader& reader, const ExperimentPlan& plan) {
  const double ticks = plan.trial.limit_s * plan.device.rate_Hz;
  if (!reader.ok() || (ticks >= 1.0 && ticks <= kMostTrialTicks)) return;
  std::ostringstream text;
  text << "is " << plan.trial.limit_s << " s, or " << ticks << " ticks at the rate of the device, "
       << plan.device.rate_Hz << " Hz; expected 1 to " << kMostTrialTicks << " ticks";
  reader.fail(
      plan_error(reader.element_of("limit_s"), text.str(), "change limit_s or /device/rate_Hz"));
}

void read_display(ObjectReader& reader, ExperimentPlan& plan) {
  reader.number("display_Hz", plan.trial.display_Hz, kDisplayRange_Hz);
  if (!reader.ok()) return;
  std::ostringstream text;
  text << "is " << plan.trial.display_Hz << "; expected ";
  if (plan.trial.display_Hz > plan.device.rate_Hz) {
    text << "at most the rate of the device, " << plan.device.rate_Hz << " Hz";
  } else if (plan.trial.display_Hz * plan.trial.limit_s < 1.0) {
    text << "at least " << 1.0 / plan.trial.limit_s << " Hz, one picture within limit_s";
  } else {
    return;
  }
  reader.fail(plan_error(reader.element_of("display_Hz"), text.str()));
}

// Alignment is a setting of the device's rotation, and a key of the plan because it is a question
// that an experiment asks.
void read_align(ObjectReader& reader, ExperimentPlan& plan) {
  std::size_t place = 0;
  reader.choice("align", place, words_of(kAlignmentNames), Key::kOptional);
  if (!reader.ok()) return;
  plan.device.haptics.a4.align = static_cast<Alignment>(place);
  const auto setup = make_setup(plan.device);
  if (setup) return;
  Error error = as_plan_error(setup.error(), "");
  error.code = ErrorCode::kInvalidContent;
  reader.fail(error);
}

// A list of distinct numbers in a range.
void read_levels(ObjectReader& reader, const char* key, std::vector<double>& levels,
                 const NumberRange& range) {
  const Json* const found = reader.find(key, Key::kOptional);
  if (!found) return;
  const std::string element = reader.element_of(key);
  const std::string expected = "a list of 1 to " + std::to_string(kMostPlanLevels) + " numbers";
  if (!found->is_array()) return reader.fail(unexpected_value(element, *found, expected));
  if (found->empty() || found->size() > kMostPlanLevels) {
    return reader.fail(plan_error(
        element, "is a list of " + std::to_string(found->size()) + "; expected " + expected));
  }
  levels.clear();
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& level = (*found)[i];
    const std::string at = element + "/" + std::to_string(i);
    if (!level.is_number() || !range.contains(level.get<double>())) {
      return reader.fail(unexpected_value(at, level, text_of(range)));
    }
    if (std::find(levels.begin(), levels.end(), level.get<double>()) != levels.end()) {
      return reader.fail(plan_error(at, "is " + level.dump() + " again; expected each level once"));
    }
    levels.push_back(level.get<double>() + 0.0);  // no -0
  }
}

// The settings that make variants of the experiment.
void read_variants(ObjectReader& reader, ExperimentPlan& plan) {
  if (reader.find("view", Key::kOptional)) {
    std::vector<std::size_t> views;
    reader.choices("view", views, words_of(kViewNames));
    plan.views.clear();
    for (const std::size_t view : views) plan.views.push_back(static_cast<View>(view));
  }
  read_levels(reader, "start_orientation_deg", plan.start_orientation_deg, kStartRange_deg);
  read_levels(reader, "scale", plan.scale, kScaleRange);
}

void read_order(ObjectReader& reader, ExperimentPlan& plan) {
  std::size_t place = 0;
  reader.choice("order", place, words_of(kConditionOrderNames), Key::kOptional);
  plan.order = static_cast<ConditionOrder>(place);
  constexpr NumberRange kExponent{0.0, 1.0};
  reader.number("learning_exponent", plan.learning_exponent, kExponent, Key::kOptional);
  const std::size_t count = plan.level_count();
  if (!reader.ok() || plan.order == ConditionOrder::kRandom || count % 2 == 0) return;
  reader.fail(
      plan_error(reader.element_of("order"),
                 "is williams, but the plan has " + std::to_string(count) +
                     (count == 1 ? " condition" : " conditions") +
                     " without their objects; expected an even number",
                 "change the levels of " +
                     std::string(plan.strategies.empty() ? "haptic or rotation" : "strategies") +
                     ", or use the order random"));
}

bool sees_turning(const ExperimentPlan& plan) {
  return std::find(plan.views.begin(), plan.views.end(), View::kTurning) != plan.views.end();
}

// True if the plan has strategies, which then are read.
bool read_strategies(ObjectReader& reader, ExperimentPlan& plan) {
  const Json* const found = reader.find("strategies", Key::kOptional);
  if (!found) return false;
  const std::string element = reader.element_of("strategies");
  for (const char* const factor : {"haptic", "rotation"}) {
    if (!reader.find(factor, Key::kOptional)) continue;
    reader.fail(plan_error(element,
                           "is used together with " + std::string(factor) +
                               "; expected strategies, or haptic and rotation",
                           "leave out haptic and rotation"));
  }
  const std::string expected = "a list of 1 to " + std::to_string(kMostPlanStrategies) +
                               " strategies, such as [\"mask\", \"a4\"]";
  if (!found->is_array()) {
    reader.fail(unexpected_value(element, *found, expected));
    return true;
  }
  if (found->empty() || found->size() > kMostPlanStrategies) {
    reader.fail(plan_error(
        element, "is a list of " + std::to_string(found->size()) + "; expected " + expected));
  }
  for (std::size_t i = 0; reader.ok() && i < found->size(); ++i) {
    const std::string at = element + "/" + std::to_string(i);
    const Json& name = (*found)[i];
    if (!name.is_string()) {
      reader.fail(unexpected_value(at, name, "the name of a strategy"));
      return true;
    }
    const auto strategy = parse_strategy(name.get<std::string>());
    if (!strategy) {
      reader.fail(plan_error(at, strategy.error().problem, strategy.error().hint));
    } else if (std::find(plan.strategies.begin(), plan.strategies.end(), *strategy) !=
               plan.strategies.end()) {
      reader.fail(
          plan_error(at, "is " + name_of(*strategy) + " again; expected each strategy once"));
    } else {
      plan.strategies.push_back(*strategy);
    }
  }
  return true;
}

void read_factors(ObjectReader& reader, ExperimentPlan& plan) {
  if (!read_strategies(reader, plan)) {
    reader.choices("haptic", plan.haptic, words_of(kHapticNames));
    reader.choices("rotation", plan.rotation, words_of(kRotationNames));
  }
  if (!sees_turning(plan) && !reader.find("followings", Key::kOptional)) return;
  std::vector<std::size_t> followings;
  std::vector<std::string_view> names = words_of(kFollowingNames);
  names.resize(kTurningFollowings);
  reader.choices("followings", followings, names);
  for (const std::size_t place : followings) {
    plan.followings.push_back(static_cast<Following>(place));
  }
}

// A pointer cannot push, and only people see. Which levels a board renders depends on its motors,
// which are known when it is opened.
void check_haptic_levels(ObjectReader& reader, const ExperimentPlan& plan) {
  const bool is_seen = plan.live && plan.live->grip;
  const bool is_pointer = plan.live && plan.live->input == PlanInput::kPointer;
  const std::string expected = is_seen      ? "NoH, seen-UaH or seen-H"
                               : is_pointer ? "NoH"
                                            : "NoH, UaH or H";
  bool has_seen = false;
  for (std::size_t i = 0; i < plan.haptic.size(); ++i) {
    const Haptic level = kHapticLevels[plan.haptic[i]].value;
    has_seen = has_seen || is_seen_only(level);
    const bool fits = is_seen_only(level) ? is_seen : !is_pointer;
    if (level == Haptic::kNone || fits) continue;
    const char* const why = is_seen_only(level) ? ", which needs \"force\": \"seen\" in /live"
                                                : ", which a mouse, pen or finger cannot render";
    return reader.fail(plan_error(
        reader.element_of("haptic") + "/" + std::to_string(i),
        "is " + std::string(kHapticNames[plan.haptic[i]]) + why + "; expected " + expected,
        is_pointer && !is_seen_only(level)
            ? "leave the level out, or state \"board\" in /live/input"
            : "leave the level out, or state force and grip in /live"));
  }
  if (!is_seen || has_seen) return;
  reader.fail(plan_error(reader.element_of("haptic"),
                         "has no seen level; expected seen-UaH or seen-H among them, because "
                         "/live/force is seen",
                         "add a level, or leave force and grip out"));
}

void read_live(ObjectReader& reader, const std::string& folder, ExperimentPlan& plan) {
  const Json* const found = reader.find("live", Key::kOptional);
  if (!found) return;
  const std::string element = reader.element_of("live");
  auto live = read_live_plan(*found, element, folder);
  if (!live) return reader.fail(live.error());
  plan.live = std::move(*live);
  if (!plan.strategies.empty()) {
    return reader.fail(plan_error(element,
                                  "is in a plan with strategies; expected haptic and "
                                  "rotation"));
  }
  if (plan.variants().size() != 1 || plan.views.front() != View::kTurning) {
    return reader.fail(plan_error(
        element,
        "is in a plan with several views, start orientations or scales, or with another "
        "view than turning; expected one of each: a person takes part in one experiment"));
  }
  if (plan.live->has_questionnaire && plan.order != ConditionOrder::kWilliams) {
    return reader.fail(plan_error(element + "/questionnaire",
                                  "is true in a plan with the order random; expected the order "
                                  "williams, in which the trials of a condition follow each other",
                                  "state \"order\": \"williams\", or leave the questionnaire out"));
  }
}

void check_trials(ObjectReader& reader, const ExperimentPlan& plan) {
  if (!reader.ok()) return;
  const std::uint64_t trials =
      static_cast<std::uint64_t>(plan.participants) * plan.trials_per_participant();
  if (trials <= kMostTrials) return;
  reader.fail(plan_error("/participants",
                         "gives a plan of " + std::to_string(trials) +
                             " trials; expected at most " + std::to_string(kMostTrials),
                         "divide it into several plans with different seeds"));
}

std::string canonical_text(Json json, const ExperimentPlan& plan) {
  json["operator"] = plan.person.name;
  for (auto& [name, value] : json["objects"].items()) {
    if (value.is_object()) {
      value.erase("file");
    } else {
      value = Json::object();
    }
  }
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace

std::vector<PlanCondition> ExperimentPlan::conditions() const {
  std::vector<PlanCondition> all;
  for (std::size_t s = 0; s < strategies.size(); ++s) {
    for (std::size_t o = 0; o < objects.size(); ++o) all.push_back({0, 0, o, s});
  }
  for (const std::size_t h : haptic) {
    for (const std::size_t r : rotation) {
      for (std::size_t o = 0; o < objects.size(); ++o) all.push_back({h, r, o});
    }
  }
  return all;
}

std::string ExperimentPlan::level_name(const PlanCondition& condition) const {
  if (condition.strategy) return name_of(strategies[*condition.strategy]);
  return std::string(kHapticNames[condition.haptic]) + "-" +
         std::string(kRotationNames[condition.rotation]);
}

std::vector<int> ExperimentPlan::block_numbers() const {
  std::vector<int> numbers;
  for (int block = practice_blocks > 0 ? 0 : 1; block <= blocks; ++block) numbers.push_back(block);
  return numbers;
}

std::uint64_t ExperimentPlan::trials_per_participant() const {
  std::uint64_t followings_of_views = 0;
  for (const View view : views) followings_of_views += followings_of(view).size();
  return followings_of_views * start_orientation_deg.size() * scale.size() *
         block_numbers().size() * level_count() * objects.size();
}

std::size_t ExperimentPlan::level_count() const {
  return strategies.empty() ? haptic.size() * rotation.size() : strategies.size();
}

std::vector<PlanVariant> ExperimentPlan::variants() const {
  std::vector<PlanVariant> all;
  for (const View view : views) {
    for (std::size_t start = 0; start < start_orientation_deg.size(); ++start) {
      for (std::size_t size = 0; size < scale.size(); ++size) all.push_back({view, start, size});
    }
  }
  return all;
}

std::vector<Following> ExperimentPlan::followings_of(View view) const {
  if (view == View::kTurning) return followings;
  return {Following::kAdaptsNone, Following::kAdaptsHalf, Following::kAdaptsWhole};
}

std::vector<std::string> ExperimentPlan::warnings() const {
  std::vector<std::string> sentences;
  if (!sees_turning(*this) && !followings.empty()) {
    sentences.emplace_back(
        "followings: is not used, because they are for the view turning; with the view still, "
        "persons adapt to the turn by none, half or all of it");
  }
  const int rows = static_cast<int>(level_count());
  if (order == ConditionOrder::kRandom || participants % rows == 0) return sentences;
  const int rest = participants % rows;
  sentences.push_back(
      "participants: is " + std::to_string(participants) + ", which is no multiple of " +
      std::to_string(rows) + ", the number of conditions; in each block " + std::to_string(rest) +
      " of the " + std::to_string(rows) + " orders of the Williams square " +
      (rest == 1 ? "is" : "are") + " used " + std::to_string(participants / rows + 1) +
      (participants < rows ? " time" : " times") + " and the others " +
      std::to_string(participants / rows) +
      ", so that places and successions of conditions are not balanced");
  return sentences;
}

std::optional<Error> check_simulable(const ExperimentPlan& plan) {
  if (!plan.live || !plan.live->grip) return std::nullopt;
  return Error{ErrorCode::kUnsupported, plan.path, "/live/force",
               "is seen, which only people see; expected a plan without it for simulated persons",
               "`palpate experiment live` without --script runs it"};
}

Result<ExperimentPlan> parse_plan(std::string_view text, const std::string& path,
                                  const std::string& folder) {
  const auto json = parse_strict_json(text, path);
  if (!json) return json.error();
  if (json->is_object() && json->contains("palpate_sweep") && !json->contains("palpate_plan")) {
    return Error{ErrorCode::kInvalidContent, path, "/palpate_sweep",
                 "is the key of a sweep; expected palpate_plan",
                 "`palpate experiment sweep` runs a sweep"};
  }
  ExperimentPlan plan;
  plan.path = path;
  plan.text = text;
  ObjectReader reader(*json, "");
  read_protocol(reader, plan);
  read_device(reader, plan);
  read_align(reader, plan);
  check_limit(reader, plan);
  read_display(reader, plan);
  read_variants(reader, plan);
  read_factors(reader, plan);
  read_order(reader, plan);
  read_objects(reader, folder, plan);
  read_plan_operator(reader, folder, plan.person);
  read_live(reader, folder, plan);
  check_haptic_levels(reader, plan);
  check_trials(reader, plan);
  if (auto error = reader.finish()) {
    if (error->path.empty()) error->path = path;
    return *error;
  }
  plan.canonical = canonical_text(*json, plan);
  plan.hash = KeyHash().add(plan.canonical).value();
  return plan;
}

Result<ExperimentPlan> load_plan(const std::string& name_or_path) {
  if (is_shipped_plan(name_or_path)) {
    const auto folder = models_folder();
    if (!folder) return folder.error();
    return parse_plan(shipped_plan_text(name_or_path, ""), name_or_path, *folder);
  }
  const auto text = read_settings_text(name_or_path);
  if (!text) return text.error();
  return parse_plan(*text, name_or_path, fs::path(name_or_path).parent_path().string());
}

}  // namespace palpate
