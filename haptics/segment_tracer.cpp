#include "haptics/segment_tracer.h"

#include <cmath>
#include <tuple>

#include "geometry/pack_queries.h"
#include "haptics/triangle_trace.h"

namespace palpate {
namespace {

// The cached ball, in mean pack diagonals: large enough for a few ticks of motion, small enough
// that a search sees a handful of packs.
constexpr double kBallPerPackDiagonal = 0.3;

double finest_pack_diagonal(const ContactWorld& world) {
  double finest = world.size_m;
  for (const ContactBody& body : world.bodies) {
    finest = std::min(finest, body.index->mean_pack_diagonal_m());
  }
  return finest;
}

// The part of the step p to p + d inside a ball that contains p, as a fraction that may exceed 1.
double fraction_inside(const Vec3& centre, double radius, const Vec3& p, const Vec3& d) {
  const Vec3 from_centre = p - centre;
  const double a = d.squaredNorm();
  const double b = from_centre.dot(d);
  const double c = from_centre.squaredNorm() - radius * radius;
  if (c > 0.0) return 0.0;
  if (a == 0.0) return 1.0;
  return (std::sqrt(b * b - a * c) - b) / a;
}

}  // namespace

// One query in flight.
struct SegmentTracer::Search {
  const SegmentTracer& tracer;
  Vec3 p, d;     // solver frame
  double limit;  // hits beyond this fraction of the step do not count
  TraceHit best{};
  bool found = false;

  std::uint32_t body = 0;
  const ContactBody* placed = nullptr;
  Vec3 p_body = Vec3::Zero();
  Vec3 d_body = Vec3::Zero();

  void enter_body(std::uint32_t id) {
    if (placed && body == id) return;
    body = id;
    placed = &tracer.world_->bodies[id];
    p_body = placed->is_identity ? p : placed->T_solver_body.inverse_point(p);
    d_body = placed->is_identity ? d : placed->T_solver_body.inverse_direction(d);
  }

  void consider(std::uint32_t pack_id) {
    const TrianglePack& pack = placed->index->pack(pack_id);
    const bool is_point = tracer.radius_m_ == 0.0;
    const SolverScale& scale = tracer.scale_;
    const unsigned lanes = is_point ? lanes_in_the_way(pack, p_body, d_body, scale.clearance_m)
                                    : (1u << pack.count) - 1u;
    for (unsigned lane = 0; lane < TrianglePack::kLanes; ++lane) {
      if (!(lanes >> lane & 1u)) continue;
      TriangleHit hit;
      const TriangleGeometry triangle = pack.triangle(static_cast<int>(lane));
      const bool met =
          is_point
              ? trace_point(triangle, p_body, d_body, {scale.stand_off_m, scale.clearance_m}, hit)
              : trace_sphere(triangle, p_body, d_body, tracer.radius_m_, scale.stand_off_m, hit);
      if (met) keep_earlier(hit, {body, pack_id, lane});
    }
  }

  // Of equal fractions the lowest face number wins, so that the order of the visits, which belongs
  // to Embree, does not show.
  void keep_earlier(const TriangleHit& hit, const FaceRef& face) {
    if (hit.meet_fraction > limit) return;
    if (found) {
      if (hit.meet_fraction > best.meet_fraction) return;
      const auto key = [](const FaceRef& f) { return std::tuple(f.body, f.pack, f.lane); };
      if (hit.meet_fraction == best.meet_fraction && key(face) > key(best.contact.face)) return;
    }
    found = true;
    const bool same = placed->is_identity;
    best = {{face, same ? hit.normal : placed->T_solver_body.direction(hit.normal).normalized(),
             hit.clearance_m, hit.feature,
             same ? hit.feature_point : placed->T_solver_body.point(hit.feature_point)},
            hit.fraction,
            hit.meet_fraction};
  }
};

SegmentTracer::SegmentTracer(const ContactWorld& world, double radius_m, const Accuracy& accuracy)
    : world_(&world),
      radius_m_(radius_m),
      scale_(SolverScale::of(world.size_m, radius_m)),
      accuracy_(accuracy),
      default_ball_m_(kBallPerPackDiagonal * finest_pack_diagonal(world)) {}

bool SegmentTracer::fill_cache(const Vec3& p, const Vec3& d) noexcept {
  // Half the step and a stand-off is the least that covers it.
  const double least = 0.5 * d.norm() + 2 * scale_.stand_off_m;
  if (least > default_ball_m_) return false;
  std::array<std::uint32_t, kCacheCapacity> packs;
  for (double ball = default_ball_m_; ball >= least; ball *= 0.5) {
    ball_centre_ = p + 0.5 * d;
    ball_radius_m_ = ball;
    cached_count_ = 0;
    bool full = false;
    for (std::uint32_t b = 0; b < world_->bodies.size() && !full; ++b) {
      const ContactBody& body = world_->bodies[b];
      const Vec3 centre =
          body.is_identity ? ball_centre_ : body.T_solver_body.inverse_point(ball_centre_);
      const std::size_t room = kCacheCapacity - cached_count_;
      // Half a stand-off is what hits need beyond the radius; two more cover rounding.
      const std::size_t count = body.index->packs_near(
          centre, ball + radius_m_ + 2 * scale_.stand_off_m, std::span(packs).first(room));
      full = count > room;
      for (std::size_t i = 0; i < std::min(count, room); ++i) {
        cached_packs_[cached_count_++] = {b, packs[i]};
      }
    }
    if (!full) return true;
  }
  ball_radius_m_ = -1.0;
  return false;
}

void SegmentTracer::search_cache(Search& search) const noexcept {
  for (std::size_t i = 0; i < cached_count_; ++i) {
    search.enter_body(cached_packs_[i].body);
    search.consider(cached_packs_[i].pack);
  }
}

void SegmentTracer::search_segment(Search& search) const noexcept {
  const double reach = radius_m_ == 0.0 ? 0.0 : radius_m_ + scale_.stand_off_m;
  for (std::uint32_t b = 0; b < world_->bodies.size(); ++b) {
    search.enter_body(b);
    search.placed->index->visit_segment(
        search.p_body, search.d_body, reach,
        [](void* state, std::uint32_t pack) {
          auto& s = *static_cast<Search*>(state);
          s.consider(pack);
          return s.found ? s.best.meet_fraction : 1.0;
        },
        &search);
  }
}

std::optional<TraceHit> SegmentTracer::trace(const Vec3& p, const Vec3& d) noexcept {
  const auto finish = [](const Search& s) {
    return s.found ? std::optional(s.best) : std::nullopt;
  };
  for (int attempt = 0; accuracy_.reuse_candidates && attempt < 2; ++attempt) {
    const double inside =
        ball_radius_m_ > 0.0 ? fraction_inside(ball_centre_, ball_radius_m_, p, d) : 0.0;
    if (inside > 0.0) {
      Search search{*this, p, d, std::min(1.0, inside)};
      search_cache(search);
      if (search.found || inside >= 1.0) return finish(search);
    }
    if (attempt > 0 || !fill_cache(p, d)) break;
  }
  Search search{*this, p, d, 1.0};
  search_segment(search);
  return finish(search);
}

FaceContact SegmentTracer::contact_at(const FaceRef& face, const Vec3& p,
                                      const Vec3& side) const noexcept {
  const ContactBody& body = world_->bodies[face.body];
  const TriangleGeometry t = body.index->pack(face.pack).triangle(static_cast<int>(face.lane));
  const Vec3 p_body = body.T_solver_body.inverse_point(p);
  const Vec3 side_body = body.T_solver_body.inverse_direction(side);
  if (radius_m_ == 0.0) {
    const Vec3 normal = t.normal.dot(side_body) < 0.0 ? Vec3(-t.normal) : t.normal;
    const double height = normal.dot(p_body - t.a);
    return {face, body.T_solver_body.direction(normal), height, TriangleFeature::kFace,
            body.T_solver_body.point(p_body - height * normal)};
  }
  const TrianglePoint nearest = closest_point_on_triangle(t, p_body);
  return {face, body.T_solver_body.direction(nearest.direction), nearest.distance - radius_m_,
          nearest.feature, body.T_solver_body.point(nearest.point)};
}

bool SegmentTracer::is_over(const FaceContact& contact, const Vec3& p) const noexcept {
  const ContactBody& body = world_->bodies[contact.face.body];
  if (radius_m_ > 0.0) {
    // Still touching: the tangent plane it was stopped by supports the sphere here as well.
    return contact_at(contact.face, p, contact.normal).clearance_m <= 2 * scale_.stand_off_m;
  }
  if (contact.feature != TriangleFeature::kFace) return false;
  const TrianglePack& pack = body.index->pack(contact.face.pack);
  return prism_contains(pack.triangle(static_cast<int>(contact.face.lane)),
                        body.T_solver_body.inverse_point(p));
}

std::size_t SegmentTracer::contacts_near(const Vec3& p, double reach_m,
                                         std::span<FaceContact> contacts) const noexcept {
  std::size_t count = 0;
  std::array<std::uint32_t, kCacheCapacity> packs;
  for (std::uint32_t b = 0; b < world_->bodies.size(); ++b) {
    const ContactBody& body = world_->bodies[b];
    const Vec3 p_body = body.T_solver_body.inverse_point(p);
    const std::size_t found =
        std::min(packs.size(), body.index->packs_near(p_body, reach_m, packs));
    std::sort(packs.begin(), packs.begin() + static_cast<std::ptrdiff_t>(found));
    for (std::size_t i = 0; i < found; ++i) {
      const TrianglePack& pack = body.index->pack(packs[i]);
      for (int lane = 0; lane < pack.count && count < contacts.size(); ++lane) {
        const TriangleGeometry t = pack.triangle(lane);
        const TrianglePoint nearest = closest_point_on_triangle(t, p_body);
        if (nearest.distance > reach_m) continue;
        contacts[count++] = {{b, packs[i], static_cast<std::uint32_t>(lane)},
                             body.T_solver_body.direction(t.normal),
                             t.normal.dot(p_body - t.a),
                             nearest.feature,
                             body.T_solver_body.point(nearest.point)};
      }
    }
  }
  return count;
}

}  // namespace palpate
