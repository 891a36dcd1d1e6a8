#include "geometry/index/surface_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "geometry/exact/segment_triangle.h"
#include "geometry/index/embree_boxes.h"
#include "geometry/index/pack_builder.h"
#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

// A segment query in progress.
struct PackSearch {
  SegmentQuery segment;
  const SurfaceIndex* index;
  PackVisitor visitor;
  void* state;
  float radius;
};

// The packs in a set of lanes of one cluster.
struct ClusterPacks {
  std::array<std::uint32_t, TrianglePack::kLanes> ids;
  std::size_t count = 0;
  ClusterPacks(std::uint32_t cluster, std::uint32_t lanes) {
    while (lanes != 0) ids[count++] = SurfaceIndex::slot(cluster, take_lane(lanes));
  }
  std::span<const std::uint32_t> span() const { return std::span(ids).first(count); }
};

// Inserts some packs in ascending order into a sorted list, usually at its end.
void insert_in_order(std::span<const std::uint32_t> some, std::span<std::uint32_t> packs) {
  std::size_t i = packs.size() - some.size();
  for (; i > 0 && packs[i - 1] > some.front(); --i) packs[i - 1 + some.size()] = packs[i - 1];
  std::copy(some.begin(), some.end(), packs.begin() + static_cast<std::ptrdiff_t>(i));
}

// The largest number of packs that a search collects. If a segment has more packs, a shorter first
// part of the segment with few enough packs is visited first, and then all packs in order. Each try
// shortens the part by kShorterEachTime, at most kMostShortenings times.
constexpr std::size_t kMostPacksAtOnce = 256;
constexpr double kShorterEachTime = 1.0 / 16;
constexpr std::size_t kFewPacks = 2;  // in the first call of the visitor
constexpr int kMostShortenings = 5;
constexpr double kShortestPart = 0x1p-20;  // after all shortenings

// The packs near a segment, up to kMostPacksAtOnce.
class FoundPacks {
 public:
  FoundPacks(const SurfaceIndex& index, const Vec3& p, const Vec3& d, double radius_m)
      : index_(index), p_(p), d_(d), radius_m_(radius_m) {
    index.visit_segment(
        p, d, radius_m,
        [](void* state, std::span<const std::uint32_t> packs) {
          return static_cast<FoundPacks*>(state)->add(packs);
        },
        this);
  }

  bool are_too_many() const { return are_too_many_; }
  std::size_t count() const { return count_; }

  // Visits packs in the order in which the segment reaches them, until the visitor needs no more.
  // The first call has only a few packs, because one of them usually ends the search. The searched
  // segment is the fraction `part` of the visitor's segment; the visitor's answers and the result
  // are fractions of the visitor's segment.
  QueryFraction visit(double part, OrderedPackVisitor visitor, void* state) {
    std::sort(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count_));
    std::array<std::uint32_t, TrianglePack::kLanes> packs;
    std::size_t most = kFewPacks;
    QueryFraction needed = QueryFraction::end();
    for (std::size_t i = 0; i < count_ && QueryFraction(part * found_[i].entry) <= needed;) {
      std::size_t some = 0;
      for (; some < most && i < count_; ++some, ++i) packs[some] = found_[i].pack;
      needed = visitor(state, std::span(packs).first(some), false);
      most = packs.size();
    }
    return needed;
  }

 private:
  struct Found {
    double entry;  // where the segment reaches the box with margins: a fraction
    std::uint32_t pack;
    friend auto operator<=>(const Found&, const Found&) = default;
  };

  QueryFraction add(std::span<const std::uint32_t> packs) {
    are_too_many_ = are_too_many_ || count_ + packs.size() > found_.size();
    if (are_too_many_) return kNothingMore;
    for (const std::uint32_t pack : packs) found_[count_++] = {entry_of(pack), pack};
    return QueryFraction::end();
  }

  double entry_of(std::uint32_t pack) const {
    const BoxPack& boxes = index_.cluster_boxes(pack / TrianglePack::kLanes);
    const std::uint32_t lane = pack % TrianglePack::kLanes;
    double entry = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (d_[k] == 0.0) continue;
      const double side = d_[k] > 0.0 ? double{boxes.low[k][lane]} - radius_m_
                                      : double{boxes.high[k][lane]} + radius_m_;
      entry = std::max(entry, (side - p_[k]) / d_[k]);
    }
    return entry;
  }

  const SurfaceIndex& index_;
  const Vec3& p_;
  Vec3 d_;
  double radius_m_;
  std::array<Found, kMostPacksAtOnce> found_;
  std::size_t count_ = 0;
  bool are_too_many_ = false;
};

bool may_hold_some(const Box& box, const Vec3& p, const StretchedBall& ball) {
  const Vec3 outside = (box.low - p).cwiseMax(p - box.high);
  return (outside.array() <= ball.by_axis_m.array()).all() &&
         box.squared_distance(p) <= ball.radius_m * ball.radius_m;
}

// Tests which of sixteen boxes meet a stretched ball; returns one bit per box.
struct BoxesInStretchedBall : BoxesNear {
  StretchedBall needed;
  float low[3], high[3];

  BoxesInStretchedBall(const Vec3& point, const StretchedBall& ball)
      : BoxesNear(point, ball.radius_m), needed(ball) {
    const double margin_m = float_point_margin_m(point);
    for (int k = 0; k < 3; ++k) {
      low[k] = round_down(point[k] - ball.by_axis_m[k] - margin_m);
      high[k] = round_up(point[k] + ball.by_axis_m[k] + margin_m);
    }
  }
  std::uint32_t operator()(const BoxPack& boxes) const {
    std::uint32_t lanes = BoxesNear::operator()(boxes);
    for (std::uint32_t left = lanes; left != 0;) {
      const int lane = take_lane(left);
      for (int k = 0; k < 3; ++k) {
        if (boxes.low[k][lane] <= high[k] && boxes.high[k][lane] >= low[k]) continue;
        lanes &= ~(1u << lane);
        break;
      }
    }
    return lanes;
  }
};

// Visits the packs whose boxes pass the test, in ascending order from pack `first` on.
template <typename Test, typename Visit>
void visit_clusters(const OrderedBoxes& ordered, std::span<const BoxPack> clusters,
                    std::uint32_t first, const Test& test, const Visit& visit) {
  const std::uint32_t first_cluster = first / TrianglePack::kLanes;
  auto cluster = ordered.next(first_cluster, test);
  while (cluster) {
    std::uint32_t lanes = test(clusters[*cluster]);
    if (*cluster == first_cluster) {
      lanes = lanes >> (first % TrianglePack::kLanes) << (first % TrianglePack::kLanes);
    }
    const ClusterPacks packs(*cluster, lanes);
    if (packs.count > 0 && !visit(packs.span())) return;
    cluster = ordered.next(*cluster + 1, test);
  }
}

void visit_cluster(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto* search = reinterpret_cast<const PackSearch*>(args->context);
  const SegmentQuery& segment = search->segment;
  const ClusterPacks packs(
      args->primID, boxes_on_segment(search->index->cluster_boxes(args->primID), segment.origin,
                                     segment.displacement, search->radius));
  if (packs.count == 0) return;
  const QueryFraction needed = search->visitor(search->state, packs.span());
  if (needed == kNothingMore) return SegmentQuery::end(args);
  segment.end_at(needed, args);
}

}  // namespace

SurfaceIndex::SurfaceIndex(const MappedFaces& faces, double sweep_radius_m)
    : surface_(pack_surface(faces)),
      box_{Vec3::Zero(), Vec3::Zero()},
      sweep_radius_m_(sweep_radius_m) {
  if (!surface_.boxes.empty()) box_ = surface_.boxes[0];
  for (const Box& box : surface_.boxes) {
    box_.low = box_.low.cwiseMin(box.low);
    box_.high = box_.high.cwiseMax(box.high);
    mean_pack_diagonal_m_ += (box.high - box.low).norm();
  }
  if (pack_count() > 0) mean_pack_diagonal_m_ /= static_cast<double>(pack_count());
  for (const TrianglePack& pack : surface_.packs) {
    largest_pack_reach_m_ = std::max(largest_pack_reach_m_, 1.0 / pack.per_metre);
  }
  const double reach = std::max(box_.low.cwiseAbs().maxCoeff(), box_.high.cwiseAbs().maxCoeff());
  float_margin_m_ =
      kFloatMarginUlps * std::numeric_limits<float>::epsilon() * (reach + sweep_radius_m_);
  clusters_ = std::make_unique<EmbreeBoxes>(build_clusters(), visit_cluster);
  surface_.boxes = {};
  pack_kernels();  // selects the kernels now, not in the first query
}

// Returns the boxes of the clusters, with all margins.
std::vector<Box> SurfaceIndex::build_clusters() {
  std::vector<Box> cluster_bounds;
  const float infinity = std::numeric_limits<float>::infinity();
  const std::size_t count = (pack_count() + TrianglePack::kLanes - 1) / TrianglePack::kLanes;
  cluster_boxes_.reserve(count);
  cluster_bounds.reserve(count);
  for (std::size_t id = 0; id < pack_count(); ++id) {
    const std::size_t lane = id % TrianglePack::kLanes;
    if (lane == 0) {
      cluster_bounds.push_back(surface_.boxes[id]);
      BoxPack& empty = cluster_boxes_.emplace_back();
      for (int k = 0; k < 3; ++k) {
        std::fill(std::begin(empty.low[k]), std::end(empty.low[k]), infinity);
        std::fill(std::begin(empty.high[k]), std::end(empty.high[k]), -infinity);
      }
    }
    Box& bounds = cluster_bounds.back();
    bounds.low = bounds.low.cwiseMin(surface_.boxes[id].low);
    bounds.high = bounds.high.cwiseMax(surface_.boxes[id].high);
    const Box grown = surface_.boxes[id].grown(float_margin_m_);
    for (int k = 0; k < 3; ++k) {
      cluster_boxes_.back().low[k][lane] = round_down(grown.low[k]);
      cluster_boxes_.back().high[k][lane] = round_up(grown.high[k]);
    }
  }
  ordered_clusters_ = OrderedBoxes(cluster_boxes_);
  // Twice the margin of the packs, so that Embree's tree finds each pack whose own box passes.
  for (Box& bounds : cluster_bounds) bounds = bounds.grown(2 * float_margin_m_ + sweep_radius_m_);
  return cluster_bounds;
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

MemoryNeed SurfaceIndex::memory_need(std::uint64_t triangles) {
  constexpr std::uint64_t kLanes = TrianglePack::kLanes;
  constexpr std::uint64_t kSlot = sizeof(TriangleGeometry) + sizeof(std::uint32_t);
  // Allowance for the rounding of block sizes and for small blocks.
  constexpr std::uint64_t kBlocks = 512;
  const std::uint64_t packs = (triangles + kLanes - 1) / kLanes;
  const std::uint64_t clusters = (packs + kLanes - 1) / kLanes;
  const MemoryNeed tree = EmbreeBoxes::memory_need(clusters);
  const std::uint64_t packed = packs * (sizeof(TrianglePack) + kLanes * kSlot);
  const std::uint64_t cluster_boxes =
      clusters * sizeof(BoxPack) + OrderedBoxes::memory_need(clusters);
  const std::uint64_t pack_boxes = packs * sizeof(Box);
  const std::uint64_t kept = sizeof(SurfaceIndex) + kBlocks + packed + cluster_boxes + tree.kept;
  const std::uint64_t while_ordered = packed + pack_boxes + kOrderBytesPerFace * triangles;
  const std::uint64_t while_clustered =
      kept + pack_boxes + clusters * sizeof(Box) + tree.peak - tree.kept;
  return {kept, std::max(while_ordered, while_clustered)};
}

MemoryBreakdown SurfaceIndex::memory() const {
  MemoryBreakdown memory;
  memory.index_triangles =
      surface_.triangles.size() * (sizeof(TriangleGeometry) + sizeof(std::uint32_t));
  memory.index_packs = pack_count() * sizeof(TrianglePack);
  memory.index_boxes = sizeof(*this) + cluster_boxes_.capacity() * sizeof(BoxPack) +
                       ordered_clusters_.memory_bytes() + clusters_->memory_bytes();
  return memory;
}

std::optional<SurfacePoint> SurfaceIndex::closest_point(const Vec3& p,
                                                        double radius_m) const noexcept {
  std::optional<SurfacePoint> nearest;
  if (surface_.packs.empty() || box_.squared_distance(p) > radius_m * radius_m) return nearest;
  double best = radius_m;
  const double margin = float_point_margin_m(p);
  const float p_float[3] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z())};
  float needed = round_up(best + margin);
  const auto visit_pack = [&](std::uint32_t id) {
    LaneDistances distances;
    std::uint32_t lanes = lanes_within(pack(id), p, best, distances);
    // The lane with the smallest distance estimate is first: it usually rules out all other lanes.
    while (lanes != 0) {
      const int lane = least_lane(lanes, distances.squared);
      lanes &= ~(1u << lane);
      if (!distances.may_be_within(lane, local_length(pack(id), best))) break;
      const TrianglePoint point = closest_point_on_triangle(triangle(slot(id, lane)), p);
      if (point.distance > best || (nearest && point.distance == best)) continue;
      best = point.distance;
      nearest = SurfacePoint{point.point, point.distance, face(slot(id, lane))};
    }
    needed = round_up(best + margin);
  };
  clusters_->query_point(p_float, needed, [&](std::uint32_t cluster) {
    BoxDistances distances;
    std::uint32_t lanes = boxes_within(cluster_boxes_[cluster], p_float, needed, distances);
    while (lanes != 0) {
      const int lane = least_lane(lanes, distances.squared);
      lanes &= ~(1u << lane);
      if (distances.squared[lane] > needed * needed * (1 + 0x1p-20f)) break;
      visit_pack(slot(cluster, lane));
    }
    return needed;
  });
  return nearest;
}

template <typename Test>
std::size_t SurfaceIndex::packs_that_pass(const Test& test, std::span<std::uint32_t> packs,
                                          NearSearch search) const noexcept {
  std::size_t count = 0;
  // Returns false if the capacity is exceeded.
  const auto add = [&](std::span<const std::uint32_t> some) {
    count += some.size();
    if (count > packs.size()) return false;
    insert_in_order(some, packs.first(count));
    return true;
  };
  if (search == NearSearch::kInOrder) {
    visit_clusters(ordered_clusters_, cluster_boxes_, 0, test, add);
    return count;
  }
  clusters_->query_point(test.p, test.radius, [&](std::uint32_t cluster) {
    if (count > packs.size()) return 0.0f;  // Embree still visits boxes at distance zero
    const ClusterPacks found(cluster, test(cluster_boxes_[cluster]));
    return found.count == 0 || add(found.span()) ? test.radius : 0.0f;
  });
  return count;
}

std::size_t SurfaceIndex::packs_near(const Vec3& p, double radius_m, std::span<std::uint32_t> packs,
                                     NearSearch search) const noexcept {
  if (surface_.packs.empty() || box_.squared_distance(p) > radius_m * radius_m) return 0;
  return packs_that_pass(BoxesNear(p, radius_m), packs, search);
}

std::size_t SurfaceIndex::packs_near(const Vec3& p, const StretchedBall& ball,
                                     std::span<std::uint32_t> packs,
                                     NearSearch search) const noexcept {
  if (surface_.packs.empty() || !may_hold_some(box_, p, ball)) return 0;
  return packs_that_pass(BoxesInStretchedBall(p, ball), packs, search);
}

void SurfaceIndex::visit_nearest_packs(const Vec3& p, const StretchedBall& ball,
                                       NearestPackVisitor visitor, void* state) const noexcept {
  if (surface_.packs.empty() || !may_hold_some(box_, p, ball)) return;
  BoxesInStretchedBall test(p, ball);
  clusters_->query_point(test.p, test.radius, [&](std::uint32_t cluster) {
    const BoxPack& boxes = cluster_boxes_[cluster];
    for (std::uint32_t lanes = test(boxes); lanes != 0;) {
      const int lane = take_lane(lanes);
      const StretchedBall needed = visitor(state, slot(cluster, lane));
      if (needed.radius_m >= test.needed.radius_m) continue;
      test = BoxesInStretchedBall(p, needed);
      lanes &= test(boxes);
    }
    return test.radius;
  });
}

void SurfaceIndex::visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                                 void* state) const noexcept {
  assert(radius_m <= sweep_radius_m_);
  if (surface_.packs.empty()) return;
  PackSearch search{};
  if (!search.segment.begin(box_.grown(grown_by_m(radius_m)), p, d)) return;
  search.index = this;
  search.visitor = visitor;
  search.state = state;
  search.radius = round_up(radius_m);
  clusters_->query_segment(search.segment);
}

bool SurfaceIndex::may_meet(const Vec3& p, const Vec3& d, double radius_m) const noexcept {
  double enter = 0.0;
  double leave = 1.0;
  return !surface_.packs.empty() && box_.grown(grown_by_m(radius_m)).clip(p, d, enter, leave);
}

QueryWork SurfaceIndex::visit_packs_along(const Vec3& p, const Vec3& d, double radius_m,
                                          std::optional<std::uint32_t> first,
                                          OrderedPackVisitor visitor, void* state) const noexcept {
  QueryWork work;
  QueryFraction needed = QueryFraction::end();
  if (!first) {
    const auto are_visited = [&](double part) {
      FoundPacks found(*this, p, part * d, radius_m);
      if (found.are_too_many()) {
        work.listed += kMostPacksAtOnce;
        return false;
      }
      work.sorted += found.count();
      needed = found.visit(part, visitor, state);
      return true;
    };
    if (are_visited(1.0)) return work;
    // If the shortest part has too many packs, every part has.
    work.listed += kMostPacksAtOnce;
    int shortenings =
        FoundPacks(*this, p, kShortestPart * d, radius_m).are_too_many() ? 0 : kMostShortenings;
    for (double part = kShorterEachTime; shortenings > 0; --shortenings, part *= kShorterEachTime) {
      if (!are_visited(part)) continue;
      if (needed <= QueryFraction(part)) return work;
      break;
    }
  }
  const Box bounds = box_.grown(grown_by_m(radius_m));
  BoxesAlong along{{}, round_up(radius_m)};
  if (!along.segment.begin(bounds, p, d)) return work;
  const auto visit = [&](std::span<const std::uint32_t> packs) {
    const QueryFraction now_needed = visitor(state, packs, true);
    if (now_needed == kNothingMore) return false;
    if (now_needed < needed) {
      needed = now_needed;
      SegmentQuery shorter;
      if (shorter.begin(bounds, p, needed.value() * d)) along.segment = shorter;
    }
    return true;
  };
  visit_clusters(ordered_clusters_, cluster_boxes_, first.value_or(0),
                 CountedTest<BoxesAlong>{along, work.boxes}, visit);
  return work;
}

QueryWork SurfaceIndex::visit_packs_near(const Vec3& p, double radius_m, std::uint32_t first,
                                         NearPackVisitor visitor, void* state) const noexcept {
  QueryWork work;
  if (surface_.packs.empty() || box_.squared_distance(p) > radius_m * radius_m) return work;
  const auto visit = [&](std::span<const std::uint32_t> packs) { return visitor(state, packs); };
  const BoxesNear near(p, radius_m);
  visit_clusters(ordered_clusters_, cluster_boxes_, first, CountedTest<BoxesNear>{near, work.boxes},
                 visit);
  return work;
}

// A search for the nearest packs in the tree of OrderedBoxes, depth first. In each group of sixteen
// boxes, the nearest box is entered first.
struct SurfaceIndex::InOrder {
  const SurfaceIndex& index;
  Vec3 p;
  const Vec3* axes_per_radius;
  NearestVisitor visitor;
  void* state;
  double margin_m;
  float p_float[3];
  double radius = 0.0;
  float needed = 0.0f;

  void limit(double to) {
    radius = to;
    needed = round_up(to + margin_m);
  }
  bool is_over() const { return radius < 0.0; }

  // Whether a box meets the box around p.
  bool meets(const BoxPack& boxes, int lane) const {
    if (axes_per_radius == nullptr) return true;
    for (int k = 0; k < 3; ++k) {
      const double half = radius * (*axes_per_radius)[k] + margin_m;
      if (boxes.low[k][lane] > p[k] + half || boxes.high[k][lane] < p[k] - half) return false;
    }
    return true;
  }

  // level: 0 for the boxes of the packs of a cluster, and 1 more for each level of groups above.
  void visit(std::size_t level, std::uint32_t group) {
    limit(visitor(state, std::nullopt));
    if (is_over()) return;
    const BoxPack& boxes =
        level == 0 ? index.cluster_boxes_[group] : index.ordered_clusters_.boxes(level - 1, group);
    BoxDistances distances;
    std::uint32_t lanes = boxes_within(boxes, p_float, needed, distances);
    while (lanes != 0) {
      const int lane = least_lane(lanes, distances.squared);
      lanes &= ~(1u << lane);
      if (distances.squared[lane] > needed * needed * (1 + 0x1p-20f)) return;
      if (!meets(boxes, lane)) continue;
      const std::uint32_t inner = slot(group, lane);
      if (level == 0) {
        limit(visitor(state, inner));
      } else {
        visit(level - 1, inner);
      }
      if (is_over()) return;
    }
  }
};

void SurfaceIndex::visit_nearest_in_order(const Vec3& p, double radius, const Vec3* axes_per_radius,
                                          NearestVisitor visitor, void* state) const noexcept {
  if (surface_.packs.empty() || box_.squared_distance(p) > radius * radius) return;
  InOrder search{*this,
                 p,
                 axes_per_radius,
                 visitor,
                 state,
                 float_point_margin_m(p),
                 {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}};
  search.limit(radius);
  search.visit(ordered_clusters_.level_count(), 0);
}

std::optional<SegmentHit> SurfaceIndex::first_hit(const Vec3& p, const Vec3& d) const noexcept {
  struct State {
    const SurfaceIndex* index;
    Vec3 p, q, d;
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t face = 0;

    void consider(std::uint32_t slot) {
      const SegmentCrossing crossing = cross_segment(index->triangle(slot), p, q);
      if (crossing.kind == SegmentCrossing::Kind::kMiss || crossing.fraction >= best) return;
      best = crossing.fraction;
      face = index->face(slot);
    }
  } state{this, p, p + d, d};
  visit_segment(
      p, d, 0.0,
      [](void* s, std::span<const std::uint32_t> packs) {
        auto& first = *static_cast<State*>(s);
        std::array<PackLanes, TrianglePack::kLanes> doubtful;
        const std::size_t count =
            lanes_in_the_way(first.index->packs(), packs, first.p, first.d, 0.0, doubtful.data());
        for (std::size_t i = 0; i < count; ++i) {
          for (std::uint32_t lanes = doubtful[i].lanes; lanes != 0;) {
            first.consider(slot(doubtful[i].pack, take_lane(lanes)));
          }
        }
        return QueryFraction(first.best);
      },
      &state);
  if (!(state.best <= 1.0)) return std::nullopt;
  return SegmentHit{state.best, p + state.best * d, state.face};
}

}  // namespace palpate
