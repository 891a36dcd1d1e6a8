#pragma once

// The object `live` of a plan: what `palpate experiment live` shows to a person, and its limits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/devices/stability_limits.h"  // HandImpedance
#include "engine/session/number_range.h"
#include "engine/trials/strict_json.h"
#include "geometry/base/result.h"

namespace palpate {

// With what the person moves the device point.
enum class PlanInput : std::uint8_t {
  kPointer,  // a mouse, a pen or a finger on the page; it cannot push
  kBoard     // a device with motors
};
inline constexpr std::array<std::string_view, 2> kPlanInputNames = {"mouse", "board"};

// The texts of the course, in the order in which a person reads them.
enum class LiveText : std::uint8_t { kInformation, kConsent, kInstructions, kDebriefing };
inline constexpr std::size_t kLiveTextCount = 4;
inline constexpr std::array<std::string_view, kLiveTextCount> kLiveTextNames = {
    "information", "consent", "instructions", "debriefing"};
inline constexpr std::uint64_t kMostLiveTextBytes = std::uint64_t{1} << 20;
// Of a file that has all of them as JSON, with its escapes.
inline constexpr std::uint64_t kMostTextsFileBytes = 2 * kLiveTextCount * kMostLiveTextBytes;

// What a person may be asked before the first trial.
inline constexpr std::array<std::string_view, 4> kAboutNames = {"age", "gender", "hand",
                                                                "experience"};

inline constexpr NumberRange kDisplayScaleRange{0.0, 100.0, true};
inline constexpr NumberRange kGripStiffnessRange_N_per_m{0.0, 1e5, true};
inline constexpr NumberRange kGripDampingRange_Ns_per_m{0.0, 1e4};
inline constexpr NumberRange kGripMassRange_kg{0.0, 100.0};
inline constexpr NumberRange kBreakRange_s{0.0, 3600.0};
inline constexpr NumberRange kLongestPictureRange_s{0.0, 10.0, true};
inline constexpr NumberRange kLongestLatenessRange_s{0.0, 10.0, true};

// JSON:
//   input        a name of kPlanInputNames
//   texts        {"information": TEXT, "consent": TEXT, "instructions": TEXT, "debriefing": TEXT};
//                TEXT is a text, or {"file": PATH}, relative to the folder of the plan; a text is
//                shown as it is, also what looks like tags; a blank line begins a paragraph
//   [force]      "seen": the pointer leads a simulated hand by the grip, and the engine's force
//                acts on that hand; the levels of haptic are NoH, seen-UaH and seen-H, one of them
//                seen; needs the input mouse
//   [grip]       {"stiffness_N_per_m": N, "damping_Ns_per_m": N, "mass_kg": N} of that hand, which
//                a plan with "force" must have, and no other
//   [words]      {KEY: TEXT}: the words of the participant's page, for a translation
//   [language]   a tag of BCP 47; ["en"]
//   [direction]  "ltr" or "rtl"; ["ltr"]
//   [scale]      size on the screen divided by the size in the device frame; [1]
//   [break_s]    length of the break between two blocks; [30]
//   [about]      a list of names of kAboutNames; [none]
//   [questionnaire]  the person rates each condition of a block (questionnaire_file.h); this needs
//                the order williams, in which the trials of a condition follow each other; [false]
//   [clutch]     the hand may be set back out of contact (engine/live/clutch.h); only with input
//                mouse; [false]
//   [blind]      the experimenter's page hides the condition; [false]
//   [longest_picture_s]   a trial in which the page draws no picture for longer is aborted; [0.25]
//   [longest_lateness_s]  so is one with a tick that begins later than this; [0.1]
struct LivePlan {
  PlanInput input = PlanInput::kPointer;
  // Of the hand that the pointer leads ("force": "seen"); no value: a pointer moves the device
  // point itself.
  std::optional<HandImpedance> grip;
  std::array<std::string, kLiveTextCount> texts;  // UTF-8, by LiveText
  std::map<std::string, std::string> words;
  std::string language = "en";
  bool is_right_to_left = false;
  double scale = 1.0;
  double break_s = 30.0;
  std::vector<std::string> about;
  bool has_questionnaire = false;
  bool permits_clutch = false;
  bool is_blind = false;
  double longest_picture_s = 0.25;
  double longest_lateness_s = 0.1;

  const std::string& text(LiveText which) const { return texts[static_cast<std::size_t>(which)]; }
};

// Reads the object. element: its JSON path. folder: as for parse_plan().
Result<LivePlan> read_live_plan(const nlohmann::json& live, const std::string& element,
                                const std::string& folder);

}  // namespace palpate
