#pragma once

// The levels of the conditions of a trial. Each is declared here once: its name in plans and
// tables, its meaning, and its value. Strategies are levels, too; their names are in strategy.h.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "haptics/a4/theoretical_rotation.h"
#include "haptics/strategies/haptic_settings.h"

namespace palpate {

template <class Value>
struct ConditionLevel {
  std::string_view name;
  std::string_view meaning;
  Value value;
};

// The levels of one condition. Names are looked up by the value, so that the value of each level
// must be its place (are_in_order).
template <class Value, std::size_t count>
using ConditionLevels = std::array<ConditionLevel<Value>, count>;

template <class Value, std::size_t count>
constexpr bool are_in_order(const ConditionLevels<Value, count>& levels) {
  for (std::size_t i = 0; i < count; ++i) {
    if (static_cast<std::size_t>(levels[i].value) != i) return false;
  }
  return true;
}

template <class Value, std::size_t count>
constexpr std::array<std::string_view, count> names_of(
    const ConditionLevels<Value, count>& levels) {
  std::array<std::string_view, count> names;
  for (std::size_t i = 0; i < count; ++i) names[i] = levels[i].name;
  return names;
}

// Each name with its meaning behind it, such as "NoH none, H all of it" with " " and ", ", of the
// first levels.
template <class Value, std::size_t count>
std::string meanings_of(const ConditionLevels<Value, count>& levels,
                        std::string_view before_meaning, std::string_view between,
                        std::size_t first = count) {
  std::string text;
  for (std::size_t i = 0; i < first; ++i) {
    if (!text.empty()) text += between;
    text.append(levels[i].name).append(before_meaning).append(levels[i].meaning);
  }
  return text;
}

// Haptic: the part of the force that is commanded. A seen force acts on a simulated hand that the
// person leads: the person sees it, and feels nothing.
enum class Haptic : std::uint8_t { kNone, kActuated, kFull, kSeenActuated, kSeenFull };
inline constexpr ConditionLevels<Haptic, 5> kHapticLevels = {
    {{"NoH", "none", Haptic::kNone},
     {"UaH", "along the actuated axes", Haptic::kActuated},
     {"H", "all of it", Haptic::kFull},
     {"seen-UaH", "as UaH on a simulated hand (seen but not felt)", Haptic::kSeenActuated},
     {"seen-H", "as H on a simulated hand (seen but not felt)", Haptic::kSeenFull}}};
inline constexpr auto kHapticNames = names_of(kHapticLevels);
// The first ones are those of simulated trials, and of devices; people's trials have all.
inline constexpr std::size_t kFeltHapticCount = 3;

constexpr bool is_seen_only(Haptic level) {
  return static_cast<std::size_t>(level) >= kFeltHapticCount;
}
constexpr ForceMode force_of(Haptic level) {
  if (level == Haptic::kNone) return ForceMode::kNone;
  const bool is_full = level == Haptic::kFull || level == Haptic::kSeenFull;
  return is_full ? ForceMode::kFull : ForceMode::kActuated;
}

// "commanded force: NoH none, UaH along the actuated axes, H all of it"
inline std::string haptic_meaning(std::size_t first) {
  return "commanded force: " + meanings_of(kHapticLevels, " ", ", ", first);
}

// Rotation: whether A4 turns the scene.
inline constexpr ConditionLevels<bool, 2> kRotationLevels = {
    {{"NoR", "without", false}, {"R", "with A4", true}}};
inline constexpr auto kRotationNames = names_of(kRotationLevels);
// "R with A4, NoR without"
inline std::string rotation_meaning() {
  return meanings_of(ConditionLevels<bool, 2>{kRotationLevels[1], kRotationLevels[0]}, " ", ", ");
}

// Align: the end of the motor's line that the contact normal turns to.
inline constexpr ConditionLevels<Alignment, 2> kAlignmentLevels = {
    {{"nearest", "the nearer end", Alignment::kNearest},
     {"forward", "the positive end", Alignment::kForward}}};
inline constexpr auto kAlignmentNames = names_of(kAlignmentLevels);

// View: what the display shows of a scene that turns (seen_picture.h).
enum class View : std::uint8_t { kTurning, kStill };
inline constexpr ConditionLevels<View, 2> kViewLevels = {
    {{"turning", "the scene as it turns in the device frame; the paper's people saw this",
      View::kTurning},
     {"still", "the scene in its first pose; the proxy and the device point move in its place",
      View::kStill}}};
inline constexpr auto kViewNames = names_of(kViewLevels);

// Following: what a simulated person believes about the pose of a scene that turns
// (operator_hand.h).
enum class Following : std::uint8_t {
  kDelayed,
  kPredict,
  kReplan,
  kFrozen,
  kAdaptsNone,
  kAdaptsHalf,
  kAdaptsWhole,
};
inline constexpr ConditionLevels<Following, 7> kFollowingLevels = {
    {{"delayed", "the pose in the newest picture that the person has seen", Following::kDelayed},
     {"predict", "that pose, turned about the seen proxy by the seen rate times the picture's age",
      Following::kPredict},
     {"replan", "a seen pose, held for replan_s", Following::kReplan},
     {"frozen", "the pose seen when contact was last lost or a corner last passed",
      Following::kFrozen},
     {"adapts-0", "the first pose, moved to where the person feels the hand",
      Following::kAdaptsNone},
     {"adapts-0.5", "the same, turned by half of the seen turn", Following::kAdaptsHalf},
     {"adapts-1", "the same, turned by the seen turn: the belief of delayed",
      Following::kAdaptsWhole}}};
inline constexpr auto kFollowingNames = names_of(kFollowingLevels);
// The first ones are for View::kTurning, the others for View::kStill.
inline constexpr std::size_t kTurningFollowings = 4;

inline View view_of(Following following) {
  return static_cast<std::size_t>(following) < kTurningFollowings ? View::kTurning : View::kStill;
}

// What a person with View::kStill adapts to: the share a of the seen turn by which the believed
// pose is turned. Requires one of the last three followings.
inline double adapted_share(Following following) {
  return 0.5 * (static_cast<int>(following) - static_cast<int>(Following::kAdaptsNone));
}

// Status: how a trial ended.
enum class TrialStatus : std::uint8_t { kDone, kTimeout, kFault, kAborted, kSkipped };
inline constexpr ConditionLevels<TrialStatus, 5> kTrialStatusLevels = {
    {{"done", "", TrialStatus::kDone},  // with a contact within the red sphere
     {"timeout", "the time limit was reached", TrialStatus::kTimeout},
     {"fault", "a fault ended the trial", TrialStatus::kFault},
     {"aborted", "the trial was cut and is repeated", TrialStatus::kAborted},
     {"skipped", "the experimenter left the trial out", TrialStatus::kSkipped}}};
inline constexpr auto kTrialStatusNames = names_of(kTrialStatusLevels);
// The first ones are those of simulated trials; people's trials have all.
inline constexpr std::size_t kSimulatedStatusCount = 3;

// Input: what moved the device point in a live trial.
enum class LiveInput : std::uint8_t { kMouse, kPen, kTouch, kBoard, kScript };
inline constexpr ConditionLevels<LiveInput, 5> kLiveInputLevels = {
    {{"mouse", "", LiveInput::kMouse},
     {"pen", "", LiveInput::kPen},
     {"touch", "", LiveInput::kTouch},
     {"board", "a hAPI board", LiveInput::kBoard},
     {"script", "a scripted participant", LiveInput::kScript}}};
inline constexpr auto kLiveInputNames = names_of(kLiveInputLevels);

// Motion: whether the browser let fast strokes of a pointer count for more than slow ones.
enum class PointerMotion : std::uint8_t { kUnaccelerated, kAccelerated, kUnknown };
inline constexpr ConditionLevels<PointerMotion, 3> kPointerMotionLevels = {
    {{"unaccelerated", "the length of a stroke alone counts", PointerMotion::kUnaccelerated},
     {"accelerated", "fast strokes count for more", PointerMotion::kAccelerated},
     {"unknown", "the input check could not tell", PointerMotion::kUnknown}}};
inline constexpr auto kPointerMotionNames = names_of(kPointerMotionLevels);

// Reason: why a live trial was aborted or skipped.
enum class CutReason : std::uint8_t {
  kFocus,
  kFullScreen,
  kPointerLock,
  kHidden,
  kLateTicks,
  kLateFrames,
  kTrip,
  kFault,
  kServer,
  kExperimenter,
  kParticipant,
  kLift
};
inline constexpr ConditionLevels<CutReason, 12> kCutReasonLevels = {
    {{"focus", "the page lost the focus", CutReason::kFocus},
     {"full_screen", "the page left full screen", CutReason::kFullScreen},
     {"pointer_lock", "the pointer was released", CutReason::kPointerLock},
     {"hidden", "the page was hidden", CutReason::kHidden},
     {"late_ticks", "ticks were later than the plan permits", CutReason::kLateTicks},
     {"late_frames", "pictures were later than the plan permits", CutReason::kLateFrames},
     {"trip", "the governor released the force", CutReason::kTrip},
     {"fault", "a fault of the engine", CutReason::kFault},
     {"server", "the program ended", CutReason::kServer},
     {"experimenter", "the experimenter asked for it", CutReason::kExperimenter},
     {"participant", "the participant asked for it", CutReason::kParticipant},
     {"lift", "pen or finger left the screen where the plan permits no clutch", CutReason::kLift}}};
inline constexpr auto kCutReasonNames = names_of(kCutReasonLevels);

static_assert(are_in_order(kHapticLevels) && are_in_order(kRotationLevels) &&
              are_in_order(kAlignmentLevels) && are_in_order(kViewLevels) &&
              are_in_order(kFollowingLevels) && are_in_order(kTrialStatusLevels) &&
              are_in_order(kLiveInputLevels) && are_in_order(kPointerMotionLevels) &&
              are_in_order(kCutReasonLevels));

}  // namespace palpate
