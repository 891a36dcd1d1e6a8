#pragma once

// A pointer of a page as a device without motors: the pointer moves the device point itself.

#include <utility>

#include "engine/devices/snapshot_ring.h"
#include "engine/live/clutch.h"
#include "engine/session/haptic_session.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/pointed_hand.h"
#include "palpate/device.h"

namespace palpate {

// The device point is where the newest pointer message puts it, less what the clutch leaves out. A
// message states the sum of all motions of the pointer, so that a message that is not used loses no
// motion. An observer of the ticks, because the clutch acts out of contact only.
// Thread-safety: one thread calls point(); the others run on the haptic thread.
class PointedDevice final : public Device, public PointedHand, public TickObserver {
 public:
  // description: its motors are left out. start_m: the device point before the first message,
  // device frame. With 2 sensors it stays in the plane of start_m.
  PointedDevice(DeviceDescription description, const Vec3& start_m, bool permits_clutch = false)
      : description_(std::move(description)), clutch_(permits_clutch), position_m_(start_m) {
    description_.moves_motors = false;
    wish_.position_m = {start_m.x(), start_m.y(), start_m.z()};
  }

  // A message with a sequence that is not greater than the last one is ignored.
  void point(const PointerMessage& message) {
    if (message.sequence <= wish_.sequence) return;
    Clutch::Presses& presses = wish_.presses;
    if (message.is_clutched && !is_clutched_) {
      ++presses.count;
      presses.is_lift = message.holds ? 0u : 1u;
    }
    is_clutched_ = message.is_clutched;
    for (std::size_t k = 0; is_clutched_ && k < 3; ++k) {
      presses.motion_m[k] += message.target_m[k] - wish_.position_m[k];
    }
    wish_ = {message.sequence, message.holds ? 1u : 0u, message.target_m, presses};
    mailbox_.publish(wish_);
  }

  const Clutch& clutch() const noexcept { return clutch_; }

  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double /*dt_s*/) noexcept override {
    clutch_.judge();
    if (mailbox_.read(used_)) clutch_.take(used_.presses);
    if (used_.sequence != 0) place();
    DeviceSample sample;
    sample.position_m = {position_m_.x(), position_m_.y(), position_m_.z()};
    sample.sequence = ++samples_;
    return sample;
  }
  void command(const DeviceCommand&) noexcept override {}
  void on_tick(const TickRecord& record) noexcept override {
    clutch_.set_contact(record.contact != 0);
  }

  std::uint64_t sequence() const noexcept override { return used_.sequence; }
  const Vec3& target_m() const noexcept override { return position_m_; }
  bool is_held() const noexcept override { return used_.holds != 0; }
  bool has_target() const noexcept override { return used_.holds != 0; }

 private:
  struct Wish {
    std::uint64_t sequence = 0;
    std::uint64_t holds = 0;
    std::array<double, 3> position_m = {};  // device frame
    Clutch::Presses presses = {};
  };

  void place() noexcept {
    const Vec3 left_out_m = clutch_.left_out_m();
    const Eigen::Index axes = description_.sensed_axes == 3 ? 3 : 2;
    for (Eigen::Index k = 0; k < axes; ++k) {
      position_m_[k] = used_.position_m[static_cast<std::size_t>(k)] - left_out_m[k];
    }
  }

  DeviceDescription description_;
  Wish wish_;                 // of the thread that calls point()
  bool is_clutched_ = false;  // as well
  SnapshotRing<Wish, 8> mailbox_;
  Clutch clutch_;  // from here: of the haptic thread
  Wish used_;
  Vec3 position_m_;
  std::uint64_t samples_ = 0;
};

}  // namespace palpate
