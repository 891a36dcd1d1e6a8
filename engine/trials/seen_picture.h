#pragma once

// What the display shows of a scene that turns.

#include "engine/trials/levels.h"
#include "engine/trials/operator_parameters.h"
#include "geometry/base/types.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// One picture. Its coordinates are those of the device frame with View::kTurning; with View::kStill
// they are those of the device frame mapped by T_first T_now^-1. The scene then keeps its first
// pose, and what moves with the hand is turned back with the scene.
struct SeenPicture {
  ScenePose T_picture_scene;  // where the scene is shown: T_now, or T_first
  Vec3 proxy_scene_m;
  Vec3 device_scene_m;  // the device point

  // Where the two are shown, in the coordinates of the picture.
  Vec3 proxy_m() const { return T_picture_scene.point(proxy_scene_m); }
  Vec3 device_m() const { return T_picture_scene.point(device_scene_m); }
};

// T_first: the pose in the first picture. T_now: the pose of the scene in the device frame.
SeenPicture seen_picture(View view, const ScenePose& T_first, const ScenePose& T_now,
                         const Vec3& proxy_scene_m, const Vec3& device_scene_m);

// Whether the scene has another orientation than at first; it may have moved without turning.
bool has_turned(const ScenePose& T_first, const ScenePose& T_now);

// The angle about A3 by which the scene has turned since its first pose, for a device with 2
// sensors, in (-pi, pi] rad.
double turn_since_rad(const ScenePose& T_first, const ScenePose& T_now);

// What a person with View::kStill believes to be the pose of the scene (T_device_scene). In this
// view the hand and the device point in the picture move in different directions once the scene has
// turned. The believed pose maps the place where the person sees the device point in the scene to
// the place where the person feels the hand, and has the rotation of T_first, turned about A3 by
// the share a of the turn. Without a turn, and with a = 1, this is T_now, bit for bit.
//
// seen_scene_m: the device point as seen, scene frame. felt_device_m: the hand, device frame.
ScenePose adapted_pose(const ScenePose& T_first, const ScenePose& T_now, const Vec3& seen_scene_m,
                       const Vec3& felt_device_m, double share);

}  // namespace palpate
