#pragma once

// A device that stays at the position that the test sets.

#include "engine/devices/vector_device.h"

namespace palpate::test {

class StillDevice final : public VectorDevice {
 public:
  explicit StillDevice(const Vec3& at_m) : position_m(at_m) {}
  Vec3 read_position_m(double) noexcept override { return position_m; }
  void command_force_N(const Vec3& force) noexcept override { force_N = force; }

  Vec3 position_m;
  Vec3 force_N = Vec3::Zero();  // force of the last command
};

}  // namespace palpate::test
