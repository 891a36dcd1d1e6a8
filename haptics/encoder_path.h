#pragma once

// Where a device is between the steps of its encoders.

#include <array>

#include "geometry/base/types.h"

namespace palpate {

// A device that rounds its positions to steps of q seems to stand still and to jump. With the
// force of before the jump, the jump of a spring K seems to give K q^2 / 2 in both directions; and
// (dx)^2 / T of a hand of speed v < q / T is q / (v T) times too large.
//
// A jump says exactly where the device is: at the edge between the two steps. From there the path
// goes on with the speed between the last two edges, and stays within the step that the device
// reports. Each axis is a path of its own. For the device's tick T,
// - in a tick with a jump, the device is past the edge by half of the way of the tick, at most by
//   half a step: a device that jumps over several steps is where it says;
// - after a jump back over the same edge, the speed is unknown and counts as zero.
//
// The path is at most half a step from the position that the device reports. Without steps, it is
// that position, to the bit. One thread owns an object. No function allocates or throws.
class EncoderPath {
 public:
  // quantum_m: the step, >= 0. A linkage whose angles have steps states its largest one.
  explicit EncoderPath(double quantum_m) noexcept : quantum_m_(quantum_m) {}

  // The place of a new sample, time_s after the last one.
  Vec3 add(const Vec3& sensed_m, double time_s) noexcept;
  // The path begins anew with the next sample.
  void clear() noexcept { is_known_ = false; }

 private:
  struct Axis {
    double sensed_m = 0.0;
    double edge_m = 0.0;  // the last one
    double since_s = 0.0;
    double speed_m_per_s = 0.0;
    bool has_edge = false;

    double add(double at_m, double time_s, double quantum_m) noexcept;
    void jump(double at_m, double quantum_m) noexcept;
  };

  double quantum_m_;
  std::array<Axis, 3> axes_;
  bool is_known_ = false;
};

}  // namespace palpate
