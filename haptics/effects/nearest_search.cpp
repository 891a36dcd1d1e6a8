#include "haptics/effects/nearest_search.h"

#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

struct Search {
  const SurfaceIndex& index;
  const Stretch* stretch;
  Vec3 p_body;
  Vec3 p_index;
  double best;  // body frame
  WorkMeter& work;
  NearestResult result = {};

  double radius_index() const {
    return stretch != nullptr ? stretch->reach_index(best, p_body) : best;
  }

  void consider(std::uint32_t slot) {
    work.add(Work::kNearestPoint);
    TrianglePoint point;
    if (stretch != nullptr) {
      work.add(Work::kStretchedTriangle);
      point = closest_point_on_triangle(stretch->triangle(index.triangle(slot)), p_body);
    } else {
      point = closest_point_on_triangle(index.triangle(slot), p_body);
    }
    if (point.distance > best || (result.nearest && point.distance == best)) return;
    best = point.distance;
    result.nearest = NearestPoint{point.point, point.distance, slot};
  }

  void visit(std::uint32_t pack_id) {
    work.add(Work::kNearestPack);
    const TrianglePack& pack = index.pack(pack_id);
    double radius = radius_index();
    LaneDistances distances;
    // The lane with the smallest distance estimate is first: it usually rules out all other lanes.
    for (std::uint32_t lanes = lanes_within(pack, p_index, radius, distances); lanes != 0;) {
      const int lane = least_lane(lanes, distances.squared);
      lanes &= ~(1u << lane);
      if (!distances.may_be_within(lane, local_length(pack, radius))) return;
      consider(SurfaceIndex::slot(pack_id, lane));
      radius = radius_index();
    }
  }

  // A NearestVisitor.
  static double next(void* state, std::optional<std::uint32_t> pack) {
    auto& self = *static_cast<Search*>(state);
    if (pack) {
      self.visit(*pack);
    } else {
      self.work.add(Work::kBoxes);
    }
    if (!self.work.is_spent()) return self.radius_index();
    self.result.is_cut_short = true;
    return -1.0;
  }
};

}  // namespace

NearestResult find_nearest(const SurfaceIndex& index, const Stretch* stretch, const Vec3& p_body,
                           double range, std::optional<std::uint32_t> known,
                           WorkMeter& work) noexcept {
  Search search{index, stretch, p_body, stretch != nullptr ? stretch->to_index(p_body) : p_body,
                range, work};
  if (known) search.consider(*known);
  Vec3 axes_per_radius;
  if (stretch != nullptr) {
    const StretchedBall ball = stretch->ball_index(range, p_body);
    axes_per_radius = ball.by_axis_m / ball.radius_m;
  }
  index.visit_nearest_in_order(search.p_index, search.radius_index(),
                               stretch != nullptr ? &axes_per_radius : nullptr, Search::next,
                               &search);
  return search.result;
}

}  // namespace palpate
