#pragma once

// Where a scene is once it is placed in the frame of a device.

#include "engine/scene/scene.h"
#include "geometry/base/box.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// Around all surfaces, device frame. The scene has one. O(vertices of the outermost nodes): a node
// whose box lies inside of what has been found is not looked at any closer. Thread-safe.
Box bounds_in_device(const Scene& scene, const ScenePose& T_device_scene);

}  // namespace palpate
