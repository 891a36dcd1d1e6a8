#pragma once

// The default height of the plane of a device with two sensors.

#include <optional>

#include "engine/scene/scene.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// The height along A3 of a plane that cuts the scene. The plane passes through the middle of the
// scene's extent along A3. If there is no contour in the middle, or a face lies in that plane, the
// plane passes through the nearest suitable height instead, inside the part of the scene found
// there: 1/64 of the extent inside, or half of that part's height if that is less. Returns nothing
// if every face of the scene is perpendicular to A3.
//
// Device frame, metres. O(triangles of all nodes). Thread-safe.
std::optional<double> height_with_contour_m(const Scene& scene, const ScenePose& T_device_scene);

}  // namespace palpate
