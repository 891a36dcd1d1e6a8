#pragma once

// One trial of the experiment: a simulated person follows the contour of an object from the green
// to the red sphere.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/hand_path.h"
#include "engine/simulation/simulated_device.h"
#include "engine/trials/levels.h"
#include "engine/trials/operator_parameters.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// The settings that all trials of a plan share.
struct TrialSettings {
  double display_Hz = 40.0;        // pictures per second
  double sphere_radius_m = 0.006;  // of the green and the red sphere
  double limit_s = 120.0;          // a trial that takes longer ends with the status timeout
};

// The way of a trial in the plane of the device: a closed contour, opened shortly before the green
// sphere. Scene frame; lengths are along the path.
struct TrialWay {
  HandPath path;  // once round the contour and past its opening, with material on the left
  double green_along_m = 0.0;  // centre of the green sphere
  double red_along_m = 0.0;    // centre of the red sphere, beyond the green one
  Vec3 green_m = Vec3::Zero();
  Vec3 red_m = Vec3::Zero();
};

// Finds the way of trials on this scene. The node's palpate_contour states the centres of the
// spheres; without it the spheres are on the longest wall. setup: the setup of a device with two
// sensors; its plane height is the height of the contour. The error names the element of the scene.
Result<TrialWay> find_trial_way(const Scene& scene, const RunSetup& setup,
                                const TrialSettings& settings);

// The device of the setup in the hand of a person. noise_seed: seed of the hand's noise.
PlantSettings plant_of(const RunSetup& setup, const OperatorParameters& person,
                       std::uint64_t noise_seed);

// The conditions of one trial.
struct TrialConditions {
  ForceMode force = ForceMode::kActuated;
  bool a4 = false;
  Following following = Following::kDelayed;
  std::uint64_t noise_seed = 0;
  std::optional<Strategy> strategy = {};  // in place of force and a4
};

// The outcome of a trial.
struct TrialOutcome {
  TrialStatus status = TrialStatus::kDone;
  std::array<std::optional<double>, kMeasureCount> measures;
  std::uint64_t ticks = 0;   // computed in this trial, before and after the start of the clock
  std::int64_t loop_ns = 0;  // computing time of the haptic loop in these ticks; measured
};

// Called with the record of every tick of a trial, in simulated time: it may do I/O, but must not
// throw.
using TrialSink = std::function<void(const TickRecord&)>;

// Runs one trial in simulated time. The same arguments give the same outcome to the bit, except
// loop_ns: no trial depends on trials before it. setup: as for find_trial_way(); its force mode,
// A4 and strategy are replaced by the conditions. sink: may be empty. Thread-safe: any number of
// threads may run trials on one scene.
//
// Errors: those of check_setup() and check_plant(), which do not depend on the seed.
// They depend on the conditions only through the strategy.
Result<TrialOutcome> run_trial(const Scene& scene, const TrialWay& way, const RunSetup& setup,
                               const TrialSettings& settings, const OperatorParameters& person,
                               const TrialConditions& conditions, const TrialSink& sink = {});

}  // namespace palpate
