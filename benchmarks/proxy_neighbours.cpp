#include "benchmarks/proxy_neighbours.h"

#include <algorithm>

#include "geometry/exact/triangle.h"

namespace palpate::bench {
namespace {

constexpr std::size_t kPositions = 16;

struct Triangles {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> corners;
};

// The nearest point to p of each triangle that is within reach_m.
std::vector<TrianglePoint> points_within(const Triangles& all, const Vec3& p, double reach_m) {
  std::vector<TrianglePoint> points;
  for (const Triangle& t : all.corners) {
    const Vec3& a = all.positions_m[t[0]];
    const Vec3& b = all.positions_m[t[1]];
    const Vec3& c = all.positions_m[t[2]];
    const double longest_m = std::sqrt(std::max((b - a).squaredNorm(), (c - a).squaredNorm()));
    const double limit_m = reach_m + longest_m;
    if ((a - p).squaredNorm() > limit_m * limit_m) continue;
    const TriangleGeometry triangle{a, b, c, (b - a).cross(c - a).normalized()};
    const TrianglePoint point = closest_point_on_triangle(triangle, p);
    if (point.distance <= reach_m) points.push_back(point);
  }
  return points;
}

bool is_nearer(const TrianglePoint& a, const TrianglePoint& b) {
  return a.distance < b.distance;
}

}  // namespace

ProxyNeighbours mean_proxy_neighbours(const Scene& scene, const std::vector<Vec3>& proxies_scene_m,
                                      double proxy_radius_m, double step_m) {
  Triangles all;
  scene.append_triangles_scene(all.positions_m, all.corners);
  const std::size_t stride = 1 + proxies_scene_m.size() / kPositions;
  ProxyNeighbours sum;
  double count = 0.0;
  for (std::size_t n = 0; n < proxies_scene_m.size(); n += stride) {
    const auto in_reach = points_within(all, proxies_scene_m[n], proxy_radius_m + step_m);
    const auto touched = std::min_element(in_reach.begin(), in_reach.end(), is_nearer);
    if (touched == in_reach.end()) continue;
    sum.in_reach += static_cast<double>(in_reach.size());
    sum.under += static_cast<double>(points_within(all, touched->point, proxy_radius_m).size());
    count += 1.0;
  }
  return count > 0.0 ? ProxyNeighbours{sum.under / count, sum.in_reach / count} : sum;
}

}  // namespace palpate::bench
