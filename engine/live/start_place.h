#pragma once

// Where the device point of a person is when a trial begins.

#include "engine/scene/scene.h"
#include "engine/trials/trial.h"
#include "geometry/base/result.h"

namespace palpate {

// A point outside the objects, beside the green sphere: on the line from its centre away from the
// wall, two radii of the sphere away, or in the middle between this wall and the next one if that
// is nearer. Scene frame. Error: the point lies within an object.
Result<Vec3> start_place_m(const Scene& scene, const TrialWay& way, double sphere_radius_m);

}  // namespace palpate
