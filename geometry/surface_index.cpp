#include "geometry/surface_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "geometry/embree.h"
#include "geometry/pack_builder.h"
#include "geometry/pack_queries.h"
#include "geometry/segment_triangle.h"

namespace palpate {
namespace {

float round_down(double x) {
  return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float round_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

// One Embree device for the process: creating one costs milliseconds and starts threads.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  return device;
}

// Everything the bounds callback needs; lives as long as the build.
struct BoxSource {
  const std::vector<Box>* boxes;
  double margin_m;
};

void write_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& source = *static_cast<const BoxSource*>(args->geometryUserPtr);
  const Box& box = (*source.boxes)[args->primID];
  RTCBounds& out = *args->bounds_o;
  out.lower_x = round_down(box.low.x() - source.margin_m);
  out.lower_y = round_down(box.low.y() - source.margin_m);
  out.lower_z = round_down(box.low.z() - source.margin_m);
  out.upper_x = round_up(box.high.x() + source.margin_m);
  out.upper_y = round_up(box.high.y() + source.margin_m);
  out.upper_z = round_up(box.high.z() + source.margin_m);
}

// A ray query in flight. The Embree context is the first member, so that the callback can find the
// rest from the pointer it is given.
struct SegmentQuery {
  embree::RayContext context;
  PackVisitor visitor;
  void* state;
  // The ray begins at the segment's fraction `enter`, and its direction has length 1 (largest
  // component), which the caller's segment has not.
  double enter;
  double length_m;
};

void visit_pack(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto* query = reinterpret_cast<const SegmentQuery*>(args->context);
  const double end = query->visitor(query->state, args->primID);
  if (end >= 1.0) return;
  // Embree compares boxes with tfar in float, so the new end is rounded up; nothing is reported as
  // a hit, because a report would let Embree skip packs at equal distance.
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
    : packs_(build_packs(mesh, map)),
      sweep_radius_m_(sweep_radius_m),
      scene_(std::make_unique<EmbreeScene>()) {
  pack_boxes_.reserve(packs_.size());
  box_ = packs_.empty() ? Box{Vec3::Zero(), Vec3::Zero()} : bounding_box(packs_.front());
  for (const TrianglePack& pack : packs_) {
    pack_boxes_.push_back(bounding_box(pack));
    box_.low = box_.low.cwiseMin(pack_boxes_.back().low);
    box_.high = box_.high.cwiseMax(pack_boxes_.back().high);
    mean_pack_diagonal_m_ += (pack_boxes_.back().high - pack_boxes_.back().low).norm();
  }
  if (!packs_.empty()) mean_pack_diagonal_m_ /= static_cast<double>(packs_.size());
  const double reach = std::max(box_.low.cwiseAbs().maxCoeff(), box_.high.cwiseAbs().maxCoeff());
  float_margin_m_ =
      kFloatMarginUlps * std::numeric_limits<float>::epsilon() * (reach + sweep_radius_m_);

  BoxSource source{&pack_boxes_, float_margin_m_ + sweep_radius_m_};
  scene_->scene = rtcNewScene(shared_device());
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_->scene, RTC_BUILD_QUALITY_MEDIUM);
  const RTCGeometry geometry = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(packs_.size()));
  rtcSetGeometryUserData(geometry, &source);
  rtcSetGeometryMask(geometry, embree::kAllRays);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* args) { write_bounds(args); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry, visit_pack);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcCommitScene(scene_->scene);
  rtcSetGeometryUserData(geometry, nullptr);
  rtcReleaseGeometry(geometry);
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

std::size_t SurfaceIndex::memory_bytes() const {
  // Embree does not tell what one scene takes; 200 bytes a primitive is what its BVH4 builder
  // allocates for user geometry.
  constexpr std::size_t kEmbreeBytesPerPack = 200;
  return packs_.size() * (sizeof(TrianglePack) + sizeof(Box) + kEmbreeBytesPerPack);
}

namespace {

// Runs a point query that calls `visit` for every pack whose float box is within the radius.
// The visitor returns the radius it still needs.
template <typename Visit>
void point_query(RTCScene scene, const Vec3& p, double radius, double margin, Visit visit) {
  struct State {
    Visit* visit;
    double margin;
  } state{&visit, margin};
  RTCPointQuery query;
  query.x = static_cast<float>(p.x());
  query.y = static_cast<float>(p.y());
  query.z = static_cast<float>(p.z());
  query.time = 0.0f;
  query.radius = round_up(radius + margin);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(
      scene, &query, &context,
      [](RTCPointQueryFunctionArguments* args) {
        auto& s = *static_cast<State*>(args->userPtr);
        const float needed = round_up((*s.visit)(args->primID) + s.margin);
        if (needed >= args->query->radius) return false;
        args->query->radius = std::max(0.0f, needed);
        return true;
      },
      &state);
}

}  // namespace

std::optional<SurfacePoint> SurfaceIndex::closest_point(const Vec3& p,
                                                        double radius_m) const noexcept {
  std::optional<SurfacePoint> nearest;
  if (packs_.empty() || box_.squared_distance(p) > radius_m * radius_m) return nearest;
  double best = radius_m;
  point_query(scene_->scene, p, radius_m, float_margin_m_, [&](std::uint32_t id) {
    if (pack_boxes_[id].squared_distance(p) > best * best) return best;
    const TrianglePack& pack = packs_[id];
    const unsigned lanes = lanes_within(pack, p, best);
    for (int lane = 0; lane < pack.count; ++lane) {
      if (!(lanes >> lane & 1u)) continue;
      const TrianglePoint point = closest_point_on_triangle(pack.triangle(lane), p);
      if (point.distance > best || (nearest && point.distance == best)) continue;
      best = point.distance;
      nearest = SurfacePoint{point.point, point.distance, pack.face[lane]};
    }
    return best;
  });
  return nearest;
}

std::size_t SurfaceIndex::packs_near(const Vec3& p, double radius_m,
                                     std::span<std::uint32_t> packs) const noexcept {
  std::size_t count = 0;
  if (packs_.empty() || box_.squared_distance(p) > radius_m * radius_m) return count;
  const double squared_radius = radius_m * radius_m;
  point_query(scene_->scene, p, radius_m, float_margin_m_, [&](std::uint32_t id) {
    if (count > packs.size()) return -float_margin_m_;  // full: nothing more is wanted
    if (pack_boxes_[id].squared_distance(p) > squared_radius) return radius_m;
    if (count < packs.size()) packs[count] = id;
    ++count;
    return radius_m;
  });
  return count;
}

void SurfaceIndex::visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                                 void* state) const noexcept {
  assert(radius_m <= sweep_radius_m_);
  double enter = 0.0;
  double leave = 1.0;
  // Clipped in double first: Embree then works on coordinates no larger than the box.
  if (packs_.empty()) return;
  if (!box_.grown(float_margin_m_ + radius_m).clip(p, d, enter, leave)) return;
  const double length = d.cwiseAbs().maxCoeff();
  if (length == 0.0) return;
  SegmentQuery query{{}, visitor, state, enter, length};
  embree::init(query.context);

  const Vec3 origin = p + enter * d;
  const Vec3 direction = d / length;
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
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
    Vec3 p, d;
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t face = 0;
  } state{this, p, d};
  visit_segment(
      p, d, 0.0,
      [](void* s, std::uint32_t id) {
        auto& first = *static_cast<State*>(s);
        const TrianglePack& pack = first.index->pack(id);
        const unsigned lanes = lanes_in_the_way(pack, first.p, first.d, 0.0);
        for (int lane = 0; lane < pack.count; ++lane) {
          if (!(lanes >> lane & 1u)) continue;
          const SegmentCrossing crossing = cross_segment(pack.triangle(lane), first.p, first.d);
          if (crossing.kind == SegmentCrossing::Kind::kMiss) continue;
          if (crossing.fraction >= first.best) continue;
          first.best = crossing.fraction;
          first.face = pack.face[lane];
        }
        return first.best;
      },
      &state);
  if (!(state.best <= 1.0)) return std::nullopt;
  return SegmentHit{state.best, p + state.best * d, state.face};
}

}  // namespace palpate
