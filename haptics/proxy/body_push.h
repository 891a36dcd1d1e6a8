#pragma once

// The push of the proxy by a moving body, which never passes through the proxy.

#include <optional>

#include "haptics/proxy/live_world.h"
#include "haptics/proxy/motion_plane.h"
#include "haptics/proxy/segment_tracer.h"

namespace palpate {

// The motion of one body in one tick.
struct Push {
  std::uint32_t body = 0;
  RigidTransform T_solver_body;  // target pose
  bool carries = false;  // friction holds the proxy on the body: the proxy moves along if possible
  std::optional<MotionPlane> motion_plane = {};  // in which the proxy moves
  Vec3 plane_point = Vec3::Zero();               // a point of the plane of motion, solver frame, m
};

// Moves a body from its present pose in the world to push.T_solver_body. If the body would hit the
// proxy, the proxy is displaced by the smallest distance that avoids this. Seen from the body, the
// proxy moves along a straight segment that is free of the body's triangles. The body may therefore
// move and turn arbitrarily far in one tick without passing through the proxy. The proxy is not
// pushed through any other body either. With a plane of motion, the proxy is pushed within that
// plane. proxy: solver frame, m.
//
// Returns false if there is no space for the proxy, for example between the moving body and an
// obstacle, or if too many bodies move (LiveWorld::place). The body and the proxy then stay where
// they were.
//
// Safe on the haptic thread: no allocation, lock or exception. Not thread-safe.
bool push_proxy(LiveWorld& world, SegmentTracer& tracer, const Push& push, Vec3& proxy) noexcept;

}  // namespace palpate
