#include "geometry/surface_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "geometry/embree.h"
#include "geometry/pack_builder.h"
#include "geometry/pack_queries.h"
#include "geometry/segment_triangle.h"

namespace palpate {
namespace {

// At least to the next float; without a call, since queries do it.
float round_up(double x) {
  constexpr float kUlp = std::numeric_limits<float>::epsilon();
  const auto rounded = static_cast<float>(x);
  return rounded + (std::abs(rounded) * kUlp + std::numeric_limits<float>::min());
}
float round_down(double x) {
  return -round_up(-x);
}

// One Embree device for the process: creating one costs milliseconds and starts threads.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  return device;
}

// Boxes for Embree, already grown by all margins.
void write_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& boxes = *static_cast<const std::vector<Box>*>(args->geometryUserPtr);
  const Box& box = boxes[args->primID];
  RTCBounds& out = *args->bounds_o;
  out.lower_x = round_down(box.low.x());
  out.lower_y = round_down(box.low.y());
  out.lower_z = round_down(box.low.z());
  out.upper_x = round_up(box.high.x());
  out.upper_y = round_up(box.high.y());
  out.upper_z = round_up(box.high.z());
}

// A ray query in flight. The Embree context is the first member, so that the callback can find the
// rest from the pointer it is given.
struct SegmentQuery {
  embree::RayContext context;
  const SurfaceIndex* index;
  PackVisitor visitor;
  void* state;
  // The ray begins at the segment's fraction `enter`, and its direction has length 1 (largest
  // component), which the caller's segment has not.
  double enter;
  double length_m;
  float origin[3], displacement[3];  // the segment from `enter` on
  float radius;
};

// The packs of a set of lanes of one cluster.
struct ClusterPacks {
  std::array<std::uint32_t, TrianglePack::kLanes> ids;
  std::size_t count = 0;
  ClusterPacks(std::uint32_t cluster, std::uint32_t lanes) {
    while (lanes != 0) ids[count++] = SurfaceIndex::slot(cluster, take_lane(lanes));
  }
  std::span<const std::uint32_t> span() const { return std::span(ids).first(count); }
};

void visit_cluster(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto* query = reinterpret_cast<const SegmentQuery*>(args->context);
  const ClusterPacks packs(
      args->primID, boxes_on_segment(query->index->cluster_boxes(args->primID), query->origin,
                                     query->displacement, query->radius));
  if (packs.count == 0) return;
  const double end = query->visitor(query->state, packs.span());
  if (end >= 1.0) return;
  // Embree compares boxes with tfar in float, so the new end is rounded up; nothing is reported as
  // a hit, because a report would let Embree skip clusters at equal distance.
  float& tfar = RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0);
  tfar = std::min(tfar, round_up((end - query->enter) * query->length_m));
}

}  // namespace

bool Box::clip(const Vec3& p, const Vec3& d, double& enter, double& leave) const {
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0.0) {
      if (p[k] < low[k] || p[k] > high[k]) return false;
      continue;
    }
    const double at_low = (low[k] - p[k]) / d[k];
    const double at_high = (high[k] - p[k]) / d[k];
    enter = std::max(enter, std::min(at_low, at_high));
    leave = std::min(leave, std::max(at_low, at_high));
  }
  return enter <= leave;
}

struct SurfaceIndex::EmbreeScene {
  RTCScene scene = nullptr;
  ~EmbreeScene() {
    if (scene) rtcReleaseScene(scene);
  }
};

SurfaceIndex::SurfaceIndex(const SurfaceMesh& mesh, const AffineMap& map, double sweep_radius_m)
    : surface_(pack_surface(mesh, map)),
      box_{Vec3::Zero(), Vec3::Zero()},
      sweep_radius_m_(sweep_radius_m),
      scene_(std::make_unique<EmbreeScene>()) {
  if (!surface_.boxes.empty()) box_ = surface_.boxes.front();
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
  std::vector<Box> cluster_bounds;
  build_clusters(cluster_bounds);
  build_embree_scene(cluster_bounds);
  surface_.boxes = {};
  pack_kernels();  // chosen here, not by the first query
}

void SurfaceIndex::build_clusters(std::vector<Box>& cluster_bounds) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t id = 0; id < pack_count(); ++id) {
    const std::size_t lane = id % TrianglePack::kLanes;
    if (lane == 0) {
      cluster_bounds.push_back(surface_.boxes[id]);
      BoxPack& none = cluster_boxes_.emplace_back();
      for (int k = 0; k < 3; ++k) {
        std::fill(std::begin(none.low[k]), std::end(none.low[k]), infinity);
        std::fill(std::begin(none.high[k]), std::end(none.high[k]), -infinity);
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
  for (Box& bounds : cluster_bounds) bounds = bounds.grown(float_margin_m_ + sweep_radius_m_);
}

void SurfaceIndex::build_embree_scene(const std::vector<Box>& cluster_bounds) {
  scene_->scene = rtcNewScene(shared_device());
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_->scene, RTC_BUILD_QUALITY_MEDIUM);
  const RTCGeometry geometry = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(cluster_bounds.size()));
  rtcSetGeometryUserData(geometry, const_cast<std::vector<Box>*>(&cluster_bounds));
  rtcSetGeometryMask(geometry, embree::kAllRays);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* args) { write_bounds(args); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry, visit_cluster);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcCommitScene(scene_->scene);
  rtcSetGeometryUserData(geometry, nullptr);
  rtcReleaseGeometry(geometry);
}

// What rounding a query point to float can cost, when it lies outside the box that the margins of
// the boxes are for.
double SurfaceIndex::point_margin_m(const Vec3& p) const {
  return 4 * std::numeric_limits<float>::epsilon() * p.cwiseAbs().maxCoeff();
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

std::size_t SurfaceIndex::memory_bytes() const {
  // Embree does not tell what one scene takes; 200 bytes a primitive is what its BVH4 builder
  // allocates for user geometry.
  constexpr std::size_t kEmbreeBytesPerCluster = 200;
  constexpr std::size_t kBytesPerSlot = sizeof(TriangleGeometry) + sizeof(std::uint32_t);
  return pack_count() * (sizeof(TrianglePack) + TrianglePack::kLanes * kBytesPerSlot) +
         cluster_boxes_.size() * (sizeof(BoxPack) + kEmbreeBytesPerCluster);
}

namespace {

// Runs a point query that calls `visit` for every cluster whose float box is within the radius.
// The visitor returns the radius it still needs, margins included.
template <typename Visit>
void point_query(RTCScene scene, const float (&p)[3], float radius, Visit visit) {
  RTCPointQuery query;
  query.x = p[0];
  query.y = p[1];
  query.z = p[2];
  query.time = 0.0f;
  query.radius = radius;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(
      scene, &query, &context,
      [](RTCPointQueryFunctionArguments* args) {
        const float needed = (*static_cast<Visit*>(args->userPtr))(args->primID);
        if (needed >= args->query->radius) return false;
        args->query->radius = needed;
        return true;
      },
      &visit);
}

}  // namespace

std::optional<SurfacePoint> SurfaceIndex::closest_point(const Vec3& p,
                                                        double radius_m) const noexcept {
  std::optional<SurfacePoint> nearest;
  if (surface_.packs.empty() || box_.squared_distance(p) > radius_m * radius_m) return nearest;
  double best = radius_m;
  const double margin = point_margin_m(p);
  const float p_float[3] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z())};
  float needed = round_up(best + margin);
  const auto visit_pack = [&](std::uint32_t id) {
    LaneDistances distances;
    std::uint32_t lanes = lanes_within(pack(id), p, best, distances);
    // The one that looks nearest goes first: as a rule it settles all the others.
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
  point_query(scene_->scene, p_float, needed, [&](std::uint32_t cluster) {
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

std::size_t SurfaceIndex::packs_near(const Vec3& p, double radius_m,
                                     std::span<std::uint32_t> packs) const noexcept {
  std::size_t count = 0;
  if (surface_.packs.empty() || box_.squared_distance(p) > radius_m * radius_m) return count;
  const float p_float[3] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z())};
  const float radius = round_up(radius_m + point_margin_m(p));
  point_query(scene_->scene, p_float, radius, [&](std::uint32_t cluster) {
    BoxDistances distances;
    const ClusterPacks found(cluster,
                             boxes_within(cluster_boxes_[cluster], p_float, radius, distances));
    for (const std::uint32_t id : found.span()) {
      if (count < packs.size()) packs[count] = id;
      ++count;
    }
    return count > packs.size() ? 0.0f : radius;  // full: nothing more is wanted
  });
  return count;
}

void SurfaceIndex::visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                                 void* state) const noexcept {
  assert(radius_m <= sweep_radius_m_);
  double enter = 0.0;
  double leave = 1.0;
  // Clipped in double first: Embree then works on coordinates no larger than the box.
  if (surface_.packs.empty()) return;
  if (!box_.grown(float_margin_m_ + radius_m).clip(p, d, enter, leave)) return;
  const double length = d.cwiseAbs().maxCoeff();
  if (length == 0.0) return;
  const Vec3 origin = p + enter * d;
  const Vec3 displacement = (leave - enter) * d;
  const Vec3 direction = d / length;
  SegmentQuery query{};
  embree::init(query.context);
  query.index = this;
  query.visitor = visitor;
  query.state = state;
  query.enter = enter;
  query.length_m = length;
  query.radius = round_up(radius_m);
  RTCRayHit ray{};
  ray.ray.org_x = query.origin[0] = static_cast<float>(origin.x());
  ray.ray.org_y = query.origin[1] = static_cast<float>(origin.y());
  ray.ray.org_z = query.origin[2] = static_cast<float>(origin.z());
  for (int k = 0; k < 3; ++k) query.displacement[k] = static_cast<float>(displacement[k]);
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tnear = 0.0f;
  ray.ray.tfar = round_up((leave - enter) * length);
  ray.ray.mask = embree::kAllRays;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(scene_->scene, ray, query.context);
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
        return first.best;
      },
      &state);
  if (!(state.best <= 1.0)) return std::nullopt;
  return SegmentHit{state.best, p + state.best * d, state.face};
}

}  // namespace palpate
