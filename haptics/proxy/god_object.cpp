#include "haptics/proxy/god_object.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/exact/orientation.h"
#include "haptics/proxy/check_god_object_settings.h"
#include "haptics/proxy/god_object_escapes.h"

namespace palpate {
namespace {

// A stopped step is shortened at most this many times, to the stop of each next triangle; then once
// more by half; then the proxy keeps its position. Each shortening is caused by another triangle
// within a stand-off of the last stop, usually a face of the same vertex.
constexpr int kMaxShortenings = 8;

// The least cosine of the angle between two successive slides that count as the same direction.
constexpr double kSameDirection = 0.9;

// The largest growth of an extrapolation from one slide to the next: a change of curvature farther
// on is approached in small steps.
constexpr double kMostGrowth = 16.0;

// Largest length of the lift off a surface on which a proxy is placed. Planes that meet farther
// away differ in less than half of the digits of their normals, and rounding decides where they
// meet.
constexpr double kMostLiftPerStandOff = 0x1p26;  // about the inverse root of double's epsilon

// A step enters the world's bounds and then moves straight or round a feature. An iteration takes
// one step, and one more if it improves a rest.
constexpr std::size_t kMostCornersPerIteration = 2 * (2 + kMostRollCorners);

// Two contacts with the same face have the same plane if a cosine cannot distinguish their normals;
// contacts with different faces, if their normals differ by rounding only.
constexpr double kSameNormal = 0x1p-25;
constexpr double kSameNormalOfOther = 32 * kUnitRoundoff;

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
  settled_ = false;
  confirmed_ = false;
  slide_ = {};
  goes_on_ = false;
  repeats_step_ = false;
  last_push_.reset();
  tracer_.forget_steps();
  path_.clear();
  last_active_count_ = last_count_ = 0;
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
  slide_ = {};
  last_holds_ = {};
  NoFriction none;
  return move(goal, motion_plane_normal, none);
}

void GodObject::set_motion_plane(const std::optional<Vec3>& normal) {
  if (is_motion_plane(normal)) return;
  motion_plane_.reset();
  if (normal) motion_plane_.emplace(*normal);
}

// Stores the goal and the target of the interrupted step.
[[gnu::cold]] void GodObject::keep_step_for_next_tick() {
  // The results of a search among moving bodies are lost when the bodies move.
  const bool had_little = 2 * work_of_bodies_ > tracer_.work().budget();
  move_has_turn_ = had_little || tracer_.is_unfinished_among_moving();
  const TraceKey* unfinished = tracer_.unfinished();
  if (unfinished && unfinished->p == proxy_ && unfinished->q == step_target_) return;
  step_goal_ = goal_;
  if (unfinished) step_target_ = unfinished->q;
}

// Moves straight to the goal. Nothing can be touched on this segment.
ProxyState GodObject::move_freely() {
  const Vec3 step = goal_ - proxy_;
  commit(goal_);
  plane_count_ = 0;
  projection_ = {};
  goes_on_ = false;
  repeats_step_ = false;
  tracer_.look_ahead(proxy_, step, true);
  ProxyState state;
  state.proxy = proxy_;
  state.iterations = 1;
  state.work = tracer_.work().used();
  return state;
}

void GodObject::seed_from_last_tick() {
  plane_count_ = 0;
  projection_ = {};
  planes_are_current_ = is_over_next_ = false;
  for (int i = 0; i < last_count_; ++i) {
    const FaceContact& last = last_contacts_[i];
    // A point that ended the last tick at a minimum is still over its face.
    if (settled_ && tracer_.radius_m() == 0.0 && last.feature == TriangleFeature::kFace) {
      add_plane(tracer_.contact_over(last.face, proxy_, last.normal));
    } else {
      add_if_touched(last);
    }
  }
  planes_are_current_ = true;
}

// Adds the contact plane of a face that the proxy has met, if the proxy touches the face now. The
// edge of a face holds a point only directly after it stopped the point: see leaves_edges().
void GodObject::add_if_touched(const FaceContact& met) {
  const double near_m = kNearPerStandOff * scale().stand_off_m;
  const bool is_point = tracer_.radius_m() == 0.0;
  if (is_point && tracer_.is_far_beside_face(met.face, proxy_, near_m)) return;
  const FaceContact now = tracer_.contact_at(met.face, proxy_, met.normal);
  if (now.clearance_m > near_m) return;
  // The contact may be with the plane of the face although the proxy is slightly beside the face.
  const bool is_over = (now.normal - met.normal).norm() <= kSameNormal;
  if (!is_point || now.feature == TriangleFeature::kFace || is_over) add_plane(now);
}

// Replaces each plane by the plane across the direction from the nearest point of its face to the
// proxy, and drops the planes of faces that the proxy no longer touches. The distance to a triangle
// is convex along a segment. A segment that such a plane allows therefore never comes nearer to the
// face than the proxy is now, and a segment that the plane forbids does. A proxy that these planes
// hold is therefore at a local minimum, whatever other faces are near.
void GodObject::update_planes() {
  const int count = plane_count_;
  plane_count_ = 0;
  is_over_next_ = false;
  for (int i = 0; i < count; ++i) {
    const FaceContact met = contacts_[i];
    add_if_touched(met);
  }
  planes_are_current_ = true;
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
    planes_are_current_ = false;
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

// Whether the proxy touches none of the active planes. Friction acts only at touched planes.
bool GodObject::is_off_planes() const {
  const double near_m = kNearPerStandOff * scale().stand_off_m;
  for (int i = 0; i < projection_.active_count; ++i) {
    if (planes_of_contact_[projection_.active[i]].offset_m >= -near_m) return false;
  }
  return projection_.active_count > 0;
}

// Whether the proxy touches each of the faces that hold it.
bool GodObject::touches_planes() const {
  for (int i = 0; i < projection_.active_count; ++i) {
    if (contacts_[projection_.active[i]].clearance_m > scale().stand_off_m) return false;
  }
  return true;
}

// The part of the segment to the goal that ends at the first active plane, within the plane of
// motion.
Vec3 GodObject::step_to_planes() const {
  Vec3 lag = goal_ - proxy_;
  if (motion_plane_) lag = motion_plane_->part_of(lag);
  double part = 1.0;
  for (int i = 0; i < projection_.active_count; ++i) {
    const ContactPlane& plane = planes_of_contact_[projection_.active[i]];
    const double approach_m = plane.normal.dot(lag);
    if (approach_m < 0.0) part = std::min(part, plane.offset_m / approach_m);
  }
  return part * lag;
}

// Moves a proxy that is outside of the world's bounds straight to the bounds. False if the segment
// to the goal misses the bounds and the proxy has moved to the goal.
bool GodObject::enter_bounds() {
  if (bounds_.contains(proxy_)) return true;
  const Vec3 step = goal_ - proxy_;
  double enter = 0.0;
  double leave = 1.0;
  projection_ = {};
  projection_.solved = true;
  if (!bounds_.clip(proxy_, step, enter, leave)) {
    commit(goal_);
    return false;
  }
  commit(proxy_ + enter * step);
  return true;
}

// Whether a plane is already present, from the same face or from another one; faces that share a
// touched edge or vertex, or lie in one plane, have the same contact plane.
bool GodObject::is_known(const FaceContact& contact, const ContactPlane& plane, int& known) const {
  for (known = 0; known < plane_count_; ++known) {
    const double difference = (planes_of_contact_[known].normal - plane.normal).squaredNorm();
    const bool is_same_face = contacts_[known].face == contact.face;
    const double same = is_same_face ? kSameNormal : kSameNormalOfOther;
    if (difference <= same * same) return true;
  }
  return false;
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
  int known = 0;
  if (is_known(contact, plane, known)) {
    ContactPlane& there = planes_of_contact_[known];
    const ContactPlane before = there;
    if (contacts_[known].face == contact.face || plane.offset_m > there.offset_m) {
      there = plane;
      contacts_[known] = contact;
    }
    return there.normal != before.normal || there.offset_m != before.offset_m;
  }
  if (plane_count_ == kMaxContactPlanes) drop_inactive_planes();
  planes_of_contact_[plane_count_] = plane;
  contacts_[plane_count_] = contact;
  ++plane_count_;
  return true;
}

void GodObject::drop_inactive_planes() {
  const auto active = projection_.active;  // in ascending order, so moving down is safe
  for (int i = 0; i < projection_.active_count; ++i) {
    planes_of_contact_[i] = planes_of_contact_[active[i]];
    contacts_[i] = contacts_[active[i]];
    projection_.active[i] = i;
  }
  plane_count_ = projection_.active_count;
}

void GodObject::commit(const Vec3& proxy) {
  if (proxy == proxy_) return;
  proxy_ = proxy;
  path_.push_back(proxy);
}

void GodObject::advance_to(const Vec3& target) {
  const Vec3 displacement = target - proxy_;
  commit(target);
  planes_are_current_ = is_over_next_ = false;
  for (int i = 0; i < plane_count_; ++i) {
    ContactPlane& plane = planes_of_contact_[i];
    plane.offset_m = std::min(0.0, plane.offset_m - plane.normal.dot(displacement));
  }
}

// Marks the tick as slow and resets the extrapolation. A tick that continues the last one keeps its
// extrapolation.
void GodObject::become_slow() {
  if (is_slow_) return;
  is_slow_ = true;
  last_slide_m_ = 0.0;
  last_round_.reset();
  leap_from_ = proxy_;
  leap_reach_ = 1.0;
  steps_to_leap_ = kStepsPerLeap;
}

// The factor by which a slide must be multiplied to end where it and all later slides together
// would end. It extrapolates to where slides vanish if they continue to shrink along the path as
// they have since the last one (a secant).
double GodObject::reach_of(const Vec3& slide) {
  const Vec3 from = proxy_ - slide;
  const Vec3 path = from - std::exchange(last_slide_from_, from);
  const double last_m = std::exchange(last_slide_m_, slide.norm());
  const double path_m = path.norm();
  if (last_m == 0.0 || slide.dot(path) < kSameDirection * last_slide_m_ * path_m) {
    overreach_ = 1.0;
    return overreach_;
  }
  const double shrinks_m = last_m - last_slide_m_;
  if (shrinks_m > 0.0) {
    overreach_ = std::min(path_m / shrinks_m, kMostGrowth * overreach_);
  } else {
    // The proxy leaves a maximum of the lag. The least reach makes the gain larger than the amount
    // by which its distance to a face may differ before and after.
    const double least_m = scale().stand_off_m * (proxy_ - goal_).norm() / last_slide_m_;
    overreach_ = std::max(kFasterEachTime * overreach_, least_m / last_slide_m_);
  }
  return overreach_;
}

GodObject::ProxyPlace GodObject::place_now() const {
  return {proxy_,       path_.size(), planes_of_contact_, contacts_,
          plane_count_, projection_,  planes_are_current_};
}

void GodObject::return_to(const ProxyPlace& place) {
  proxy_ = place.proxy;
  path_.resize(place.corners);
  planes_of_contact_ = place.planes;
  contacts_ = place.contacts;
  plane_count_ = place.plane_count;
  projection_ = place.projection;
  planes_are_current_ = place.planes_are_current;
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
  if (projection_.active_count > 1) return false;
  for (int i = 0; i < projection_.active_count; ++i) {
    const FaceContact& contact = contacts_[projection_.active[i]];
    if (!tracer_.is_over(contact, proxy_)) return false;
    if (motion_plane_ && is_above(contact)) return false;
    if (tracer_.radius_m() > 0.0 &&
        !is_same_place(contact, tracer_.contact_at(contact.face, proxy_, contact.normal))) {
      return false;
    }
  }
  return true;
}

// Stores the faces that hold the proxy and, after a capped tick, the other faces that it has met.
void GodObject::keep_contacts_for_next_tick(bool capped) {
  last_active_count_ = projection_.active_count;
  last_count_ = last_active_count_;
  for (int i = 0; i < projection_.active_count; ++i) {
    last_contacts_[i] = contacts_[projection_.active[i]];
  }
  if (!capped) return;
  const auto active_end = projection_.active.begin() + projection_.active_count;
  for (int i = 0; i < plane_count_; ++i) {
    const bool is_active = std::find(projection_.active.begin(), active_end, i) != active_end;
    if (!is_active) last_contacts_[last_count_++] = contacts_[i];
  }
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
  state.active_planes = projection_.active_count;
  state.slid = path_.size() > 1;
  if (projection_.active_count == 2) {
    state.free_direction = crossing_line(plane_normal(0), plane_normal(1));
  }
  for (int i = 0; i < projection_.active_count; ++i) {
    state.normal += planes_of_contact_[projection_.active[i]].normal;
  }
  if (projection_.active_count == 1) return state;
  if (projection_.active_count == 0) state.normal = lag;  // capped before it reached a plane
  // The rounding of a sum that nearly cancels may lead out of the plane. The sum with 0 gives a
  // zero component its positive sign.
  if (motion_plane_) state.normal = motion_plane_->part_of(state.normal) + Vec3(Vec3::Zero());
  if (projection_.active_count == 0) {
    state.normal.normalize();
  } else if (state.normal.norm() <= kCancelledNormal) {
    state.normal.setZero();
  } else {
    state.normal.normalize();
  }
  return state;
}

}  // namespace palpate
