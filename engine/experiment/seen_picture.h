#pragma once

// What the display shows of a scene that turns.

#include "engine/experiment/operator_parameters.h"
#include "geometry/base/types.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// One picture, in the coordinates of the picture: those of the device frame with View::kTurning.
struct SeenPicture {
  ScenePose T_picture_scene;  // where the scene is shown
  Vec3 proxy_m;               // where the proxy is shown
  Vec3 device_m;              // where the device point is shown
};

// Whether two poses are equal bit for bit, but for the sign of zeros.
inline bool is_same_pose(const ScenePose& a, const ScenePose& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation_m == b.translation_m;
}

// The picture that View::kStill shows in place of the turning one: the turning picture mapped by
// T_first T_now^-1, where T_now is the pose that the turning picture shows. The scene keeps its
// first pose, and what moves with the hand is turned back with the scene. Without a turn, the two
// pictures are equal bit for bit.
inline SeenPicture still_picture(const SeenPicture& turning, const ScenePose& T_first) {
  const ScenePose& T_now = turning.T_picture_scene;
  if (is_same_pose(T_now, T_first)) return turning;
  const auto turned_back = [&](const Vec3& p_m) { return T_first.point(T_now.inverse_point(p_m)); };
  return {T_first, turned_back(turning.proxy_m), turned_back(turning.device_m)};
}

// The angle about A3 by which the scene has turned since its first pose, for a device with 2
// sensors, in (-pi, pi] rad.
double turn_since_rad(const ScenePose& T_first, const ScenePose& T_now);

// What a person with View::kStill believes to be the pose of the scene (T_device_scene). In this
// view the hand and the device point in the picture move in different directions once the scene has
// turned. The believed pose maps the place where the person sees the device point in the scene to
// the place where the person feels the hand, and has the rotation of T_first, turned about A3 by
// the share a of the turn. Without a turn, it is T_now bit for bit; with a = 1, it is T_now to
// rounding.
//
// seen_scene_m: the device point as seen, scene frame. felt_device_m: the hand, device frame.
ScenePose adapted_pose(const ScenePose& T_first, const ScenePose& T_now, const Vec3& seen_scene_m,
                       const Vec3& felt_device_m, double share);

}  // namespace palpate
