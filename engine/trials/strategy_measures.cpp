#include "engine/trials/strategy_measures.h"

#include <algorithm>
#include <cmath>

#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// A sample that was ignored changes no force. Every other rule scales, drops or delays it.
constexpr std::uint32_t kRulesOfForce =
    ((1u << kGovernorRuleCount) - 1u) & ~std::uint32_t{kRuleOrder};

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
}

}  // namespace palpate
