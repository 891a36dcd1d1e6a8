#pragma once

// The outlines that a hand can reach in the plane of a device with two sensors.

#include <vector>

#include "engine/scene/scene.h"
#include "engine/simulation/outline.h"
#include "geometry/base/result.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// The outlines of the section of a scene, in the scene frame; longest first, at least one. For a
// sphere, only the parts of the outlines that the sphere can touch. plane_height_m: height of the
// plane along A3, device frame. small_m: open ends nearer to each other than this distance are
// joined (outline.h). proxy_radius_m: 0 for a point. Thread-safe; allocates.
//
// Errors: the plane does not cut the scene; too many curves cross each other.
Result<std::vector<Outline>> reachable_outlines(const Scene& scene, const ScenePose& T_device_scene,
                                                double plane_height_m, double small_m,
                                                double proxy_radius_m);

}  // namespace palpate
