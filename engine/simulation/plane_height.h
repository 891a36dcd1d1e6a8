#pragma once

// The default height of the plane of a device with two sensors.

#include <optional>

#include "engine/scene/scene.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// The height along A3 of a plane that cuts the scene. The plane passes through the middle of the
// scene's extent along A3. If this plane has no contour, or if a face lies in it, the plane is
// moved to the nearest part of the extent that has contours. The plane is then inside this part.
// Its distance from the end of the part is 1/64 of the scene's extent along A3, or half of the
// part's height if that is less. Returns no value if every face of the scene is perpendicular to
// A3.
//
// Device frame, metres. O(triangles of all nodes). Thread-safe.
std::optional<double> height_with_contour_m(const Scene& scene, const ScenePose& T_device_scene);

}  // namespace palpate
