#include "haptics/segment_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/pack_queries.h"
#include "haptics/float_trace.h"

namespace palpate {
namespace {

// A cheap tick searches for new candidates if the present ones will not last this many ticks more.
constexpr double kTicksAhead = 3.0;

// Searches for new candidates in one tick. A proxy that needs more is on a long way, and searches
// along its steps for the rest of it.
constexpr int kMostRefills = 4;

// How far a sphere looks for a hit first, in radii, if the step is not short, and how much farther
// each time after.
constexpr double kShortStep = 0.125;
constexpr double kFirstLook = 0.01;
constexpr double kFartherLook = 16.0;

// Packs that are asked in one go.
constexpr std::size_t kPacksAtOnce = 16;

// Bodies that a point may be in contact with at once, of those at rest.
constexpr std::size_t kMostBodiesAround = 64;

// A sphere's narrow phase is always in double: its stand-off is what its index was built for.
bool is_in_float(double radius_m, const Accuracy& accuracy) {
  return radius_m == 0.0 && accuracy.narrow_phase == NarrowPhase::kFloat;
}

SolverScale scale_for(const LiveWorld& world, double radius_m, const Accuracy& accuracy) {
  SolverScale scale = SolverScale::of(world.size_m(), radius_m);
  if (!is_in_float(radius_m, accuracy)) return scale;
  for (const ContactBody& body : world.bodies()) {
    scale.stand_off_m =
        std::max(scale.stand_off_m, float_stand_off_m(body.index->largest_pack_reach_m()));
  }
  scale.stop_m = SolverScale::kStopPerStandOff * scale.stand_off_m;
  scale.clearance_m = SolverScale::kClearancePerStandOff * scale.stand_off_m;
  return scale;
}

// Of the contacts of a point at p that it is given, the nearest that there is room for.
class NearestContacts {
 public:
  NearestContacts(const Vec3& p, std::span<FaceContact> room) : p_(p), room_(room) {}

  void add(const FaceContact& contact) {
    const auto is_nearer = [this](const FaceContact& a, const FaceContact& b) {
      return (a.feature_point - p_).squaredNorm() < (b.feature_point - p_).squaredNorm();
    };
    if (count_ < room_.size()) {
      room_[count_++] = contact;
      if (count_ == room_.size()) std::make_heap(room_.begin(), room_.end(), is_nearer);
      return;
    }
    if (!is_nearer(contact, room_.front())) return;
    std::pop_heap(room_.begin(), room_.end(), is_nearer);
    room_.back() = contact;
    std::push_heap(room_.begin(), room_.end(), is_nearer);
  }

  std::size_t count() const { return count_; }

 private:
  Vec3 p_;
  std::span<FaceContact> room_;
  std::size_t count_ = 0;
};

}  // namespace

// One query in flight.
struct SegmentTracer::Search {
  SegmentTracer& tracer;
  Vec3 p, q;  // solver frame
  // Hits beyond do not count. What is searched is the part of the step up to here.
  StepFraction limit;
  std::optional<TraceHit> best{};

  std::uint32_t body = 0;
  const ContactBody* placed = nullptr;
  const SolverCorners* corners = nullptr;  // of the body, if they are what decides
  Vec3 p_body = Vec3::Zero();
  Vec3 q_body = Vec3::Zero();
  Vec3 d_body = Vec3::Zero();  // the part searched, rounded: for what only sorts out

  void enter_body(std::uint32_t id) {
    if (placed && body == id) return;
    body = id;
    placed = &tracer.world_->body(id);
    p_body = placed->to_body(p);
    q_body = placed->to_body(q);
    d_body = limit.value() * (q_body - p_body);
    corners = tracer.decides_by_corners(*placed) ? placed->corners : nullptr;
    // A step that is shorter than the rounding of its ends in the body is a step all the same.
    if (corners) d_body = limit.value() * placed->direction_to_body(q - p);
  }

  // Enters a body with a step given in its own frame.
  void enter_body_at(std::uint32_t id, const Vec3& from_body, const Vec3& to_body) {
    body = id;
    placed = &tracer.world_->body(id);
    p_body = from_body;
    q_body = to_body;
    d_body = limit.value() * (q_body - p_body);
    corners = nullptr;
  }

  // Packs of the body entered.
  void consider_packs(std::span<const std::uint32_t> packs) {
    while (!packs.empty()) {
      const auto some = packs.first(std::min(packs.size(), kPacksAtOnce));
      packs = packs.subspan(some.size());
      if (tracer.radius_m_ == 0.0) {
        consider_for_point(some);
      } else {
        consider_for_sphere(some);
      }
    }
  }

  void consider_for_point(std::span<const std::uint32_t> packs) {
    std::array<PackLanes, kPacksAtOnce> doubtful;
    const std::size_t count = lanes_in_the_way(placed->index->packs(), packs, p_body, d_body,
                                               tracer.clearance_m(*placed), doubtful.data());
    for (const PackLanes& in : std::span(doubtful).first(count)) {
      for (std::uint32_t lanes = in.lanes; lanes != 0;) {
        consider_lane(in.pack, take_lane(lanes));
      }
    }
  }

  // First what the sphere touches where it is: as a rule that stops it, and tells the rest apart.
  void consider_for_sphere(std::span<const std::uint32_t> packs) {
    std::array<PackApproach, kPacksAtOnce> doubtful;
    const std::size_t count = lanes_in_reach(placed->index->packs(), packs, p_body, d_body,
                                             tracer.reach_m(), doubtful.data());
    const auto some = std::span(doubtful).first(count);
    for (PackApproach& in : some) {
      for (std::uint32_t lanes = in.lanes; lanes != 0;) {
        const int lane = take_lane(lanes);
        if (!in.is_in_reach_at_start(lane)) continue;
        in.lanes &= ~(1u << lane);
        consider_lane(in.pack, lane);
      }
    }
    float needed_up = needed_rounded_up();
    for (const PackApproach& in : some) {
      for (std::uint32_t lanes = in.lanes; lanes != 0;) {
        const int lane = take_lane(lanes);
        if (!in.may_be_in_reach_by(needed_up, lane)) continue;
        consider_lane(in.pack, lane);
        needed_up = needed_rounded_up();
      }
    }
  }

  void consider_lane(std::uint32_t pack, int lane) {
    const FaceRef face{body, SurfaceIndex::slot(pack, lane)};
    tracer.remember(face);
    consider(face);
  }

  // A triangle of the body entered.
  void consider(const FaceRef& face) {
    TriangleHit hit;
    if (meets(face.slot, hit)) keep_earlier(hit, face);
  }

  bool meets(std::uint32_t slot, TriangleHit& hit) const {
    const SurfaceIndex& index = *placed->index;
    const SolverScale& scale = tracer.scale_;
    if (tracer.is_in_float_) {
      const auto lane = static_cast<int>(slot % TrianglePack::kLanes);
      const TrianglePack& pack = index.pack(slot / TrianglePack::kLanes);
      return trace_point_in_float(pack, lane, p_body, q_body, scale.stop_m, hit);
    }
    if (corners) {
      const Vec3 normal = placed->direction_to_solver(index.triangle(slot).normal);
      return trace_point(corners->triangle(slot, normal), p, q, {scale.stop_m, scale.clearance_m},
                         hit);
    }
    if (tracer.radius_m_ == 0.0) {
      return trace_point(index.triangle(slot), p_body, q_body, {scale.stop_m, scale.clearance_m},
                         hit);
    }
    return trace_sphere(index.triangle(slot), p_body, q_body, tracer.radius_m_, scale.stop_m,
                        best ? best->meet_fraction : limit, hit);
  }

  // Of equal fractions the lowest slot wins, so that the order of the visits, which belongs to
  // Embree, does not show.
  void keep_earlier(const TriangleHit& hit, const FaceRef& face) {
    if (hit.meet_fraction > limit) return;
    if (best && hit.meet_fraction > best->meet_fraction) return;
    if (best && hit.meet_fraction == best->meet_fraction && face > best->contact.face) return;
    const bool is_in_solver = placed->is_identity || corners;
    const Vec3 normal =
        is_in_solver ? hit.normal : Vec3(placed->T_solver_body.direction(hit.normal).normalized());
    const Vec3 feature_point =
        is_in_solver ? hit.feature_point : placed->to_solver(hit.feature_point);
    best = TraceHit{{face, normal, hit.clearance_m, hit.feature, feature_point},
                    hit.fraction,
                    hit.meet_fraction};
  }

  // How far along the part searched a triangle can still matter.
  QueryFraction needed() const {
    return best ? QueryFraction(best->meet_fraction.value() / limit.value()) : QueryFraction::end();
  }
  float needed_rounded_up() const {
    return static_cast<float>(needed().value()) * (1 + 2 * std::numeric_limits<float>::epsilon());
  }
};

SegmentTracer::SegmentTracer(const LiveWorld& world, double radius_m, const Accuracy& accuracy)
    : world_(&world),
      radius_m_(radius_m),
      accuracy_(accuracy),
      is_in_float_(is_in_float(radius_m, accuracy)),
      scale_(scale_for(world, radius_m, accuracy)),
      // Half a stand-off is what hits need beyond the radius; two cover rounding as well.
      cache_(world, radius_m + 2 * scale_.stand_off_m) {}

void SegmentTracer::forget_doubtful() {
  doubtful_count_ = 0;
  doubtful_overflowed_ = false;
}

void SegmentTracer::remember(const FaceRef& face) {
  if (doubtful_count_ == kMostDoubtful) {
    doubtful_overflowed_ = true;
  } else {
    doubtful_[doubtful_count_++] = face;
  }
}

void SegmentTracer::search_candidates(Search& search) noexcept {
  std::array<std::uint32_t, CandidateCache::kCapacity> packs;
  for (std::size_t n = 0; n < cache_.body_count(); ++n) {
    search.enter_body(cache_.body(n));
    const std::size_t count = cache_.packs_along(n, search.p_body, search.d_body, packs);
    search.consider_packs(std::span(packs).first(count));
  }
}

void SegmentTracer::search_segment(Search& search) noexcept {
  const Vec3 d = search.limit.value() * (search.q - search.p);
  world_->visit_resting_along(search.p, d, sweep_radius_m(), [&](std::uint32_t b) {
    search.enter_body(b);
    search_body(search, b);
    return search.needed();
  });
}

void SegmentTracer::search_moving(Search& search) noexcept {
  for (const std::uint32_t b : world_->moving()) {
    if (b == left_out_) continue;
    search.enter_body(b);
    search_body(search, b);
  }
}

// The body that has been entered.
void SegmentTracer::search_body(Search& search, std::uint32_t body) noexcept {
  const ContactBody& placed = world_->body(body);
  placed.index->visit_segment(
      search.p_body, search.d_body, sweep_radius_m(placed),
      [](void* state, std::span<const std::uint32_t> packs) {
        auto& s = *static_cast<Search*>(state);
        s.consider_packs(packs);
        return s.needed();
      },
      &search);
}

// The less far a sphere looks, the fewer of the triangles about it are in doubt, and one that falls
// back on the surface is stopped at once as a rule. A fraction of the step.
double SegmentTracer::first_look(const Vec3& p, const Vec3& q) const {
  if (radius_m_ == 0.0) return 1.0;
  const double length_m = (q - p).lpNorm<Eigen::Infinity>();
  return length_m <= kShortStep * radius_m_ ? 1.0 : kFirstLook * radius_m_ / length_m;
}

std::optional<TraceHit> SegmentTracer::trace(const Vec3& p, const Vec3& q) noexcept {
  const bool is_long = !cache_.may_cover_step(q - p);
  for (int attempt = 0; accuracy_.reuse_candidates && attempt < 2; ++attempt) {
    bool is_inside = cache_.covers(p);
    for (double look = first_look(p, q); is_inside; look *= kFartherLook) {
      look = std::min(look, 1.0);
      forget_doubtful();
      Search search{*this, p, q, StepFraction(look)};
      search_candidates(search);
      search_moving(search);
      // Whatever happens inside the ball is known; the first of it counts.
      is_inside =
          cache_.covers(p + (search.best ? search.best->meet_fraction.value() : look) * (q - p));
      if (is_inside && (search.best || look == 1.0)) return search.best;
    }
    // A step that is too long for any ball is searched along.
    if (attempt == 0 && is_long && cache_.covers(p)) break;
    if (attempt > 0 || refills_ >= kMostRefills) break;
    refills_ = cache_.refill(p, motion_) ? refills_ + 1 : kMostRefills;
  }
  forget_doubtful();
  Search search{*this, p, q, StepFraction::end()};
  search_segment(search);
  search_moving(search);
  return search.best;
}

std::optional<TraceHit> SegmentTracer::trace_in_body(std::uint32_t body, const Vec3& p_body,
                                                     const Vec3& q_body) noexcept {
  forget_doubtful();
  const ContactBody& placed = world_->body(body);
  Search search{*this, placed.to_solver(p_body), placed.to_solver(q_body), StepFraction::end()};
  search.enter_body_at(body, p_body, q_body);
  search_body(search, body);
  return search.best;
}

std::optional<TraceHit> SegmentTracer::trace_others(std::uint32_t body, const Vec3& p,
                                                    const Vec3& q) noexcept {
  left_out_ = body;
  const auto hit = trace(p, q);
  left_out_ = kNoBody;
  return hit;
}

std::optional<TraceHit> SegmentTracer::trace_part(const Vec3& p, const Vec3& q) noexcept {
  if (doubtful_overflowed_) return trace(p, q);
  Search search{*this, p, q, StepFraction::end()};
  for (std::size_t i = 0; i < doubtful_count_; ++i) {
    search.enter_body(doubtful_[i].body);
    search.consider(doubtful_[i]);
  }
  return search.best;
}

void SegmentTracer::look_ahead(const Vec3& p, const Vec3& step, bool was_cheap) noexcept {
  motion_ = step;
  const bool has_refilled = refills_ > 0;
  refills_ = 0;
  if (!accuracy_.reuse_candidates || !was_cheap || has_refilled) return;
  if (cache_.covers(p + kTicksAhead * step)) return;
  cache_.refill(p, step);
}

FaceContact SegmentTracer::nearest_contact(const FaceRef& face, const Vec3& p) const noexcept {
  const ContactBody& body = world_->body(face.body);
  const TrianglePoint nearest =
      closest_point_on_triangle(body.index->triangle(face.slot), body.to_body(p));
  return {face, body.direction_to_solver(nearest.direction), nearest.distance - radius_m_,
          nearest.feature, body.to_solver(nearest.point)};
}

Vec3 SegmentTracer::edge_direction(const FaceContact& contact) const noexcept {
  const ContactBody& body = world_->body(contact.face.body);
  const TriangleGeometry& t = body.index->triangle(contact.face.slot);
  const Vec3 p_body = body.to_body(contact.feature_point);
  Vec3 nearest = Vec3::Zero();
  double least_m = std::numeric_limits<double>::infinity();
  for (const auto& [from, to] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
    const Vec3 direction = (to - from).normalized();
    const double distance_m = (p_body - from).cross(direction).norm();
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    nearest = direction;
  }
  return body.direction_to_solver(nearest);
}

FaceContact SegmentTracer::contact_at(const FaceRef& face, const Vec3& p,
                                      const Vec3& side) const noexcept {
  const FaceContact nearest = nearest_contact(face, p);
  if (radius_m_ > 0.0) return nearest;
  const ContactBody& body = world_->body(face.body);
  const Vec3 direction_body = body.direction_to_body(nearest.normal);
  if (!is_rather_over(body.index->triangle(face.slot), direction_body)) return nearest;
  const bool can_tell = nearest.clearance_m >= scale_.clearance_m;
  FaceContact contact = contact_over(face, p, can_tell ? nearest.normal : side);
  contact.feature = nearest.feature;
  return contact;
}

FaceContact SegmentTracer::contact_over(const FaceRef& face, const Vec3& p,
                                        const Vec3& side) const noexcept {
  const ContactBody& body = world_->body(face.body);
  const TriangleGeometry& t = body.index->triangle(face.slot);
  const Vec3 p_body = body.to_body(p);
  const Vec3 normal = t.normal.dot(body.direction_to_body(side)) < 0.0 ? Vec3(-t.normal) : t.normal;
  const double height = normal.dot(p_body - t.a);
  return {face, body.direction_to_solver(normal), height, TriangleFeature::kFace,
          body.to_solver(p_body - height * normal)};
}

bool SegmentTracer::is_over(const FaceContact& contact, const Vec3& p) const noexcept {
  if (radius_m_ > 0.0) {
    // Still touching: the tangent plane it was stopped by supports the sphere here as well.
    return contact_at(contact.face, p, contact.normal).clearance_m <= scale_.stand_off_m;
  }
  if (contact.feature != TriangleFeature::kFace) return false;
  const ContactBody& body = world_->body(contact.face.body);
  return prism_contains(body.index->triangle(contact.face.slot), body.to_body(p));
}

std::size_t SegmentTracer::contacts_in_front(const Vec3& p, double reach_m,
                                             std::span<FaceContact> contacts) const noexcept {
  std::array<std::uint32_t, kMostBodiesAround> bodies;
  std::size_t body_count = 0;
  world_->visit_resting_near(p, reach_m, [&](std::uint32_t b) {
    const ContactBody& body = world_->body(b);
    if (body.index->box().squared_distance(body.to_body(p)) > reach_m * reach_m) return true;
    bodies[body_count++] = b;
    return body_count < bodies.size();
  });
  std::sort(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(body_count));
  NearestContacts nearest(p, contacts);
  const auto add = [&](const FaceContact& contact) { nearest.add(contact); };
  for (const std::uint32_t b : std::span(bodies).first(body_count)) {
    visit_contacts(b, p, reach_m, add);
  }
  for (const std::uint32_t b : world_->moving()) visit_contacts(b, p, reach_m, add);
  return nearest.count();
}

template <typename Visitor>
void SegmentTracer::visit_contacts(std::uint32_t b, const Vec3& p, double reach_m,
                                   const Visitor& visit) const noexcept {
  const ContactBody& body = world_->body(b);
  const Vec3 p_body = body.to_body(p);
  std::array<std::uint32_t, CandidateCache::kCapacity> packs;
  const std::size_t found = std::min(packs.size(), body.index->packs_near(p_body, reach_m, packs));
  std::sort(packs.begin(), packs.begin() + static_cast<std::ptrdiff_t>(found));
  for (const std::uint32_t pack : std::span(packs).first(found)) {
    for (int lane = 0; lane < body.index->pack(pack).count; ++lane) {
      const std::uint32_t slot = SurfaceIndex::slot(pack, lane);
      const TriangleGeometry& t = body.index->triangle(slot);
      const TrianglePoint nearest = closest_point_on_triangle(t, p_body);
      if (nearest.distance > reach_m) continue;
      visit({{b, slot},
             body.direction_to_solver(t.normal),
             t.normal.dot(p_body - t.a),
             TriangleFeature::kFace,
             body.to_solver(nearest.point)});
    }
  }
}

std::size_t SegmentTracer::contacts_around(const Vec3& p, double reach_m,
                                           std::span<FaceContact> contacts) const noexcept {
  const std::size_t count = contacts_in_front(p, reach_m, contacts);
  for (FaceContact& contact : contacts.first(count)) {
    if (contact.clearance_m >= 0.0) continue;
    contact.normal = -contact.normal;
    contact.clearance_m = -contact.clearance_m;
  }
  return count;
}

std::optional<FaceContact> SegmentTracer::steepest_contact(const Vec3& p,
                                                           const Vec3& d) const noexcept {
  std::optional<FaceContact> steepest;
  double least = 0.0;
  for (std::size_t i = 0; i < doubtful_count_; ++i) {
    const FaceContact contact = nearest_contact(doubtful_[i], p);
    const double approach = contact.normal.dot(d);
    if (contact.clearance_m > scale_.stop_m || approach >= least) continue;
    least = approach;
    steepest = contact;
  }
  return steepest;
}

}  // namespace palpate
