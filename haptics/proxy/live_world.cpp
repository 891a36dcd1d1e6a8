#include "haptics/proxy/live_world.h"

#include <algorithm>

namespace palpate {

LiveWorld::LiveWorld(const ContactWorld& world)
    : bodies_(world.bodies),
      tree_(world.tree),
      is_moving_(world.bodies.size(), false),
      bounds_solver_(world.bounds_solver),
      size_m_(world.size_m) {
  moving_.reserve(std::min(kMostMoving, bodies_.size()));
}

bool LiveWorld::place(std::uint32_t b, const RigidTransform& T_solver_body) noexcept {
  if (!is_moving_[b]) {
    if (moving_.size() == kMostMoving) return false;
    moving_.push_back(b);
    is_moving_[b] = true;
  }
  bodies_[b].place(T_solver_body);
  bodies_[b].corners = nullptr;  // the corners belong to the initial pose
  return true;
}

void LiveWorld::extend_bounds(std::uint32_t b) noexcept {
  bounds_solver_ = bounds_solver_.united(bodies_[b].box_solver());
}

}  // namespace palpate
