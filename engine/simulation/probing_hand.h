#pragma once

// A hand that tries a scene without knowing it: it moves out into one direction after the other,
// holds still, and comes back.

#include <array>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// What the hand does at a time. Of a bare tip, which no hand can hold, each probe is a throw.
struct Probe {
  std::uint64_t number = 0;       // of the probe, from 1 on; 0: the hand waits at its rest
  Vec2 direction = Vec2::Zero();  // unit
  double share = 0.0;             // of the way out, 0 to 1
  bool is_judged = false;         // the hand has held still for some time: the tip must be at rest
};

struct ProbingHand {
  static constexpr double kWait_s = 2.0;  // for the governor's start
  static constexpr double kMove_s = 1.0;  // out, and back
  static constexpr double kHold_s = 4.0;
  static constexpr double kJudged_s = 1.0;  // the end of a hold
  static constexpr double kReach_m = 0.02;
  static constexpr double kThrow_m_per_s = 0.2;

  // time_s: since the first message of a host.
  static Probe at(double time_s) {
    constexpr double kCycle_s = 2.0 * kMove_s + kHold_s;
    if (time_s < kWait_s) return {};
    const auto number = static_cast<std::uint64_t>((time_s - kWait_s) / kCycle_s);
    const double in_cycle_s = time_s - kWait_s - kCycle_s * static_cast<double>(number);
    // None leads towards the motors, where a linkage in its rest pose ends.
    static const std::array<Vec2, 4> kDirections = {Vec2(0, 1), Vec2(1, 0), Vec2(-1, 0),
                                                    Vec2(0.6, 0.8)};
    Probe probe{number + 1, kDirections[number % kDirections.size()]};
    if (in_cycle_s < kMove_s) {
      probe.share = in_cycle_s / kMove_s;
    } else if (in_cycle_s < kMove_s + kHold_s) {
      probe.share = 1.0;
      probe.is_judged = in_cycle_s >= kMove_s + kHold_s - kJudged_s;
    } else {
      probe.share = (kCycle_s - in_cycle_s) / kMove_s;
    }
    return probe;
  }
};

}  // namespace palpate
