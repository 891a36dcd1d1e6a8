#include "engine/devices/hapi_torques.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptics/motor_limits.h"
#include "haptics/safety_governor.h"

namespace palpate {

std::optional<HapiPose> hapi_pose(const FiveBar& bar, const HapiNumbers& angles_deg) noexcept {
  HapiPose pose;
  for (int k = 0; k < 2; ++k) {
    const auto degrees = static_cast<double>(angles_deg[static_cast<std::size_t>(k)]);
    pose.joints_rad[k] = degrees * std::numbers::pi / 180.0;
  }
  const auto tip_m = bar.forward(pose.joints_rad);
  if (!tip_m) return std::nullopt;
  pose.tip_m = *tip_m;
  if (const auto jacobian = bar.jacobian(pose.joints_rad)) {
    pose.jacobian = *jacobian;
    pose.fade = singularity_factor(condition_number(pose.jacobian));
  }
  return pose;
}

HapiNumbers HapiTorques::next(const Vec2& wanted_N, const HapiPose& pose,
                              std::int64_t since_last_ns) noexcept {
  const bool is_usable = wanted_N.allFinite() && settings_.torque_per_Nm && pose.fade > 0.0;
  Vec2 force_N = is_usable ? wanted_N : Vec2::Zero();
  if (pose.fade < 1.0) force_N *= pose.fade;
  const double largest_Nm = (pose.jacobian.transpose() * force_N).cwiseAbs().maxCoeff();
  if (largest_Nm > settings_.peak_torque_Nm) {
    force_N *= kBelowLimit * settings_.peak_torque_Nm / largest_Nm;
  }
  const double slew = slew_factor(force_N, since_last_ns);
  if (slew < 1.0) force_N *= slew;
  next_force_N_ = force_N;
  const Vec2 torques_Nm = pose.jacobian.transpose() * force_N;
  HapiNumbers numbers{};
  if (!is_usable) return numbers;
  for (int k = 0; k < 2; ++k) {
    numbers[static_cast<std::size_t>(k)] =
        static_cast<float>(*settings_.torque_per_Nm * torques_Nm[k]);
  }
  return numbers;
}

// As the governor's rule: the force grows from the part of the force that was sent last, along the
// new direction.
double HapiTorques::slew_factor(const Vec2& force_N, std::int64_t since_last_ns) const noexcept {
  const double length_N = force_N.norm();
  if (length_N == 0.0) return 1.0;
  const double longest_s = GovernorLimits::kLongestStepPeriods / settings_.rate_Hz;
  const double time_s = std::min(1e-9 * static_cast<double>(since_last_ns), longest_s);
  const double before_N = std::max(0.0, sent_force_N_.dot(force_N) / length_N);
  const double most_N = before_N + GovernorLimits::kSlew_N_per_s * time_s;
  return length_N > most_N ? kBelowLimit * most_N / length_N : 1.0;
}

}  // namespace palpate
