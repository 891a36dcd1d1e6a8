#include "haptics/god_object.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// A face that makes a smaller angle than this (sine) with the plane of motion is parallel to it:
// its in-plane normal would have lost half its digits.
constexpr double kMinInPlaneNormal = 1e-8;  // about the square root of double's epsilon

// A step that is stopped is shortened at most so often; then the proxy stays where it is. Each time
// is a triangle within a stand-off of the last stop: faces of one vertex, as a rule.
constexpr int kMaxShortenings = 8;

// One iteration goes into the world's bounds, along a step, and to the goal's very bits.
constexpr std::size_t kMostCornersPerStep = 3;

// A contact normal with a larger part than this out of the plane of motion does not belong to it.
constexpr double kOutOfPlane = 64 * kEpsilon;

// Unit normals that sum to less than their rounding cancel.
constexpr double kCancelledNormal = 16 * kEpsilon;

// Normals of two contacts with one face count as the same plane within rounding.
constexpr double kSameNormalCosine = 1.0 - 8 * kEpsilon;

}  // namespace

GodObject::GodObject(const ContactWorld& world, const GodObjectSettings& settings)
    : settings_(settings), world_bounds_(world.bounds_solver), tracer_(world, settings.radius_m, settings.accuracy) {
  step_tolerance_m_ = settings.accuracy.tolerance * scale().stand_off_m;
  // One size of margin: what lies outside cannot touch anything, and what lies inside has
  // coordinates of the order of the scene, as the stand-off assumes.
  world_bounds_ = world_bounds_.grown(world.size_m + 2 * settings.radius_m);
  path_.reserve(1 + kMostCornersPerStep * static_cast<std::size_t>(settings.accuracy.iterations));
}

void GodObject::place(const Vec3& p) noexcept {
  proxy_ = p;
  path_.clear();
  last_active_count_ = 0;
  std::array<FaceContact, kMaxContactPlanes> contacts;
  std::array<ContactPlane, kMaxContactPlanes> planes;
  const double stand_off = scale().stand_off_m;
  const std::size_t count = tracer_.contacts_near(p, 2 * stand_off, contacts);
  for (std::size_t i = 0; i < count; ++i) {
    planes[i] = {contacts[i].normal, stand_off - contacts[i].clearance_m};
  }
  const PlaneProjection lift =
      project_onto_planes(std::span(planes).first(count), Vec3::Zero(), Feasibility::kMustMove);
  if (lift.solved) proxy_ += lift.displacement_m;
}

ProxyState GodObject::move_to(const Vec3& goal,
                              const std::optional<Vec3>& motion_plane_normal) noexcept {
  goal_ = goal;
  motion_plane_normal_ = motion_plane_normal;
  path_.clear();
  path_.push_back(proxy_);
  seed_from_last_tick();
  bool began_empty = plane_count_ == 0;
  Vec3 round_start = proxy_;
  bool capped = true;
  int iteration = 0;
  while (capped && iteration < settings_.accuracy.iterations) {
    ++iteration;
    const Progress progress = take_step();
    if (progress == Progress::kStopped) continue;
    // A round ends where its planes let the proxy go no nearer. That is the local minimum if the
    // faces of those planes are really there, or if a round from scratch ends where it began.
    const double moved = (proxy_ - round_start).norm();
    const bool at_minimum = progress == Progress::kMoved && settled();
    if (at_minimum || (began_empty && moved <= step_tolerance_m_)) {
      capped = false;
      break;
    }
    plane_count_ = 0;
    began_empty = true;
    round_start = proxy_;
  }
  keep_active_for_next_tick();
  return report(iteration, capped);
}

void GodObject::seed_from_last_tick() {
  plane_count_ = 0;
  projection_ = {};
  for (int i = 0; i < last_active_count_; ++i) {
    const FaceContact& last = last_active_[i];
    const FaceContact now = tracer_.contact_at(last.face, proxy_, last.normal);
    if (now.clearance_m > 2 * scale().stand_off_m || !tracer_.is_over(now, proxy_)) continue;
    add_plane(now);
  }
}

GodObject::Progress GodObject::take_step() {
  if (plane_count_ == 0 && !enter_bounds()) return Progress::kMoved;
  projection_ = project_onto_planes(
      std::span(planes_of_contact_).first(static_cast<std::size_t>(plane_count_)), goal_ - proxy_);
  if (!projection_.solved) return Progress::kStuck;
  if (const auto progress = roll_towards_goal()) return *progress;
  Vec3 step = projection_.displacement_m;
  // Free, the proxy goes to the goal however near it is; held by planes, it has converged.
  const bool is_free = projection_.active_count == 0;
  if (!is_free && step.norm() <= step_tolerance_m_) return Progress::kMoved;
  double enter = 0.0;
  double leave = 1.0;
  const bool inside = world_bounds_.clip(proxy_, step, enter, leave);
  const bool leaves = inside && leave < 1.0;
  if (leaves) step *= leave;  // nothing to touch beyond
  if (const auto stopped = stop_at_first_hit(step)) return *stopped;
  if (is_free && !leaves) commit(goal_);  // to the bit
  return leaves ? Progress::kStuck : Progress::kMoved;
}

// Takes the step as far as it is free. Nothing if all of it is.
std::optional<GodObject::Progress> GodObject::stop_at_first_hit(const Vec3& step) {
  std::optional<TraceHit> hit = tracer_.trace(proxy_, step);
  if (!hit) {
    advance(step);
    return std::nullopt;
  }
  Vec3 taken = hit->fraction * step;
  const auto moves = [&] { return taken.norm() > step_tolerance_m_; };
  // The face it is stopped by may not be the only one that is close there. What is taken has been
  // traced to its very end.
  for (int shortened = 0; settings_.accuracy.certify && moves(); ++shortened) {
    const std::optional<TraceHit> nearer = tracer_.trace(proxy_, taken);
    if (!nearer) break;
    hit = nearer;
    taken *= shortened < kMaxShortenings ? nearer->fraction : 0.0;
  }
  const bool moved = moves();
  if (!moved) taken.setZero();
  advance(taken);
  const bool is_new = add_plane(hit->contact);
  return is_new || moved ? Progress::kStopped : Progress::kStuck;
}

// Takes a proxy that is outside everything straight to where things begin. False if it has reached
// the goal without meeting anything.
bool GodObject::enter_bounds() {
  if (world_bounds_.squared_distance(proxy_) == 0.0) return true;
  const Vec3 step = goal_ - proxy_;
  double enter = 0.0;
  double leave = 1.0;
  projection_ = {};
  projection_.solved = true;
  if (!world_bounds_.clip(proxy_, step, enter, leave)) {
    commit(goal_);
    return false;
  }
  commit(proxy_ + enter * step);
  return true;
}

// False if the very same plane was there already.
bool GodObject::add_plane(const FaceContact& contact) {
  Vec3 normal = contact.normal;
  double room = contact.clearance_m - scale().stand_off_m;
  if (motion_plane_normal_) {
    normal -= normal.dot(*motion_plane_normal_) * *motion_plane_normal_;
    const double in_plane = normal.norm();
    if (in_plane < kMinInPlaneNormal) return false;
    normal /= in_plane;
    room /= in_plane;
  }
  // Never negative room: the proxy is where it is, and must stay feasible.
  const ContactPlane plane{normal, std::min(0.0, -room)};
  for (int i = 0; i < plane_count_; ++i) {
    if (contacts_[i].face != contact.face ||
        planes_of_contact_[i].normal.dot(normal) < kSameNormalCosine) {
      continue;
    }
    planes_of_contact_[i] = plane;
    contacts_[i] = contact;
    return false;
  }
  if (plane_count_ == kMaxContactPlanes) drop_inactive_planes();
  planes_of_contact_[plane_count_] = plane;
  contacts_[plane_count_] = contact;
  ++plane_count_;
  return true;
}

void GodObject::drop_inactive_planes() {
  const auto& active = projection_.active;  // in ascending order, so moving down is safe
  for (int i = 0; i < projection_.active_count; ++i) {
    planes_of_contact_[i] = planes_of_contact_[active[i]];
    contacts_[i] = contacts_[active[i]];
  }
  plane_count_ = projection_.active_count;
}

void GodObject::commit(const Vec3& proxy) {
  if (proxy == proxy_) return;
  proxy_ = proxy;
  path_.push_back(proxy);
}

void GodObject::advance(const Vec3& displacement) {
  commit(proxy_ + displacement);
  for (int i = 0; i < plane_count_; ++i) {
    ContactPlane& plane = planes_of_contact_[i];
    plane.offset_m = std::min(0.0, plane.offset_m - plane.normal.dot(displacement));
  }
}

// A sphere held by an edge or vertex alone is held by a curved surface. Sliding along its tangent
// plane and dropping back converges step by step; instead, the sphere goes along that tangent plane
// to where it meets the tangent plane at the answer, straight out from the feature through the
// goal, which the next step then follows. Both pieces lie outside the curved surface. Nothing if
// there is nothing to roll over, or if that way would lead farther from the goal first.
std::optional<GodObject::Progress> GodObject::roll_towards_goal() {
  if (tracer_.radius_m() == 0.0 || projection_.active_count != 1) return std::nullopt;
  const int held_by = projection_.active[0];
  const FaceContact now = contacts_[held_by];
  if (now.feature == TriangleFeature::kFace) return std::nullopt;
  FaceContact answer = tracer_.contact_at(now.face, goal_, now.normal);
  const bool other_side = answer.normal.dot(now.normal) <= 0.0;
  const bool out_of_plane =
      motion_plane_normal_ && std::abs(answer.normal.dot(*motion_plane_normal_)) > kOutOfPlane;
  if (other_side || out_of_plane || is_same_place(now, answer)) return std::nullopt;

  const double reach = tracer_.radius_m() + scale().stand_off_m;
  const ContactPlane tangents[2] = {
      planes_of_contact_[held_by],
      {answer.normal, reach - answer.normal.dot(proxy_ - answer.feature_point)}};
  const Vec3 target = goal_ - proxy_;
  const PlaneProjection edge = project_onto_planes(tangents, target, Feasibility::kMustMove);
  const Vec3& step = edge.displacement_m;
  if (!edge.solved || (step - target).squaredNorm() >= target.squaredNorm()) return std::nullopt;
  if (const auto stopped = stop_at_first_hit(step)) return *stopped;
  plane_count_ = 0;
  answer.clearance_m = answer.normal.dot(proxy_ - answer.feature_point) - tracer_.radius_m();
  add_plane(answer);
  return Progress::kStopped;
}

// Whether a sphere touches the same place of a curved feature in both contacts.
bool GodObject::is_same_place(const FaceContact& a, const FaceContact& b) const {
  return (a.normal - b.normal).norm() * tracer_.radius_m() <= scale().stand_off_m;
}

// True iff every face that pushes is really there, under the proxy, and not only its plane.
bool GodObject::settled() const {
  for (int i = 0; i < projection_.active_count; ++i) {
    const FaceContact& contact = contacts_[projection_.active[i]];
    if (!tracer_.is_over(contact, proxy_)) return false;
    if (contact.feature != TriangleFeature::kFace &&
        !is_same_place(contact, tracer_.contact_at(contact.face, proxy_, contact.normal))) {
      return false;
    }
  }
  return true;
}

void GodObject::keep_active_for_next_tick() {
  last_active_count_ = projection_.active_count;
  for (int i = 0; i < projection_.active_count; ++i) {
    last_active_[i] = contacts_[projection_.active[i]];
  }
}

ProxyState GodObject::report(int iterations, bool capped) const {
  ProxyState state;
  state.proxy = proxy_;
  state.iterations = iterations;
  state.capped = capped;
  const Vec3 lag = proxy_ - goal_;
  state.in_contact = lag.norm() > step_tolerance_m_;
  if (!state.in_contact) return state;
  state.active_planes = projection_.active_count;
  for (int i = 0; i < projection_.active_count; ++i) {
    state.normal += planes_of_contact_[projection_.active[i]].normal;
  }
  if (projection_.active_count == 0) {
    state.normal = lag.normalized();  // cut short by the cap before a plane was reached
  } else if (state.normal.norm() <= kCancelledNormal) {
    state.normal.setZero();
  } else {
    state.normal.normalize();
  }
  return state;
}

}  // namespace palpate
