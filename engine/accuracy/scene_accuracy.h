#pragma once

// The cost of accuracy on a user's own scene: the time and the error of each preset under a
// simulated hand, and the highest servo rate that this machine keeps.

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

// A preset in the ticks in contact. Times: median and quartiles over the repeats of the percentile
// in one repeat.
struct PresetOnScene {
  std::string name;
  Spread p50_ns;
  Spread p99_ns;
  Spread worst_ns;
  double iterations = 0.0;
  std::uint64_t ticks = 0;  // in contact, of all repeats
  std::uint64_t capped_ticks = 0;
  // Distance between its proxy and that of the preset exact in the same tick, over all hands.
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
  std::uint64_t missed = 0;   // deadlines
  std::int64_t worst_ns = 0;  // tick

  // The largest share of missed deadlines in a trial that keeps the rate. At 1 kHz, one late tick
  // in a thousand holds a force for twice as long once a second.
  static constexpr double kMostMissed = 1e-3;
  bool passed() const { return 2 * kept > trials; }
};

struct KeptRate {
  std::vector<RateTrial> trials;  // in ascending order; above 1 kHz up to the first failure
  double by_trial_Hz = 0.0;       // the highest rate that passed; 0 if none did
  // 1 / (2 t), where one tick in a thousand takes longer than t: half of the period is left for the
  // device and the rest of the program.
  double by_computing_Hz = 0.0;
  std::string realtime_note;  // the real-time rights that the system did not grant

  double rate_Hz() const { return by_trial_Hz < by_computing_Hz ? by_trial_Hz : by_computing_Hz; }
};

struct SceneAccuracy {
  std::array<PresetOnScene, 3> presets;  // fast, balanced, exact
  int hands = 0;                         // different seeds
  int repeats = 0;                       // of each preset
  double seconds = 0.0;                  // of a hand
  double contact_share = 0.0;            // of its ticks
  double deepest_m = 0.0;                // the lag under exact that one tick in a hundred exceeds
  double floor_m = 0.0;  // errors below it are meaningless: file_floor_m() of the scene
  KeptRate kept_rate;
};

// Hands wander over the scene with the settings of `setup`, recorded under the preset exact; then
// each preset in turn replays their paths. An error if no hand touches the scene, or as of
// explore(). Takes seconds; runs the haptic thread.
Result<SceneAccuracy> measure_scene(const Scene& scene, const RunSetup& setup,
                                    const MeasurementEffort& effort,
                                    const MeasuringProgress& progress);

// A knob that simplifies the scene's own surface: all surfaces in one mesh, simplified to a half, a
// quarter and so on, without effects. Nothing if the scene has too many triangles (kMostSimplified)
// or too few, or does not compile as one mesh; `why` states the reason.
std::optional<Knob> simplification_knob(const Scene& scene, const RunSetup& setup,
                                        const MeasurementEffort& effort, std::string& why);

inline constexpr std::size_t kMostSimplified = 2'000'000;

}  // namespace palpate
