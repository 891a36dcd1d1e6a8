#pragma once

// What accuracy costs on a user's own scene: the time and the error of each preset under a
// simulated hand, and how fast the servo loop can run on this machine.

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

// Of ticks in contact. Times: the median over the repeats of what one repeat has, and its spread.
struct PresetOnScene {
  std::string name;
  Spread p50_ns;
  Spread p99_ns;
  Spread worst_ns;
  double iterations = 0.0;
  std::uint64_t ticks = 0;  // in contact, of all repeats
  std::uint64_t capped_ticks = 0;
  // Distance of its proxy to that of the preset exact in the same tick, over all hands.
  double rms_error_m = 0.0;
  double p99_error_m = 0.0;
  double worst_error_m = 0.0;
  double worst_force_error_N = 0.0;
};

// The haptic thread at a rate, for some moments.
struct RateTrial {
  double rate_Hz = 0.0;
  int trials = 0;
  int kept = 0;               // of them
  std::uint64_t ticks = 0;    // of all trials
  std::uint64_t missed = 0;   // deadlines
  std::int64_t worst_ns = 0;  // tick

  // Of the ticks of a trial that keeps the rate. One late tick in a thousand is a force held twice
  // as long once a second at 1 kHz.
  static constexpr double kMostMissed = 1e-3;
  bool passed() const { return 2 * kept > trials; }
};

struct KeptRate {
  std::vector<RateTrial>
      trials;                // in ascending order; of those above 1 kHz, to the first that failed
  double by_trial_Hz = 0.0;  // the fastest that passed; 0 if none did
  // Half of the period is left to the device and the rest of the program: 1 / (2 t), t what one
  // tick in a thousand takes longer than.
  double by_computing_Hz = 0.0;
  std::string realtime_note;  // what the system did not grant

  double rate_Hz() const { return by_trial_Hz < by_computing_Hz ? by_trial_Hz : by_computing_Hz; }
};

struct SceneAccuracy {
  std::array<PresetOnScene, 3> presets;  // fast, balanced, exact
  int hands = 0;                         // different seeds
  int repeats = 0;                       // of each preset
  double seconds = 0.0;                  // of a hand
  double contact_share = 0.0;            // of its ticks
  double deepest_m = 0.0;                // lag under exact, which one tick in a hundred exceeds
  double floor_m = 0.0;  // errors below it say nothing: float_floor_m() of the scene
  KeptRate kept_rate;
};

// Hands wander over the scene with the settings of `setup`, recorded under the preset exact; then
// their paths are replayed under each preset in turn. An error if no hand touches anything, or as
// of explore(). Takes seconds; runs the haptic thread.
Result<SceneAccuracy> measure_scene(const Scene& scene, const RunSetup& setup,
                                    const StudyEffort& effort, const MeasuringProgress& progress);

// The scene's own surface at fewer triangles, as a knob: all of it in one mesh, simplified to a
// half, a quarter and so on, without its effects. Nothing if it has too many triangles for that
// (kMostSimplified), too few, or cannot be touched so; `why` says which.
std::optional<Knob> simplification_knob(const Scene& scene, const RunSetup& setup,
                                        const StudyEffort& effort, std::string& why);

inline constexpr std::size_t kMostSimplified = 2'000'000;

}  // namespace palpate
