#pragma once

// From a force at the tip of a pantograph to the torque numbers of its board.

#include <cstdint>
#include <optional>

#include "engine/devices/five_bar.h"
#include "engine/devices/hapi_protocol.h"
#include "engine/devices/hapi_settings.h"

namespace palpate {

// The pose of the linkage at an answer.
struct HapiPose {
  Vec2 joints_rad = Vec2::Zero();
  Vec2 tip_m = Vec2::Zero();
  Mat2 jacobian = Mat2::Zero();  // 0 if there is none
  double fade = 0.0;             // singularity_factor() of the Jacobian
};

// No value if the links cannot have these angles.
std::optional<HapiPose> hapi_pose(const FiveBar& bar, const HapiNumbers& angles_deg) noexcept;

// Converts forces. Besides the governor's limits, which hold in the pose of a tick, this class
// keeps what only the last step before the board can keep:
// - near a singular pose, the force fades to zero (singularity_factor());
// - no torque exceeds the peak torque in the newest pose;
// - after messages with zero force that the driver has sent by itself, the force grows by no more
//   than the governor's slew rule permits.
// Each of these reduces the length of the force and keeps its direction. A force within all limits
// is converted without a change.
//
// One thread owns an object. No function allocates or throws.
class HapiTorques {
 public:
  explicit HapiTorques(const HapiSettings& settings) noexcept : settings_(settings) {}

  // The numbers of a message. A force that is not finite counts as zero. since_last_ns: the
  // time since the last message that was sent, >= 0.
  HapiNumbers next(const Vec2& force_N, const HapiPose& pose, std::int64_t since_last_ns) noexcept;
  // The last result of next() was sent.
  void confirm() noexcept { sent_force_N_ = next_force_N_; }
  // A message with zero torques was sent, or is sent before any other one.
  void confirm_zero() noexcept { sent_force_N_.setZero(); }

 private:
  double slew_factor(const Vec2& force_N, std::int64_t since_last_ns) const noexcept;

  const HapiSettings& settings_;  // of the owner
  Vec2 next_force_N_ = Vec2::Zero();
  Vec2 sent_force_N_ = Vec2::Zero();
};

}  // namespace palpate
