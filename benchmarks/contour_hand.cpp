#include "benchmarks/contour_hand.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>

#include "engine/devices/path_device.h"
#include "engine/rig/rig.h"
#include "engine/simulation/plane_height.h"
#include "engine/trials/experiment_scene.h"

namespace palpate::bench {
namespace {

double cross(const Point2& a, const Point2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

ContourHand::ContourHand(const Contour& contour_m) {
  const std::size_t n = contour_m.size();
  for (std::size_t i = 0; i <= n; ++i) {
    const Point2& corner_m = contour_m[i % n];
    const Point2 wall_m = contour_m[(i + 1) % n] - corner_m;
    const Point2 along = wall_m.normalized();
    const bool is_half = i % n == 0;
    const Point2 from_m = i == 0 ? Point2(corner_m + 0.5 * wall_m) : corner_m;
    const bool is_convex = i > 0 && cross(legs_.back().along, along) > 0.0;
    legs_.push_back({from_m, along, {along.y(), -along.x()}, length_m_, is_convex});
    length_m_ += (is_half ? 0.5 : 1.0) * wall_m.norm();
  }
}

Point2 ContourHand::start_m() const {
  return legs_.front().from_m + kDepth_m * legs_.front().outward;
}

Point2 ContourHand::goal_m(double share) const {
  const double way_m = share * length_m_;
  const auto next =
      std::upper_bound(legs_.begin(), legs_.end(), way_m,
                       [](double place_m, const Leg& leg) { return place_m < leg.begin_m; });
  const Leg& leg = *std::prev(next);
  const double on_leg_m = way_m - leg.begin_m;
  const bool is_released = leg.is_after_convex_corner && on_leg_m < kReleased_m;
  return leg.from_m + on_leg_m * leg.along + (is_released ? kDepth_m : -kDepth_m) * leg.outward;
}

Result<ContourAngle> angle_round(const Scene& scene, const Contour& contour_m,
                                 const ContourRound& round) {
  RunSettings settings;
  settings.sensors = 2;
  settings.actuators = 1;
  settings.haptics.a4.enabled = true;
  settings.haptics.a4.align = round.align;
  const auto made = make_setup(settings);
  if (!made) return made.error();
  RunSetup setup = turned_setup(*made, round.start_orientation_deg);
  setup.haptics.plane_height_m =
      height_with_contour_m(scene, setup.haptics.initial_pose).value_or(0.0);
  const ContourHand hand(contour_m);
  PathDevice no_device({});
  const auto rig = Rig::create(scene, setup, no_device);
  if (!rig) return rig.error();
  HapticLoop& loop = (*rig)->loop();
  const auto tick = [&](const Point2& goal_m) -> const TickRecord& {
    const Vec3 goal_scene_m(goal_m.x(), goal_m.y(), setup.haptics.plane_height_m);
    return loop.tick(loop.T_device_scene().point(goal_scene_m), setup.dt_s);
  };
  ContourAngle angle;
  angle.faults = tick(hand.start_m()).faults;
  const auto ticks = std::llround(round.duration_s / setup.dt_s);
  std::int64_t contacts = 0;
  double sum_rad = 0.0;
  for (std::int64_t k = 0; k < ticks; ++k) {
    const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(ticks);
    const TickRecord& record = tick(hand.goal_m(share));
    angle.faults |= record.faults;
    if (record.contact == 0) continue;
    ++contacts;
    sum_rad += record.alpha_rad;
  }
  angle.contact_share = static_cast<double>(contacts) / static_cast<double>(ticks);
  if (contacts > 0) {
    angle.mean_deg = sum_rad / static_cast<double>(contacts) * 180.0 / std::numbers::pi;
  }
  return angle;
}

}  // namespace palpate::bench
