#pragma once

// The bounds of a scene that is placed in the device frame.

#include "engine/scene/scene.h"
#include "geometry/base/box.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// A box around all surfaces, in the device frame, metres. The scene must have a surface. O(vertices
// of the outermost nodes): the vertices of a node are skipped if its box lies inside the bounds
// found so far. Thread-safe.
Box bounds_in_device(const Scene& scene, const ScenePose& T_device_scene);

}  // namespace palpate
