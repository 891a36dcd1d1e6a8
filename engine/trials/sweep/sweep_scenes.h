#pragma once

// The scenes of a sweep, loaded once for each scale and shared by all points.

#include <map>
#include <vector>

#include "engine/trials/experiment_scene.h"
#include "engine/trials/sweep/sweep_points.h"
#include "geometry/base/result.h"

namespace palpate {

// The scenes of the base plan, by scale.
using SweepScenes = std::map<double, std::vector<ExperimentScene>>;

// Loads every object of the base plan in every scale of the points, and checks every point on its
// scenes: no later step finds an error in the settings of a trial. Errors: those of
// load_experiment_scenes(), make_setup(), check_setup() and check_persons(), as errors of the sweep
// (at_point).
Result<SweepScenes> load_sweep_scenes(const Sweep& sweep, const std::vector<SweepPoint>& points,
                                      const TrialFunctions& functions);

// Trials with the device of a point's plan. The setup that they receive only states the pose and
// the height of the plane. plan: a plan of load_sweep_scenes().
TrialFunctions with_device_of(const ExperimentPlan& plan, const TrialFunctions& functions);

}  // namespace palpate
