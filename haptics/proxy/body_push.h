#pragma once

// What a moving body does to the proxy: it pushes it, and never passes it.

#include <optional>

#include "haptics/proxy/live_world.h"
#include "haptics/proxy/segment_tracer.h"

namespace palpate {

struct Push {
  std::uint32_t body = 0;
  RigidTransform T_solver_body;                  // where it is to be
  std::optional<Vec3> motion_plane_normal = {};  // as for GodObject::move_to()
  bool carries = false;  // the proxy sticks to it, and is taken along as far as there is room
};

// Moves a body from where it is in the world to T_solver_body, and the proxy out of its way, if
// need be, by the least that will do. Seen from the body, the proxy goes straight from where it was
// to where it ends, and touches nothing of the body on that way: the body may turn and move as far
// as it likes in one tick and cannot end up with the proxy on its other side. Nor is the proxy
// pushed through any other body.
//
// Where there is no room for the proxy (between a moving body and one that is in the way) the body
// is held back: it stays where it was, and so does the proxy. Then, or if too many bodies move, the
// result is false.
//
// Given a plane of motion, the proxy is pushed within it.
// No allocation, lock or exception.
bool push_proxy(LiveWorld& world, SegmentTracer& tracer, const Push& push, Vec3& proxy) noexcept;

}  // namespace palpate
