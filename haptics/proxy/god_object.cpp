#include "haptics/proxy/god_object.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/proxy/check_god_object_settings.h"
#include "haptics/proxy/god_object_escapes.h"

namespace palpate {
namespace {

// A stopped step is shortened at most this many times, to the stop of each next triangle; then once
// more by half; then the proxy keeps its position. Each shortening is caused by another triangle
// within a stand-off of the last stop, usually a face of the same vertex.
constexpr int kMaxShortenings = 8;

// Largest length of the lift off a surface on which a proxy is placed. Planes that meet farther
// away differ in less than half of the digits of their normals, and rounding decides where they
// meet.
constexpr double kMostLiftPerStandOff = 0x1p26;  // about the inverse root of double's epsilon

// A step enters the world's bounds and then moves straight or round a feature. An iteration takes
// one step, and one more if it improves a rest.
constexpr std::size_t kMostCornersPerIteration = 2 * (2 + kMostRollCorners);

}  // namespace

Result<GodObject> GodObject::create(const ContactWorld& world, const GodObjectSettings& settings) {
  if (auto error = check_settings(world, settings)) return *error;
  return GodObject(world, settings);
}

GodObject::GodObject(const ContactWorld& world, const GodObjectSettings& settings)
    : settings_(settings),
      world_(std::make_unique<LiveWorld>(world)),
      tracer_(*world_, settings_.radius_m, settings_.accuracy),
      around_(std::make_unique<Surroundings>()) {
  step_tolerance_m_ = settings_.accuracy.tolerance * scale().stand_off_m;
  update_bounds();
  path_.reserve(1 +
                kMostCornersPerIteration * static_cast<std::size_t>(settings_.accuracy.iterations));
}

GodObject::GodObject(GodObject&&) noexcept = default;
GodObject& GodObject::operator=(GodObject&&) noexcept = default;
GodObject::~GodObject() = default;

ProxyState GodObject::refused() const {
  ProxyState state;
  state.proxy = proxy_;
  state.is_refused = true;
  return state;
}

// The bounds have a margin of one scene size. A proxy outside cannot touch anything; a proxy inside
// has coordinates of the order of the scene, as the stand-off assumes.
void GodObject::update_bounds() {
  bounds_ = world_->bounds_solver().grown(world_->size_m() + 2 * settings_.radius_m);
}

bool GodObject::place(const Vec3& p, const std::optional<Vec3>& motion_plane_normal) noexcept {
  if (!std::isfinite(p.squaredNorm())) return false;
  if (motion_plane_normal && !is_unit(*motion_plane_normal)) return false;
  tracer_.begin_tick();
  set_motion_plane(motion_plane_normal);
  proxy_ = goal_ = p;
  rest_.place();
  pushes_.forget_unfinished();
  tracer_.forget_steps();
  path_.clear();
  std::array<FaceContact, kMaxContactPlanes> contacts;
  std::array<ContactPlane, kMaxContactPlanes> planes;
  const std::size_t count = tracer_.contacts_in_front(p, 2 * scale().stand_off_m, contacts);
  std::size_t plane_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const ContactPlane plane{contacts[i].normal, scale().stop_m - contacts[i].clearance_m};
    if (const auto lifting = within_plane(plane, motion_plane_)) planes[plane_count++] = *lifting;
  }
  const PlaneProjection lift =
      least_displacement(std::span(planes).first(plane_count), motion_plane_);
  const double most_m = kMostLiftPerStandOff * scale().stand_off_m;
  if (lift.solved && lift.displacement_m.norm() <= most_m) proxy_ += lift.displacement_m;
  return true;
}

ProxyState GodObject::move_to(const Vec3& goal,
                              const std::optional<Vec3>& motion_plane_normal) noexcept {
  if (!is_goal(goal, motion_plane_normal)) return refused();
  rest_.forget_friction();
  NoFriction none;
  return move(goal, motion_plane_normal, none);
}

void GodObject::set_motion_plane(const std::optional<Vec3>& normal) {
  if (is_motion_plane(normal)) return;
  motion_plane_.reset();
  if (normal) motion_plane_.emplace(*normal);
}

// Stores the interrupted step, which began at `from`, in a tick with this work of bodies.
[[gnu::cold]] void GodObject::keep_step_for_next_tick(const Vec3& from, WorkUnits work_of_bodies) {
  // The results of a search among moving bodies are lost when the bodies move.
  const bool had_little = 2 * work_of_bodies > tracer_.work().budget();
  pushes_.end_cut_short(had_little || tracer_.is_unfinished_among_moving());
  interrupted_.keep(from, proxy_, goal_, tracer_.unfinished());
}

// Moves straight to the goal. Nothing can be touched on this segment.
ProxyState GodObject::move_freely() {
  const Vec3 step = goal_ - proxy_;
  commit(goal_);
  step_.clear_planes();
  step_.clear_solution();
  rest_.move_freely();
  tracer_.look_ahead(proxy_, step, true);
  ProxyState state;
  state.proxy = proxy_;
  state.iterations = 1;
  state.work = tracer_.work().used();
  return state;
}

void GodObject::seed_from_last_tick() {
  step_.clear();
  for (const FaceContact& last : std::as_const(rest_).known()) {
    // A point that ended the last tick at a minimum is still over its face.
    if (rest_.is_settled() && tracer_.radius_m() == 0.0 && last.feature == TriangleFeature::kFace) {
      add_plane(tracer_.contact_over(last.face, proxy_, last.normal));
    } else {
      add_if_touched(last);
    }
  }
  step_.set_current();
}

// Adds the contact plane of a face that the proxy has met, if the proxy touches the face now. The
// edge of a face holds a point only directly after it stopped the point: see leaves_edges().
void GodObject::add_if_touched(const FaceContact& met) {
  const bool is_point = tracer_.radius_m() == 0.0;
  if (is_point && tracer_.is_far_beside_face(met.face, proxy_, near_m())) return;
  const FaceContact now = tracer_.contact_at(met.face, proxy_, met.normal);
  if (now.clearance_m > near_m()) return;
  // The contact may be with the plane of the face although the proxy is slightly beside the face.
  const bool is_over = (now.normal - met.normal).norm() <= ProxyStep::kSameNormal;
  if (!is_point || now.feature == TriangleFeature::kFace || is_over) add_plane(now);
}

// Replaces each plane by the plane across the direction from the nearest point of its face to the
// proxy, and drops the planes of faces that the proxy no longer touches. The distance to a triangle
// is convex along a segment. A segment that such a plane allows therefore never comes nearer to the
// face than the proxy is now, and a segment that the plane forbids does. A proxy that these planes
// hold is therefore at a local minimum, whatever other faces are near.
void GodObject::update_planes() {
  const auto contacts = step_.contacts();
  step_.clear_planes();
  for (const FaceContact& contact : contacts) {
    const FaceContact met = contact;  // its place is taken by the first plane that is kept
    add_if_touched(met);
  }
  step_.set_current();
}

// The point where a step to a target outside of the world's bounds leaves them; the target, if the
// step does not meet the bounds.
Vec3 GodObject::leave_bounds(const Vec3& target) const {
  const Vec3 step = target - proxy_;
  double enter = 0.0;
  double leave = 1.0;
  return bounds_.clip(proxy_, step, enter, leave) ? Vec3(proxy_ + leave * step) : target;
}

// Moves towards the target up to the first obstacle, and adds the plane of the obstacle. Nullopt if
// the proxy reached the target.
std::optional<GodObject::Progress> GodObject::stop_at_first_hit(const Vec3& target) {
  std::optional<TraceHit> hit = tracer_.trace(proxy_, target);
  if (tracer_.is_cut_short()) return Progress::kStuck;
  if (!hit) {
    advance_to(target);
    return std::nullopt;
  }
  Vec3 stop = proxy_ + hit->fraction.value() * (target - proxy_);
  const auto moves = [&] { return !has_converged(stop - proxy_); };
  // Another face may be close to the stopping point. The committed part of the step is therefore
  // traced again, up to its end.
  int shortened = 0;
  for (; settings_.accuracy.certify && moves(); ++shortened) {
    const std::optional<TraceHit> nearer = tracer_.trace_part(proxy_, stop);
    if (tracer_.is_cut_short()) return Progress::kStuck;
    if (!nearer) break;
    hit = nearer;
    double part = nearer->fraction.value();
    if (shortened >= kMaxShortenings) part = shortened == kMaxShortenings ? 0.5 * part : 0.0;
    stop = proxy_ + part * (stop - proxy_);
  }
  const bool moved = moves();
  if (moved) advance_to(stop);
  FaceContact contact = hit->contact;
  const bool is_off_stop = shortened > kMaxShortenings;
  if (tracer_.radius_m() > 0.0) {
    step_.set_earlier();
  } else if (is_off_stop || contact.feature != TriangleFeature::kFace) {
    contact = tracer_.contact_at(contact.face, proxy_, contact.normal);
  }
  bool is_new = add_plane(contact);
  // If a sphere touches many faces, the face that is met first may not restrict the step most.
  if (!moved && tracer_.radius_m() > 0.0) {
    const auto steepest = tracer_.steepest_contact(proxy_, target - proxy_);
    if (steepest && add_plane(*steepest)) is_new = true;
  }
  return is_new || moved ? Progress::kStopped : Progress::kStuck;
}

// The part of the segment to the goal that ends at the first active plane, within the plane of
// motion.
Vec3 GodObject::step_to_planes() const {
  Vec3 lag = goal_ - proxy_;
  if (motion_plane_) lag = motion_plane_->part_of(lag);
  return step_.part_to_planes(lag) * lag;
}

// Moves a proxy that is outside of the world's bounds straight to the bounds. False if the segment
// to the goal misses the bounds and the proxy has moved to the goal.
bool GodObject::enter_bounds() {
  if (bounds_.contains(proxy_)) return true;
  const Vec3 step = goal_ - proxy_;
  double enter = 0.0;
  double leave = 1.0;
  PlaneProjection none;
  none.solved = true;
  step_.solve(none);
  if (!bounds_.clip(proxy_, step, enter, leave)) {
    commit(goal_);
    return false;
  }
  commit(proxy_ + enter * step);
  return true;
}

// Adds the contact plane of a contact. False if the planes are unchanged.
bool GodObject::add_plane(const FaceContact& contact) {
  // The offset is at most 0, so that the present position stays feasible.
  ContactPlane plane{contact.normal, scale().stop_m - contact.clearance_m};
  if (motion_plane_) {
    const auto in_plane = within_plane(plane, *motion_plane_);
    if (!in_plane) return false;
    plane = *in_plane;
  }
  plane.offset_m = std::min(0.0, plane.offset_m);
  return step_.add(contact, plane);
}

void GodObject::commit(const Vec3& proxy) {
  if (proxy == proxy_) return;
  proxy_ = proxy;
  path_.push_back(proxy);
}

void GodObject::advance_to(const Vec3& target) {
  const Vec3 displacement = target - proxy_;
  commit(target);
  step_.advance(displacement);
}

// Marks the tick as slow and resets the extrapolation. A tick that continues the last one keeps its
// extrapolation.
void GodObject::become_slow() {
  if (is_slow_) return;
  is_slow_ = true;
  extrapolation_.begin(proxy_);
}

GodObject::ProxyPlace GodObject::place_now() const {
  return {proxy_, path_.size(), step_};
}

void GodObject::return_to(const ProxyPlace& place) {
  proxy_ = place.proxy;
  path_.resize(place.corners);
  step_.return_to(place.step);
}

// The unit component of a direction in the plane of motion, or the direction itself without such a
// plane. Nullopt if the direction has no component there.
std::optional<Vec3> GodObject::in_motion_plane(const Vec3& direction) const {
  if (!motion_plane_) return direction;
  const auto plane = within_plane({direction, 0.0}, *motion_plane_);
  return plane ? std::optional(plane->normal) : std::nullopt;
}

// A step within the plane of motion, and the height by which the plane through the goal has moved
// away from the proxy. A proxy that is in the plane to within rounding keeps its height, since the
// height of a distant goal has a larger rounding error.
Vec3 GodObject::onto_motion_plane(const Vec3& step) const {
  return step + motion_plane_->height_over_m(proxy_, goal_) * motion_plane_->normal();
}

// Whether a point has left the face that stopped it. The correction to the plane of motion can move
// a point off a face that is nearly parallel to that plane.
bool GodObject::is_above(const FaceContact& contact) const {
  if (tracer_.radius_m() > 0.0) return false;
  const FaceContact now = tracer_.contact_over(contact.face, proxy_, contact.normal);
  return now.clearance_m > scale().stand_off_m;
}

// Whether the face of the one active plane is under the proxy, and not only its plane. With two or
// three active planes, one can hold the proxy beyond the end of its face. No test of a single face
// detects this, so the planes must be found again at the present position.
bool GodObject::settled() const {
  if (step_.active_count() > 1) return false;
  for (int i = 0; i < step_.active_count(); ++i) {
    const FaceContact& contact = step_.active_contact(i);
    if (!tracer_.is_over(contact, proxy_)) return false;
    if (motion_plane_ && is_above(contact)) return false;
    if (tracer_.radius_m() > 0.0 &&
        !is_same_place(contact, tracer_.contact_at(contact.face, proxy_, contact.normal))) {
      return false;
    }
  }
  return true;
}

ProxyState GodObject::report(int iterations, bool capped) const {
  ProxyState state;
  state.proxy = proxy_;
  state.iterations = iterations;
  state.work = tracer_.work().used();
  state.capped = capped;
  const Vec3 lag = proxy_ - goal_;
  state.in_contact = lag.norm() > step_tolerance_m_;
  if (!state.in_contact) return state;
  state.active_planes = step_.active_count();
  state.slid = path_.size() > 1;
  if (step_.active_count() == 2) {
    state.free_direction = crossing_line(plane_normal(0), plane_normal(1));
  }
  for (int i = 0; i < step_.active_count(); ++i) {
    state.normal += step_.active_plane(i).normal;
  }
  if (step_.active_count() == 1) return state;
  if (step_.active_count() == 0) state.normal = lag;  // capped before it reached a plane
  // The rounding of a sum that nearly cancels may lead out of the plane. The sum with 0 gives a
  // zero component its positive sign.
  if (motion_plane_) state.normal = motion_plane_->part_of(state.normal) + Vec3(Vec3::Zero());
  if (step_.active_count() == 0) {
    state.normal.normalize();
  } else if (state.normal.norm() <= kCancelledNormal) {
    state.normal.setZero();
  } else {
    state.normal.normalize();
  }
  return state;
}

}  // namespace palpate
