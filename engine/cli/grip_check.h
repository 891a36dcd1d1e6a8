#pragma once

// Whether the hand of a plan with "force": "seen" stays calm at the surfaces of the plan.

#include <optional>
#include <vector>

#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "geometry/base/result.h"

namespace palpate {

// An error if the grip of the plan holds the simulated hand so that a surface of a scene is stiffer
// than kAutoPart of its stable limit, or so tightly that the motion of the hand cannot be computed
// at the rate of the plan. It states the damping, or the stiffness of the grip, that fits. scenes:
// of load_live_scenes(). Requires a grip.
std::optional<Error> check_grip(const ExperimentPlan& plan,
                                const std::vector<ExperimentScene>& scenes);

}  // namespace palpate
