#pragma once

// Where the plane of a device with two sensors meets a scene.

#include <optional>

#include "engine/scene/scene.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// The height along A3 of a plane that cuts the scene: through the middle of its extent, or the
// nearest height that has a contour where there is none in the middle, or where a face lies in it.
// There it is a little inside of what begins at that height, by 1/64 of the extent or by half of it
// if that is less. Nothing if every face of the scene lies across A3.
//
// Device frame, metres. O(triangles of all nodes). Thread-safe.
std::optional<double> height_with_contour_m(const Scene& scene, const ScenePose& T_device_scene);

}  // namespace palpate
