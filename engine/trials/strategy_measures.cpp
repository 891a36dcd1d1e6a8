#include "engine/trials/strategy_measures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// A sample that was ignored changes no force. Every other rule scales, drops or delays it.
constexpr std::uint32_t kRulesOfForce =
    ((1u << kGovernorRuleCount) - 1u) & ~std::uint32_t{kRuleOrder};

Vec3 device_lag_m(const TickRecord& record) {
  return pose_before(record).direction(vec3(record.proxy_scene_m) - vec3(record.goal_scene_m));
}

// The part of the projected full force that is commanded. The commanded force has the direction of
// the projection, so that f.F is the product of their lengths.
double motor_share(const TickRecord& record) {
  const Vec3 force_N = vec3(record.force_device_N);
  const double projected = force_N.dot(vec3(record.full_force_device_N));
  return projected > 0.0 ? force_N.squaredNorm() / projected : 0.0;
}

}  // namespace

StrategyMeasures::StrategyMeasures(double dt_s)
    : touch_wait_ticks_(static_cast<std::uint64_t>(std::llround(kTouchWait_s / dt_s))) {}

void StrategyMeasures::begin(const TickRecord& record) noexcept {
  home_ = pose_before(record);
}

void StrategyMeasures::add(const TickRecord& record) noexcept {
  ++ticks_;
  if (record.rules & kRulesOfForce) ++governed_;
  add_work(record);
  add_turn(record);
  add_drift(record);
  add_turning_energy(record);
}

void StrategyMeasures::add_work(const TickRecord& record) noexcept {
  const Vec3 device_m = vec3(record.device_m);
  if (was_in_contact_) {
    const Vec3 moved_m = device_m - last_device_m_;
    wall_work_J_ += std::max(0.0, last_tangential_N_.dot(moved_m));
    contact_work_J_ += last_force_N_.dot(moved_m);
    if (!record.contact) {
      largest_contact_work_J_ =
          std::max(largest_contact_work_J_.value_or(contact_work_J_), contact_work_J_);
      contact_work_J_ = 0.0;
    }
  }
  was_in_contact_ = record.contact != 0;
  last_device_m_ = device_m;
  last_force_N_ = vec3(record.force_device_N);
  const Vec3 normal = pose_before(record).direction(vec3(record.normal_scene));
  // Normals that cancel have no tangent.
  last_tangential_N_ = normal == Vec3::Zero()
                           ? Vec3(Vec3::Zero())
                           : Vec3(last_force_N_ - last_force_N_.dot(normal) * normal);
}

void StrategyMeasures::add_turn(const TickRecord& record) noexcept {
  if (record.contact) {
    since_turn_.reset();
  } else if (record.rotation_rad != 0.0) {
    since_turn_ = 0;
  } else if (since_turn_ && ++*since_turn_ >= touch_wait_ticks_) {
    ++empty_turns_;
    since_turn_.reset();
  }
}

void StrategyMeasures::add_drift(const TickRecord& record) noexcept {
  const ScenePose pose = pose_before(record);
  has_turned_ = has_turned_ || pose.rotation.coeffs() != home_.rotation.coeffs();
  const double drift_m = (pose.translation_m - home_.translation_m).norm();
  drift_sum_m_ += drift_m;
  worst_drift_m_ = std::max(worst_drift_m_, drift_m);
}

void StrategyMeasures::add_turning_energy(const TickRecord& record) noexcept {
  const TickRecord last = std::exchange(last_, record);
  const bool is_on_one_wall = last.contacts == 1 && record.contacts == 1 &&
                              vec3(last.normal_scene) == vec3(record.normal_scene);
  const bool is_governed = ((last.rules | record.rules) & kRulesOfForce) != 0;
  if (!is_on_one_wall || is_governed || last.rotation_rad == 0.0) return;
  const Vec3 lag_m = device_lag_m(record);
  const double length_m = lag_m.norm();
  const double share = motor_share(record);
  if (length_m == 0.0 || share == 0.0) return;
  // The lag after the turn, if the hand stays.
  const double settled_m =
      device_lag_m(last).dot(pose_after(last).direction(vec3(last.normal_scene)));
  const double depth_m = std::max(0.0, settled_m - (1.0 - share) * length_m);
  const double after_m = depth_m * std::cos(record.alpha_rad);
  const double before_m = device_lag_m(last).norm() * motor_share(last) * std::cos(last.alpha_rad);
  const double stiffness_N_per_m = vec3(record.full_force_device_N).norm() / length_m;
  turning_energy_J_ +=
      std::max(0.0, 0.5 * stiffness_N_per_m * (after_m * after_m - before_m * before_m));
}

void StrategyMeasures::put(std::array<std::optional<double>, kMeasureCount>& measures) const {
  const auto ticks = static_cast<double>(ticks_);
  measures[kWallWork] = wall_work_J_;
  measures[kLargestContactWork] = largest_contact_work_J_;
  if (was_in_contact_) {
    measures[kLargestContactWork] =
        std::max(largest_contact_work_J_.value_or(contact_work_J_), contact_work_J_);
  }
  measures[kEmptyTurns] = static_cast<double>(empty_turns_);
  if (!has_turned_) {
    measures[kMeanDrift] = drift_sum_m_ / ticks;
    measures[kWorstDrift] = worst_drift_m_;
  }
  measures[kGovernorShare] = static_cast<double>(governed_) / ticks;
  measures[kTurningEnergy] = turning_energy_J_;
}

}  // namespace palpate
