#pragma once

// A pointer of a page as a device without motors: the pointer moves the device point itself.

#include <atomic>
#include <utility>

#include "engine/devices/snapshot_ring.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/pointed_hand.h"
#include "palpate/device.h"

namespace palpate {

// The device point is where the newest pointer message puts it. A message states the sum of all
// motions of the pointer, so that a message that is not used loses no motion.
// Thread-safety: one thread calls point(); the others run on the haptic thread.
class PointedDevice final : public Device, public PointedHand {
 public:
  // description: its motors are left out. start_m: the device point before the first message,
  // device frame. With 2 sensors it stays in the plane of start_m.
  PointedDevice(DeviceDescription description, const Vec3& start_m)
      : description_(std::move(description)), position_m_(start_m) {
    description_.moves_motors = false;
    wish_.position_m = {start_m.x(), start_m.y(), start_m.z()};
  }

  // A message with a sequence that is not greater than the last one is ignored.
  void point(const PointerMessage& message) {
    if (message.sequence <= wish_.sequence) return;
    const bool is_press = message.holds && wish_.holds == 0;
    if (is_press) presses_.store(presses_.load(std::memory_order_relaxed) + 1);
    wish_ = {message.sequence, message.holds ? 1u : 0u, message.target_m};
    mailbox_.publish(wish_);
  }

  // How often the pointer has been taken up: a pen or a finger that was lifted counts again. Any
  // thread may call it.
  std::uint32_t presses() const noexcept { return presses_.load(); }

  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double /*dt_s*/) noexcept override {
    if (mailbox_.read(used_)) {
      position_m_.x() = used_.position_m[0];
      position_m_.y() = used_.position_m[1];
      if (description_.sensed_axes == 3) position_m_.z() = used_.position_m[2];
    }
    DeviceSample sample;
    sample.position_m = {position_m_.x(), position_m_.y(), position_m_.z()};
    sample.sequence = ++samples_;
    return sample;
  }
  void command(const DeviceCommand&) noexcept override {}

  std::uint64_t sequence() const noexcept override { return used_.sequence; }
  const Vec3& target_m() const noexcept override { return position_m_; }
  bool is_held() const noexcept override { return used_.holds != 0; }
  bool has_target() const noexcept override { return used_.holds != 0; }

 private:
  struct Wish {
    std::uint64_t sequence = 0;
    std::uint64_t holds = 0;
    std::array<double, 3> position_m = {};  // device frame
  };

  DeviceDescription description_;
  Wish wish_;  // of the thread that calls point()
  std::atomic<std::uint32_t> presses_{0};
  SnapshotRing<Wish, 8> mailbox_;
  Wish used_;  // of the haptic thread
  Vec3 position_m_;
  std::uint64_t samples_ = 0;
};

}  // namespace palpate
