#include "benchmarks/stock_embree.h"

#include <algorithm>
#include <vector>

#include "geometry/index/embree.h"

namespace palpate::bench {
namespace {

using Vec3f = Eigen::Vector3f;

// Closest point of a triangle by the Voronoi regions of its vertices and edges (C. Ericson,
// Real-Time Collision Detection, 2005, section 5.1.5).
Vec3f closest_on_triangle(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a;
  const Vec3f ac = c - a;
  const Vec3f ap = p - a;
  const float d1 = ab.dot(ap);
  const float d2 = ac.dot(ap);
  if (d1 <= 0.0f && d2 <= 0.0f) return a;
  const Vec3f bp = p - b;
  const float d3 = ab.dot(bp);
  const float d4 = ac.dot(bp);
  if (d3 >= 0.0f && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a + d1 / (d1 - d3) * ab;
  const Vec3f cp = p - c;
  const float d5 = ab.dot(cp);
  const float d6 = ac.dot(cp);
  if (d6 >= 0.0f && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a + d2 / (d2 - d6) * ac;
  const float va = d3 * d6 - d5 * d4;
  const float e = d4 - d3;
  const float f = d5 - d6;
  if (va <= 0.0f && e >= 0.0f && f >= 0.0f) return b + e / (e + f) * (c - b);
  const float scale = 1.0f / (va + vb + vc);
  return a + vb * scale * ab + vc * scale * ac;
}

struct Nearest {
  const Vec3f* positions;
  const Triangle* triangles;
  Vec3f p;
  StockPoint best{};
  bool found = false;
};

bool visit_triangle(RTCPointQueryFunctionArguments* args) {
  auto& nearest = *static_cast<Nearest*>(args->userPtr);
  const Triangle& t = nearest.triangles[args->primID];
  const Vec3f point = closest_on_triangle(nearest.p, nearest.positions[t[0]],
                                          nearest.positions[t[1]], nearest.positions[t[2]]);
  const float distance = (nearest.p - point).norm();
  if (distance >= args->query->radius) return false;
  args->query->radius = distance;
  nearest.best = {point, distance, args->primID};
  nearest.found = true;
  return true;
}

RTCDevice stock_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  return device;
}

}  // namespace

struct StockSurface::Buffers {
  std::vector<Vec3f> positions;  // one extra element: Embree reads 16 bytes at a time
  std::vector<Triangle> triangles;
  RTCScene scene = nullptr;
  ~Buffers() {
    if (scene) rtcReleaseScene(scene);
  }
};

StockSurface::StockSurface(const TriangleMesh& mesh) : buffers_(std::make_unique<Buffers>()) {
  buffers_->positions.reserve(mesh.positions_m.size() + 1);
  for (const Vec3& p : mesh.positions_m) buffers_->positions.push_back(p.cast<float>());
  buffers_->positions.emplace_back(Vec3f::Zero());
  buffers_->triangles = mesh.triangles;
  buffers_->scene = rtcNewScene(stock_device());
  rtcSetSceneFlags(buffers_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(buffers_->scene, RTC_BUILD_QUALITY_MEDIUM);
  const RTCGeometry geometry = rtcNewGeometry(stock_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             buffers_->positions.data(), 0, sizeof(Vec3f), mesh.positions_m.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             buffers_->triangles.data(), 0, sizeof(Triangle),
                             buffers_->triangles.size());
  rtcSetGeometryMask(geometry, embree::kAllRays);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(buffers_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(buffers_->scene);
}

StockSurface::~StockSurface() = default;
StockSurface::StockSurface(StockSurface&&) noexcept = default;
StockSurface& StockSurface::operator=(StockSurface&&) noexcept = default;

std::optional<StockPoint> StockSurface::closest_point(const Eigen::Vector3f& p,
                                                      float radius_m) const noexcept {
  Nearest nearest{buffers_->positions.data(), buffers_->triangles.data(), p};
  RTCPointQuery query;
  query.x = p.x();
  query.y = p.y();
  query.z = p.z();
  query.time = 0.0f;
  query.radius = radius_m;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(buffers_->scene, &query, &context, visit_triangle, &nearest);
  if (!nearest.found) return std::nullopt;
  return nearest.best;
}

std::optional<float> StockSurface::first_hit(const Eigen::Vector3f& p,
                                             const Eigen::Vector3f& d) const noexcept {
  embree::RayContext context;
  embree::init(context);
  RTCRayHit ray{};
  ray.ray.org_x = p.x();
  ray.ray.org_y = p.y();
  ray.ray.org_z = p.z();
  ray.ray.dir_x = d.x();
  ray.ray.dir_y = d.y();
  ray.ray.dir_z = d.z();
  ray.ray.tnear = 0.0f;
  ray.ray.tfar = 1.0f;
  ray.ray.mask = embree::kAllRays;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(buffers_->scene, ray, context);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return ray.ray.tfar;
}

}  // namespace palpate::bench
