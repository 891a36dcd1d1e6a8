#include "haptics/effects/nearest_search.h"

#include <algorithm>
#include <span>

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
  NearestCursor* cursor;
  NearestResult result = {};
  bool has_visited = false;  // a pack

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

  bool must_stop() const { return has_visited && work.is_spent(); }

  // A NearestVisitor.
  static double next(void* state, std::optional<std::uint32_t> pack) {
    auto& self = *static_cast<Search*>(state);
    if (pack) {
      self.visit(*pack);
      self.has_visited = true;
    } else {
      self.work.add(Work::kBoxes);
    }
    if (!self.must_stop()) return self.radius_index();
    self.result.is_cut_short = true;
    return -1.0;
  }

  // Nearest boxes first.
  void run() {
    Vec3 axes_per_radius;
    if (stretch != nullptr) {
      const StretchedBall ball = stretch->ball_index(best, p_body);
      axes_per_radius = ball.by_axis_m / ball.radius_m;
    }
    index.visit_nearest_in_order(p_index, radius_index(),
                                 stretch != nullptr ? &axes_per_radius : nullptr, Search::next,
                                 this);
  }

  // A NearPackVisitor of the packs from cursor->next_pack on.
  static bool visit_some(void* state, std::span<const std::uint32_t> packs) {
    auto& self = *static_cast<Search*>(state);
    return std::all_of(packs.begin(), packs.end(), [&](std::uint32_t pack) {
      if (self.must_stop()) {
        self.result.is_cut_short = true;
        self.advance_to(pack);
        return false;
      }
      self.visit(pack);
      self.has_visited = true;
      return true;
    });
  }

  // Round and round, until no pack is left or the work is spent.
  void go_on() {
    while (cursor->packs_left > 0 && !must_stop()) {
      work.add(
          index.visit_packs_near(p_index, radius_index(), cursor->next_pack, visit_some, this));
      if (result.is_cut_short) return;
      advance_to(static_cast<std::uint32_t>(index.pack_count()));
      cursor->next_pack = 0;
    }
    result.is_cut_short = cursor->packs_left > 0;
  }
  void advance_to(std::uint32_t pack) {
    cursor->packs_left -= std::min(cursor->packs_left, pack - cursor->next_pack);
    cursor->next_pack = pack;
  }
};

}  // namespace

NearestResult find_nearest(const SurfaceIndex& index, const Stretch* stretch, const Vec3& p_body,
                           double range, bool has_moved, NearestCursor& cursor,
                           WorkMeter& work) noexcept {
  Search search{index, stretch, p_body, stretch != nullptr ? stretch->to_index(p_body) : p_body,
                range, work,    &cursor};
  const auto all = static_cast<std::uint32_t>(index.pack_count());
  if (cursor.slot == NearestCursor::kNone && cursor.packs_left == 0) {
    search.run();
    if (!search.result.is_cut_short) return search.result;
    cursor = {NearestCursor::kNone, 0, all};
  } else {
    if (has_moved) cursor.packs_left = all;
    const bool is_whole = cursor.packs_left == all;
    if (cursor.slot != NearestCursor::kNone) search.consider(cursor.slot);
    search.go_on();
    // The search of one tick sufficed, so the next one is a usual one.
    if (!search.result.is_cut_short && is_whole && all > 0) {
      cursor = {};
      return search.result;
    }
  }
  if (search.result.nearest) cursor.slot = search.result.nearest->slot;
  return search.result;
}

}  // namespace palpate
