#pragma once

// How a trip takes the force away without dropping the hand.

#include <cstdint>

#include "geometry/base/types.h"
#include "haptics/motor_limits.h"

namespace palpate {

struct GentleReleaseLimits {
  static constexpr std::int64_t kFall_ns = 30'000'000;
  // A hand that turns this often against the force within its fall swings: the force ends.
  static constexpr int kMostTurns = 2;
};

// The force after a trip: only what resists the motion, for a short time. Let F be the force before
// the trip, u the direction of the last motion within the span of the motors, and s the
// share of the fall that is left, from 1 to 0, linear in time. The force is s (F.u) u where F.u <
// 0, and zero at once where F.u >= 0. Without any motion since the trip, the hand rests on the
// force, which is s F.
//
// The force lies in the span of the motors and is at most s |F|. Held until the next tick, it does
// positive work only in a tick in which the motion turns by more than 90 degrees within the span,
// or begins; after kMostTurns of these ticks it is zero. Motors that are not orthogonal may need
// more each for this force than for F: the caller applies MotorLimits::scale().
//
// This is for trips whose reason leaves the samples and the force trustworthy. If samples are bad
// or stale, the device asks, or a force is not finite, the force is zero at once: stop(). Boards
// with a command for damping would use it here; the hAPI firmware has none.
//
// Thread-safety: one thread owns an object. No function allocates or throws.
class GentleRelease {
 public:
  // quantum_m: the step to which the device rounds its positions, >= 0. A way of one step does not
  // say in which direction the hand moves; a direction needs a longer way.
  explicit GentleRelease(double quantum_m = 0.0,
                         std::int64_t fall_ns = GentleReleaseLimits::kFall_ns) noexcept;

  // A trip. force_N: the force that the motors exert now, device frame. A force that is not finite
  // is not exerted any more.
  void begin(const Vec3& force_N) noexcept;

  // The force of the next tick, device frame. way_m: the device's way since the last tick, device
  // frame; one that is not finite ends the force. step_ns: the time of that way; 0 in the tick of
  // the trip.
  Vec3 force(const Vec3& way_m, std::int64_t step_ns, const MotorLimits& motors) noexcept;

  // The force ends.
  void stop() noexcept { is_active_ = false; }

  // False before begin(), and once the force has ended.
  bool is_active() const noexcept { return is_active_; }

 private:
  double quantum_m_;
  std::int64_t fall_ns_;
  bool is_active_ = false;
  bool has_moved_ = false;
  int turns_ = 0;
  std::int64_t age_ns_ = 0;        // since the trip
  Vec3 before_N_ = Vec3::Zero();   // the force before the trip
  Vec3 held_N_ = Vec3::Zero();     // the force of the last tick
  Vec3 way_m_ = Vec3::Zero();      // since the direction was found
  Vec3 direction_ = Vec3::Zero();  // of the motion, within the span of the motors
};

}  // namespace palpate
