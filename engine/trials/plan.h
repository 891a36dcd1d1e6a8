#pragma once

// The plan of an experiment: what `palpate experiment run` reads.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/trials/levels.h"
#include "engine/trials/live_plan.h"
#include "engine/trials/operator_file.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/trial.h"
#include "geometry/base/result.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// Limits of a plan. 2^18 rows of trials.csv take about 100 MB.
inline constexpr std::uint64_t kMostTrials = std::uint64_t{1} << 18;
inline constexpr int kMostParticipants = 10'000;
inline constexpr int kMostBlocks = 100;
inline constexpr std::size_t kMostPlanObjects = 100;
inline constexpr std::size_t kMostPlanStrategies = 100;
inline constexpr std::size_t kMostObjectNameBytes = 40;
inline constexpr std::size_t kMostPlanLevels = 100;  // of the view, start orientation and scale
// Of a trial, as of `run`: an hour at 1000 Hz. The limit bounds the time until a trial ends.
inline constexpr double kMostTrialTicks = 4e6;
// Faster than any display. Together with the longest delay of an operator file, the limit bounds
// the pictures that a simulated person has not seen yet.
inline constexpr NumberRange kDisplayRange_Hz{0.0, 1e4, true};

// The order of the conditions in a block.
enum class ConditionOrder : std::uint8_t {
  kRandom,   // every condition with every object, in random order
  kWilliams  // the conditions in the order of a Williams square; their objects in random order
};
inline constexpr std::array<std::string_view, 2> kConditionOrderNames = {"random", "williams"};
inline constexpr NumberRange kStartRange_deg{-360.0, 360.0};
inline constexpr NumberRange kScaleRange{0.0, 1e6, true};

// An object that the hand follows.
struct PlanObject {
  std::string name;  // letters, digits, "_", "-" and "."
  std::string file;  // as the plan states it: relative to the folder of the plan
  std::string path;  // of the file, from the current folder
  // node, listed_scene, feels_hidden, scale, fit_size_m, pose and close_gaps_m
  SceneSettings scene;
};

// The conditions of a trial, apart from its Following.
struct PlanCondition {
  std::size_t haptic = 0;    // index into kHapticLevels
  std::size_t rotation = 0;  // index into kRotationLevels
  std::size_t object = 0;    // index into ExperimentPlan::objects
  // Index into ExperimentPlan::strategies, which then stands in place of haptic and rotation.
  std::optional<std::size_t> strategy = {};
};

// A level of each setting that makes an experiment of its own: all variants of a plan have the same
// persons and random numbers.
struct PlanVariant {
  View view = View::kTurning;
  std::size_t start = 0;  // index into ExperimentPlan::start_orientation_deg
  std::size_t scale = 0;  // index into ExperimentPlan::scale
};

// A plan. Its JSON is an object with these keys; those in brackets are optional:
//   palpate_plan     1
//   name             text
//   seed             whole number, below 2^53
//   participants, blocks, practice_blocks (0 or 1)
//   device           the settings of `run` (plan_device.h)
//   display_Hz, sphere_radius_m, limit_s
//   haptic, rotation lists of one or more levels; or, in place of both:
//   strategies       a list of one or more names of strategies (parse_strategy), none twice
//   objects          {"O1": "star.glb"} or {"O1": {"file": "star.glb", ["node", "scale" or
//                    "fit_size_m", "scene", "feel_hidden", "pose", "close_gaps_m"]}}; `scene` is
//                    the number or the name of a scene of the file; paths are relative to the
//                    folder of the plan; a factor of `scale` below also multiplies close_gaps_m
//   operator         a name of kShippedOperators, or the path of an operator file
//   followings       a list of one or more of the first kTurningFollowings of kFollowingLevels.
//                    A person who sees the scene still has the other three instead; a plan
//                    without the view `turning` needs no followings
//   [align]          a name of kAlignmentLevels; `forward` is for one motor
//   [view]           a list of one or both of kViewLevels; [turning]
//   [start_orientation_deg]  a list of angles by which the scene is turned about A3 before the
//                    trial, deg; [0]
//   [scale]          a list of factors of the objects' size; the spheres keep their size; [1]
//   [order]          a name of kConditionOrderNames; `williams` needs an even number of conditions
//                    without their objects
//   [learning_exponent]  b: in block n, counted from 0 for practice, a person has
//                    speed_m_per_s times (n + 1)^b and intention_noise_m times (n + 1)^-b; [0]
//   [live]           what people see who take part (live_plan.h); the plan then has one view,
//                    turning, one start orientation and one scale, and no strategies
struct ExperimentPlan {
  std::string path;  // as the caller named it
  std::string name;
  std::uint64_t seed = 0;
  int participants = 1;
  int blocks = 1;
  int practice_blocks = 0;
  RunSettings device;
  TrialSettings trial;
  std::vector<std::size_t> haptic;    // indices into kHapticLevels
  std::vector<std::size_t> rotation;  // indices into kRotationLevels
  std::vector<Strategy> strategies;   // empty: haptic and rotation are not
  std::vector<PlanObject> objects;    // sorted by name
  OperatorFile person;
  std::vector<Following> followings;  // with View::kTurning
  std::vector<View> views = {View::kTurning};
  std::vector<double> start_orientation_deg = {0.0};
  std::vector<double> scale = {1.0};
  ConditionOrder order = ConditionOrder::kRandom;
  double learning_exponent = 0.0;
  std::optional<LivePlan> live;
  std::string text;  // of the file, byte by byte
  // The content of the plan without the parts that may differ between machines: the JSON with
  // sorted keys and with the name of the operator, without blanks and without paths of objects.
  // `hash` is its hash.
  std::string canonical;
  std::uint64_t hash = 0;

  // Haptic x rotation x object, or strategy x object, in the order of the lists.
  std::vector<PlanCondition> conditions() const;
  // The number of conditions without their objects.
  std::size_t level_count() const;
  // View x start orientation x scale, in the order of the lists.
  std::vector<PlanVariant> variants() const;
  std::vector<Following> followings_of(View view) const;
  // The levels of a condition without its object: "UaH-R"; "a4".
  std::string level_name(const PlanCondition& condition) const;
  // The numbers of the blocks; 0 is practice.
  std::vector<int> block_numbers() const;
  std::uint64_t trials_per_participant() const;
  // Sentences about what the plan leaves unbalanced.
  std::vector<std::string> warnings() const;
};

// An error if simulated persons cannot take part in the plan: they see no force.
std::optional<Error> check_simulable(const ExperimentPlan& plan);

// An error names the element, such as /device/rate_Hz. path: the path of the file, for messages.
// folder: the folder to which paths in the plan are relative; empty: the current folder. Reads the
// operator file, but no scene.
Result<ExperimentPlan> parse_plan(std::string_view text, const std::string& path,
                                  const std::string& folder);

// name_or_path: a plan that ships (kShippedPlans in paper_plan.h), or the path of a file.
Result<ExperimentPlan> load_plan(const std::string& name_or_path);

}  // namespace palpate
