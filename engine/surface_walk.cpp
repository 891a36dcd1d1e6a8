#include "engine/surface_walk.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace palpate {
namespace {

struct SurfaceSample {
  Vec3 point_m;
  Vec3 normal;
};

class SurfaceSampler {
 public:
  SurfaceSampler(const Scene& scene, std::uint64_t seed) : random_(seed) {
    scene.append_triangles_scene(positions_, triangles_);
    double area = 0.0;
    for (const Triangle& t : triangles_) {
      area += cross(t).norm();
      cumulative_.push_back(area);
    }
  }

  SurfaceSample draw() {
    const double at = uniform() * cumulative_.back();
    const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), at);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(found - cumulative_.begin()),
                                         triangles_.size() - 1);
    const Triangle& t = triangles_[i];
    const double root = std::sqrt(uniform());
    const double v = uniform();
    return {(1 - root) * positions_[t[0]] + root * (1 - v) * positions_[t[1]] +
                root * v * positions_[t[2]],
            cross(t).normalized()};
  }

  // A point within reach of another; on a coarse sample of a vast surface the nearest drawn.
  Vec3 draw_near(const Vec3& point_m, double reach_m) {
    constexpr int kDraws = 10000;
    Vec3 nearest = draw().point_m;
    for (int i = 1; i < kDraws && (nearest - point_m).norm() > reach_m; ++i) {
      const Vec3 drawn = draw().point_m;
      if ((drawn - point_m).norm() < (nearest - point_m).norm()) nearest = drawn;
    }
    return nearest;
  }

 private:
  Vec3 cross(const Triangle& t) const {
    return (positions_[t[1]] - positions_[t[0]]).cross(positions_[t[2]] - positions_[t[0]]);
  }
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  std::mt19937_64 random_;
  std::vector<Vec3> positions_;
  std::vector<Triangle> triangles_;
  std::vector<double> cumulative_;
};

}  // namespace

SurfaceWalk::SurfaceWalk(const Scene& scene, const SurfaceWalkSettings& settings)
    : settings_(settings) {
  SurfaceSampler sampler(scene, settings.seed);
  const SurfaceSample first = sampler.draw();
  start_m_ = first.point_m + 2 * settings_.press_depth_m * first.normal;
  // More than the hand will reach: few legs are as short as an eighth of their time allows.
  const auto count = static_cast<std::size_t>(
      std::max(1.0, std::ceil(8 * settings_.duration_s / settings_.seconds_per_waypoint)));
  last_normal_ = first.normal;
  const double reach_m = 0.5 * settings_.speed_m_per_s * settings_.seconds_per_waypoint;
  waypoints_m_.push_back(first.point_m);
  while (waypoints_m_.size() <= count) {
    waypoints_m_.push_back(sampler.draw_near(waypoints_m_.back(), reach_m));
  }
  reached_.assign(waypoints_m_.size(), false);
  given_up_at_s_ = settings_.seconds_per_waypoint;
}

HandTarget SurfaceWalk::target(double time_s, const ScenePose& T_device_scene,
                               const TickRecord& last) noexcept {
  if (last.contact) {
    last_contact_s_ = time_s;
    if (!last.normal_scene.isZero(0.0)) last_normal_ = last.normal_scene;
    const Vec3 to_waypoint = waypoints_m_[next_] - last.proxy_m;
    if (to_waypoint.norm() <= 2 * settings_.press_depth_m) reached_[next_] = true;
  }
  if ((reached_[next_] || time_s >= given_up_at_s_) && next_ + 1 < waypoints_m_.size()) {
    ++next_;
    given_up_at_s_ = time_s + settings_.seconds_per_waypoint;
  }
  // Along the surface and a little into it; far from any surface straight to the waypoint.
  const bool is_lost = time_s - last_contact_s_ > settings_.search_s;
  const Vec3 normal = is_lost ? Vec3(Vec3::Zero()) : last_normal_;
  const Vec3 way = waypoints_m_[next_] - last.proxy_m;
  const Vec3 along = way - way.dot(normal) * normal;
  const double distance = along.norm();
  const Vec3 direction = distance > 0.0 ? Vec3(along / distance) : Vec3(Vec3::Zero());
  HandTarget target;
  target.position_m =
      T_device_scene.point(last.proxy_m + std::min(distance, settings_.press_depth_m) * direction -
                           settings_.press_depth_m * normal);
  target.velocity_m_per_s = T_device_scene.direction(settings_.speed_m_per_s * direction);
  return target;
}

}  // namespace palpate
