#include "engine/simulation/plane_height.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/rig/placed_bounds.h"

namespace palpate {
namespace {

// A face is perpendicular to A3 if its heights differ by less than this share of the largest
// extent, which is about sixteen times the rounding of coordinates in single precision.
constexpr double kRoundedPerExtent = 0x1p-20;

// In addition the cosine between its normal and A3 must exceed this, because a tiny face may stand
// upright.
constexpr double kLies = 0.5;

// The heights (low_m, high_m] at which a triangle, or a set of overlapping triangles, is cut.
struct Heights {
  double low_m, high_m;
};

// Calls visit(heights, lies) for each triangle; lies: the triangle is perpendicular to A3, within
// rounded_m.
template <typename Visit>
void visit_heights(const Scene& scene, const ScenePose& T_device_scene, double rounded_m,
                   const Visit& visit) {
  std::vector<Vec3> positions_m;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const SceneObject& object = scene.objects()[i];
    const AffineMap deformation = scene.deformation(i);
    const SurfaceMesh& mesh = scene.mesh(object.mesh);
    positions_m.clear();
    for (const Vec3& p : mesh.welded_positions()) {
      positions_m.push_back(T_device_scene.point(object.T_scene_body.point(deformation(p))));
    }
    for (const Triangle& t : mesh.faces()) {
      const Vec3& a = positions_m[t[0]];
      const Vec3& b = positions_m[t[1]];
      const Vec3& c = positions_m[t[2]];
      const auto [low_m, high_m] = std::minmax({a.z(), b.z(), c.z()});
      bool lies = low_m == high_m;
      if (!lies && high_m - low_m <= rounded_m) {
        const Vec3 front = (b - a).cross(c - a);
        lies = std::abs(front.z()) > kLies * front.norm();
      }
      visit(Heights{low_m, high_m}, lies);
    }
  }
}

// Unites overlapping intervals; the result is ascending.
std::vector<Heights> united(std::vector<Heights> heights) {
  std::sort(heights.begin(), heights.end(),
            [](const Heights& a, const Heights& b) { return a.low_m < b.low_m; });
  std::vector<Heights> whole;
  for (const Heights& h : heights) {
    if (whole.empty() || h.low_m > whole.back().high_m) {
      whole.push_back(h);
    } else {
      whole.back().high_m = std::max(whole.back().high_m, h.high_m);
    }
  }
  return whole;
}

// The heights without the levels at which faces lie. Both arguments are results of united().
std::vector<Heights> between(const std::vector<Heights>& heights,
                             const std::vector<Heights>& levels) {
  std::vector<Heights> rest;
  auto level = levels.begin();
  for (Heights h : heights) {
    while (level != levels.end() && level->high_m < h.low_m) ++level;
    for (; level != levels.end() && level->low_m < h.high_m; ++level) {
      rest.push_back({h.low_m, level->low_m});
      h.low_m = level->high_m;
      if (level->high_m > h.high_m) break;
    }
    rest.push_back(h);
  }
  return rest;
}

// The height nearest to height_m that is inside an interval by inside_m, or in its middle if the
// interval is narrower. Only intervals wider than least_m count.
std::optional<double> nearest_inside(const std::vector<Heights>& all, double height_m,
                                     double inside_m, double least_m) {
  std::optional<double> nearest_m;
  for (const Heights& h : all) {
    const double width_m = h.high_m - h.low_m;
    if (width_m <= least_m) continue;
    const double border_m = std::min(inside_m, 0.5 * width_m);
    const double here_m =
        std::clamp(height_m, h.low_m + border_m, std::max(h.low_m + border_m, h.high_m - border_m));
    if (!nearest_m || std::abs(here_m - height_m) < std::abs(*nearest_m - height_m)) {
      nearest_m = here_m;
    }
  }
  return nearest_m;
}

}  // namespace

std::optional<double> height_with_contour_m(const Scene& scene, const ScenePose& T_device_scene) {
  constexpr double kInsidePerExtent = 1.0 / 64;
  if (scene.objects().empty()) return std::nullopt;
  const Box bounds = bounds_in_device(scene, T_device_scene);
  const double middle_m = 0.5 * bounds.low.z() + 0.5 * bounds.high.z();
  const double rounded_m = kRoundedPerExtent * (bounds.high - bounds.low).maxCoeff();
  bool is_cut = false;
  bool has_face = false;
  visit_heights(scene, T_device_scene, rounded_m, [&](const Heights& h, bool lies) {
    is_cut = is_cut || (!lies && h.low_m < middle_m && middle_m <= h.high_m);
    has_face =
        has_face || (lies && h.low_m - rounded_m <= middle_m && middle_m <= h.high_m + rounded_m);
  });
  if (is_cut && !has_face) return middle_m;
  std::vector<Heights> heights;
  std::vector<Heights> levels;
  visit_heights(scene, T_device_scene, rounded_m,
                [&](const Heights& h, bool lies) { (lies ? levels : heights).push_back(h); });
  const auto cut = between(united(std::move(heights)), united(std::move(levels)));
  const double inside_m = kInsidePerExtent * (bounds.high.z() - bounds.low.z());
  if (const auto height_m = nearest_inside(cut, middle_m, inside_m, 2.0 * rounded_m)) {
    return height_m;
  }
  return nearest_inside(cut, middle_m, inside_m,
                        0.0);  // intervals within the rounding of the faces
}

}  // namespace palpate
