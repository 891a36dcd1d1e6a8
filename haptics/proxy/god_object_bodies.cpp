// The motion of bodies and their pushes of the proxy: see god_object.h.

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/proxy/body_push.h"
#include "haptics/proxy/god_object_escapes.h"

namespace palpate {
namespace {

// Number of passes over the bodies in one tick. Bodies that were held back try again, so that a
// chain of this many bodies, each blocked by the next, moves in one tick.
constexpr int kMostPushPasses = 4;

bool is_same_pose(const RigidTransform& a, const RigidTransform& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation_m == b.translation_m;
}

}  // namespace

bool GodObject::is_motion(std::uint32_t body, const RigidTransform& T_solver_body) const {
  return body < world_->bodies().size() && is_pose(T_solver_body) &&
         std::isfinite(T_solver_body.translation_m.squaredNorm());
}

bool GodObject::place_body(std::uint32_t body, const RigidTransform& T_solver_body) noexcept {
  if (!is_motion(body, T_solver_body)) return false;
  if (!world_->place(body, unit_pose(T_solver_body))) return false;
  world_->extend_bounds(body);
  tracer_.forget_candidates();
  around_->of.reset();
  update_bounds();
  return true;
}

std::size_t GodObject::move_bodies(std::span<const BodyMotion> motions,
                                   const std::optional<Vec3>& motion_plane_normal) noexcept {
  if (motion_plane_normal && !is_unit(*motion_plane_normal)) return motions.size();
  if (!is_motion_plane(motion_plane_normal)) {
    rest_.drop_step();  // the interrupted step was in another plane
    set_motion_plane(motion_plane_normal);
  }
  tracer_.begin_tick();
  if (!pushes_.begin_pushes()) return count_not_arrived(motions);
  tracer_.begin_errand(SegmentTracer::Errand::kPush);
  const bool has_turn = !pushes_.has_unfinished() || !finishes_push(motions);
  const bool are_done = has_turn && push_all(motions);
  update_bounds();
  if (are_done) pushes_.begin_with(0);
  return count_not_arrived(motions);
}

// Pushes all bodies. False if the work does not suffice for all of them; the next tick then begins
// with the next body that was due.
bool GodObject::push_all(std::span<const BodyMotion> motions) noexcept {
  std::size_t held = motions.size();
  // A body that another one blocked may be free to move once the other one has moved.
  for (int pass = 0; pass < kMostPushPasses && held > 0; ++pass) {
    const std::size_t held_before = std::exchange(held, std::size_t{0});
    const std::size_t first = pushes_.first();
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const BodyMotion& motion = motions[(first + i) % motions.size()];
      if (2 * tracer_.work().used() > tracer_.work().budget()) return false;
      tracer_.begin_step();
      held += move_body(motion) ? 0 : 1;
      pushes_.begin_with((first + i + 1) % motions.size());
      if (!tracer_.is_cut_short()) continue;
      pushes_.cut_short(motion);
      return false;
    }
    if (held == held_before) break;
  }
  return true;
}

// Continues the push in which the last tick was cut short, to the pose that was the target then.
// False if that body no longer moves.
bool GodObject::finishes_push(std::span<const BodyMotion> motions) noexcept {
  const BodyMotion push = pushes_.take_unfinished();
  const bool still_moves = std::any_of(motions.begin(), motions.end(),
                                       [&](const BodyMotion& m) { return m.body == push.body; });
  if (!still_moves) return false;
  tracer_.repeat_step();
  move_body(push);
  if (tracer_.is_cut_short()) pushes_.cut_short(push);
  return true;
}

// The number of bodies that are not at their target poses.
std::size_t GodObject::count_not_arrived(std::span<const BodyMotion> motions) const {
  const auto is_there = [&](const BodyMotion& motion) {
    return is_motion(motion.body, motion.T_solver_body) &&
           is_same_pose(world_->body(motion.body).T_solver_body, unit_pose(motion.T_solver_body));
  };
  const auto there = std::count_if(motions.begin(), motions.end(), is_there);
  return motions.size() - static_cast<std::size_t>(there);
}

bool GodObject::move_body(const BodyMotion& motion) noexcept {
  if (!is_motion(motion.body, motion.T_solver_body)) return false;
  const RigidTransform before = world_->body(motion.body).T_solver_body;
  const RigidTransform after = unit_pose(motion.T_solver_body);
  if (is_same_pose(before, after)) return true;
  const Vec3 proxy_before = proxy_;
  const Push push{motion.body, after, is_carried_by(motion.body), motion_plane_, plane_point()};
  if (!push_proxy(*world_, tracer_, push, proxy_)) return false;
  world_->extend_bounds(motion.body);
  tracer_.forget_moving();
  around_->of.reset();
  if (proxy_ != proxy_before) rest_.disturb();
  for (FaceContact& contact : rest_.known()) {
    if (contact.face.body != motion.body) continue;
    rest_.disturb();
    contact.normal = after.direction(before.inverse_direction(contact.normal)).normalized();
  }
  return true;
}

// A point of the plane of motion: the last goal, from which the proxy is a little off by rounding;
// or the proxy, if a body has kept it out of the plane.
const Vec3& GodObject::plane_point() const {
  if (!motion_plane_) return proxy_;
  const double height_m = motion_plane_->height_over_m(proxy_, goal_);
  return std::abs(height_m) <= step_tolerance_m_ ? goal_ : proxy_;
}

// Whether a body carries the proxy because one of its faces holds the proxy by friction. A face on
// which the proxy slides carries it as well: seen from the face, the hand moves, and the next step
// applies the friction to that motion.
bool GodObject::is_carried_by(std::uint32_t body) const {
  for (std::size_t i = 0; i < contacts().size(); ++i) {
    if (rest_.holds_by_friction(i) && contacts()[i].face.body == body) return true;
  }
  return false;
}

}  // namespace palpate
