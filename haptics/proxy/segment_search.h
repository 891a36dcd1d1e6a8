#pragma once

// The state of one query of a SegmentTracer. Private to segment_tracer.cpp.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "geometry/index/pack_queries.h"
#include "haptics/proxy/float_trace.h"
#include "haptics/proxy/segment_tracer.h"

namespace palpate {

// Number of packs that are tested in one call.
constexpr std::size_t kPacksAtOnce = 16;

// The smallest fraction of a segment that is searched after a hit was found, so that obstacles at
// the very start are not missed.
constexpr double kLeastPart = 0x1p-20;

// The state of one query.
struct SegmentTracer::Search {
  SegmentTracer& tracer;
  Vec3 p, q;  // solver frame
  // The search covers the step up to this fraction; hits beyond it do not count.
  StepFraction limit;
  std::optional<TraceHit> best;

  // The body being searched.
  std::uint32_t body = 0;
  const ContactBody* placed = nullptr;
  const SolverCorners* corners = nullptr;  // set if crossings are decided with these corners
  Vec3 p_body, q_body;                     // the step in the body frame
  Vec3 p_index, d_index;  // the part of the step searched, index frame, rounded: for exclusion only
  double sorted_within;   // index frame: triangles beyond this distance from that part are excluded

  bool is_resumed = false;
  bool has_begun = false;  // a batch of packs is complete, so the search may be cut short

  // Because of this constructor, the class is not an aggregate. Zeroing an aggregate before its use
  // would take as long as testing a pack.
  Search(SegmentTracer& by, const Vec3& from, const Vec3& to, StepFraction up_to)
      : tracer(by), p(from), q(to), limit(up_to) {}

  // Limits the search to the part of the step before the best hit so far.
  void shorten() {
    if (!best) return;
    limit = std::min(limit, StepFraction(std::max(best->meet_fraction.value(), kLeastPart)));
  }

  void enter_body(std::uint32_t id) {
    if (placed && body == id) return;
    body = id;
    placed = &tracer.world_->body(id);
    corners = tracer.decides_by_corners(*placed) ? placed->corners : nullptr;
    p_body = placed->to_body(p);
    q_body = placed->to_body(q);
    // A step shorter than the rounding of its transformed end points must not vanish.
    enter_index(corners ? placed->displacement_to_body(q - p) : Vec3(q_body - p_body));
  }

  // Enters a body with a step given in the frame of that body.
  void enter_body_at(std::uint32_t id, const Vec3& from_body, const Vec3& to_body) {
    body = id;
    placed = &tracer.world_->body(id);
    p_body = from_body;
    q_body = to_body;
    corners = nullptr;
    enter_index(q_body - p_body);
  }

  void enter_index(const Vec3& d_body) {
    double within_m = tracer.radius_m_ > 0.0 ? tracer.reach_m() : tracer.scale_.clearance_m;
    // The search radius grows by the largest distance between the body's corners and those of its
    // index.
    if (corners) within_m += kMostApartPerStandOff * tracer.scale_.stand_off_m;
    p_index = p_body;
    d_index = limit.value() * d_body;
    sorted_within = placed->length_to_body(within_m);
    if (!placed->stretch) [[likely]]
      return;
    p_index = placed->to_index(p_index);
    d_index = placed->to_index(d_index);
    sorted_within = placed->reach_index(within_m, p_body);
  }

  // The sweep radius of index queries. It is 0 if the float margins of these queries cover the
  // point's clearance.
  double sweep_radius() const {
    const bool is_covered = tracer.radius_m_ == 0.0 && !corners && !placed->stretch;
    return is_covered ? 0.0 : sorted_within;
  }

  bool misses_body() const { return !placed->index->may_meet(p_index, d_index, sweep_radius()); }

  bool must_stop() const { return has_begun && tracer.work_.is_spent(); }

  // Tests packs of the entered body. Returns false if the budget ends before the last pack; the
  // first untested pack is then in `unexamined`.
  bool consider_packs(std::span<const std::uint32_t> packs, std::uint32_t& unexamined) {
    while (!packs.empty()) {
      unexamined = packs.front();
      if (must_stop()) return false;
      const auto some = packs.first(std::min(packs.size(), packs_at_once()));
      packs = packs.subspan(some.size());
      if (!(tracer.radius_m_ == 0.0 ? consider_for_point(some) : consider_for_sphere(some))) {
        return false;
      }
      has_begun = true;
    }
    return true;
  }

  // A resumed search tests single packs, so that it progresses even with the smallest budget.
  std::size_t packs_at_once() const { return is_resumed ? 1 : kPacksAtOnce; }

  bool consider_for_point(std::span<const std::uint32_t> packs) {
    tracer.work_.add(Work::kPack, packs.size());
    std::array<PackLanes, kPacksAtOnce> doubtful;
    const std::size_t count = lanes_in_the_way(placed->index->packs(), packs, p_index, d_index,
                                               sorted_within, doubtful.data());
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0 && tracer.work_.is_spent()) return false;  // a single pack is always completed
      for (std::uint32_t lanes = doubtful[i].lanes; lanes != 0;) {
        consider_lane(doubtful[i].pack, take_lane(lanes));
      }
    }
    return true;
  }

  // First tests the triangles that the sphere touches at the start. Usually one of them stops the
  // step, and most other triangles are then excluded.
  bool consider_for_sphere(std::span<const std::uint32_t> packs) {
    tracer.work_.add(Work::kSpherePack, packs.size());
    std::array<PackApproach, kPacksAtOnce> doubtful;
    const std::size_t count = lanes_in_reach(placed->index->packs(), packs, p_index, d_index,
                                             sorted_within, doubtful.data());
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0 && tracer.work_.is_spent()) return false;
      PackApproach& in = doubtful[i];
      for (std::uint32_t lanes = in.lanes; lanes != 0;) {
        const int lane = take_lane(lanes);
        if (!in.is_in_reach_at_start(lane)) continue;
        in.lanes &= ~(1u << lane);
        consider_lane(in.pack, lane);
      }
    }
    float needed_up = needed_rounded_up();
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0 && tracer.work_.is_spent()) return false;
      const PackApproach& in = doubtful[i];
      for (std::uint32_t lanes = in.lanes; lanes != 0;) {
        const int lane = take_lane(lanes);
        if (!in.may_be_in_reach_by(needed_up, lane)) continue;
        consider_lane(in.pack, lane);
        needed_up = needed_rounded_up();
      }
    }
    return true;
  }

  void consider_lane(std::uint32_t pack, int lane) {
    const FaceRef face{body, SurfaceIndex::slot(pack, lane)};
    tracer.doubtful_.add(face);
    consider(face);
  }

  // Tests a triangle of the entered body in double precision and counts the work.
  void consider(const FaceRef& face) {
    TriangleHit hit;
    TriangleWork work;
    const bool is_met = meets(face.slot, hit, work);
    tracer.count(work);
    if (placed->stretch) [[unlikely]]
      tracer.work_.add(Work::kStretchedTriangle, tracer.made_.take_made_count());
    if (corners) [[unlikely]]
      tracer.work_.add(Work::kStretchedTriangle, tracer.made_at_corners_.take_made_count());
    if (is_met) keep_earlier(hit, face);
  }

  bool meets(std::uint32_t slot, TriangleHit& hit, TriangleWork& work) const {
    const SolverScale& scale = tracer.scale_;
    const double stop = placed->length_to_body(scale.stop_m);
    if (tracer.is_in_float_ && !placed->stretch) {
      const auto lane = static_cast<int>(slot % TrianglePack::kLanes);
      const TrianglePack& pack = placed->index->pack(slot / TrianglePack::kLanes);
      return trace_point_in_float(pack, lane, p_body, q_body, stop, hit);
    }
    if (corners) {
      return trace_point(tracer.made_at_corners_.at_corners(*placed, {body, slot}), p, q,
                         {scale.stop_m, scale.clearance_m}, hit, work);
    }
    const TriangleGeometry& t = tracer.made_.of(*placed, {body, slot});
    if (tracer.radius_m_ == 0.0) {
      return trace_point(t, p_body, q_body, {stop, placed->length_to_body(scale.clearance_m)}, hit,
                         work);
    }
    return trace_sphere(t, p_body, q_body, placed->length_to_body(tracer.radius_m_), stop,
                        best ? std::min(best->meet_fraction, limit) : limit, hit, work);
  }

  // Keeps the earlier of two hits. Among hits at the same fraction the lowest FaceRef wins, so that
  // the result does not depend on Embree's order of visits.
  void keep_earlier(const TriangleHit& hit, const FaceRef& face) {
    if (hit.meet_fraction > limit) return;
    if (best && hit.meet_fraction > best->meet_fraction) return;
    if (best && hit.meet_fraction == best->meet_fraction && face > best->contact.face) return;
    Vec3 normal = hit.normal;
    Vec3 feature_point = hit.feature_point;
    double clearance_m = hit.clearance_m;
    if (!corners) {
      normal = placed->direction_to_solver(normal);
      if (!placed->is_identity) normal.normalize();
      feature_point = placed->to_solver(feature_point);
      clearance_m = placed->length_to_solver(clearance_m);
    } else if (corners->are_for_contacts() && hit.feature == TriangleFeature::kEdge) {
      normal = tracer.across_edge({face, normal, clearance_m, hit.feature, feature_point});
    }
    best = TraceHit{
        {face, normal, clearance_m, hit.feature, feature_point}, hit.fraction, hit.meet_fraction};
  }

  // The fraction of the searched part up to which a triangle can still be the first hit.
  double needed() const {
    return best ? std::max(best->meet_fraction.value() / limit.value(), kLeastPart) : 1.0;
  }
  float needed_rounded_up() const {
    const double needed = best ? best->meet_fraction.value() / limit.value() : 1.0;
    return static_cast<float>(needed) * (1 + 2 * std::numeric_limits<float>::epsilon());
  }
};

}  // namespace palpate
