#pragma once

// The cost of accuracy on a user's own scene: the time and the error of each preset while a
// simulated hand touches the scene, and the highest servo rate that this machine can keep.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/knob.h"
#include "engine/accuracy/measurement.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

// The results of a preset in the ticks in contact. Each time is a percentile of one repeat; its
// Spread has the median and the quartiles over the repeats.
struct PresetOnScene {
  std::string name;
  Spread p50_ns;
  Spread p99_ns;
  Spread worst_ns;
  double iterations = 0.0;
  std::uint64_t ticks = 0;  // ticks in contact, of all repeats
  std::uint64_t capped_ticks = 0;
  // The distance between the proxy of this preset and the proxy of the preset `exact` in the same
  // tick, evaluated over all hands.
  double rms_error_m = 0.0;
  double p99_error_m = 0.0;
  double worst_error_m = 0.0;
  double worst_force_error_N = 0.0;
};

// Trials of the haptic thread at one rate.
struct RateTrial {
  double rate_Hz = 0.0;
  int trials = 0;
  int kept = 0;               // trials that kept the rate
  std::uint64_t ticks = 0;    // of all trials
  std::uint64_t missed = 0;   // missed deadlines, of all trials
  std::int64_t worst_ns = 0;  // longest tick of all trials

  // A trial keeps the rate if its share of missed deadlines is at most this value. At 1 kHz, one
  // late tick in a thousand means that once a second a force is held for twice as long.
  static constexpr double kMostMissed = 1e-3;
  bool passed() const { return 2 * kept > trials; }
};

struct KeptRate {
  // One element per rate tried, in ascending order; the loop's own rate is one of those to try.
  // Above 1 kHz, the last element is the first rate that was not kept, if there is one.
  std::vector<RateTrial> trials;
  double by_trial_Hz = 0.0;  // the highest rate that passed; 0 if none did
  // 1 / (2 t), where t is the time that one tick in a thousand exceeds. At the rate 1 / (2 t), half
  // of the period is left for the device and the rest of the program.
  double by_computing_Hz = 0.0;
  std::string realtime_note;  // the real-time rights that the system did not grant

  double rate_Hz() const { return by_trial_Hz < by_computing_Hz ? by_trial_Hz : by_computing_Hz; }
};

struct SceneAccuracy {
  std::array<PresetOnScene, 3> presets;  // fast, balanced, exact
  int hands = 0;                         // number of hands, each with its own seed
  int repeats = 0;                       // number of repeats of each preset
  double seconds = 0.0;                  // duration of the path of each hand
  double contact_share = 0.0;            // share of the ticks in contact, over all hands
  double deepest_m = 0.0;  // lag that one tick in a hundred exceeds, under the preset `exact`
  double floor_m = 0.0;    // errors below it are meaningless: file_floor_m() of the scene
  KeptRate kept_rate;
  // A sentence if a hand begins inside a closed surface, which it then feels from inside; else
  // empty.
  std::string start_note;
};

// Simulated hands explore the scene with the settings of `setup` and the preset `exact`, and their
// paths are recorded. Then each preset in turn replays these paths. Returns an error if no hand
// touches the scene or if the rate of `setup` is not from 20 Hz to 20 kHz. Also returns the errors
// of explore(). Takes many seconds and starts haptic threads.
Result<SceneAccuracy> measure_scene(const Scene& scene, const RunSetup& setup,
                                    const MeasurementEffort& effort,
                                    const MeasuringProgress& progress);

// A knob whose levels are versions of the scene itself. In each version, all surfaces form one mesh
// without effects; this mesh has all triangles, or about a half of them, a quarter and so on.
// Returns no value if the scene has more triangles than kMostSimplified or too few, or if it does
// not compile as one mesh; `why` then states the reason.
std::optional<Knob> simplification_knob(const Scene& scene, const RunSetup& setup,
                                        const MeasurementEffort& effort, std::string& why);

inline constexpr std::size_t kMostSimplified = 2'000'000;

}  // namespace palpate
