#pragma once

// The clutch of a pointer: the hand is set back while the device point stands still.

#include <array>
#include <atomic>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// A plan permits it or not. It takes effect out of contact only: a press in contact does nothing,
// and what the hand does until the next press moves the device point. A pen or a finger presses it
// by leaving the screen, and cannot be kept from that: refused_lifts() counts what a trial must not
// have.
// Thread-safety: any thread may call uses(); all others run on the haptic thread.
class Clutch {
 public:
  // The presses of all messages up to one of them: a message that is not used loses none.
  struct Presses {
    std::uint64_t count = 0;
    std::uint64_t is_lift = 0;            // the last one was of a pen or finger
    std::array<double, 3> motion_m = {};  // the sum of all motions while it was pressed
  };

  explicit Clutch(bool is_permitted) : is_permitted_(is_permitted) {}

  // Judges the presses of the tick before by its contact, at the place where they found the device
  // point. Call it once a tick, before take().
  void judge() noexcept {
    if (seen_.count == judged_) return;
    const std::uint64_t presses = seen_.count - judged_;
    judged_ = seen_.count;
    is_engaged_ = is_permitted_ && !is_in_contact_;
    if (is_engaged_) {
      ignored_m_ += pending_m_;
      uses_.store(uses_.load(std::memory_order_relaxed) + static_cast<std::uint32_t>(presses),
                  std::memory_order_relaxed);
    } else if (seen_.is_lift != 0) {
      ++refused_lifts_;
    }
    pending_m_.setZero();
  }
  void take(const Presses& newest) noexcept {
    const Vec3 moved_m = Vec3(newest.motion_m[0], newest.motion_m[1], newest.motion_m[2]) -
                         Vec3(seen_.motion_m[0], seen_.motion_m[1], seen_.motion_m[2]);
    if (newest.count != judged_) {
      pending_m_ += moved_m;
    } else if (is_engaged_) {
      ignored_m_ += moved_m;
    }
    seen_ = newest;
  }
  // Of the tick that ends.
  void set_contact(bool is_in_contact) noexcept { is_in_contact_ = is_in_contact; }

  // The part of the hand's motion that does not move the device point, device frame.
  Vec3 left_out_m() const noexcept { return ignored_m_ + pending_m_; }
  // Lifts in contact, or of a plan that does not permit the clutch.
  std::uint64_t refused_lifts() const noexcept { return refused_lifts_; }
  // How often it took effect.
  std::uint32_t uses() const noexcept { return uses_.load(std::memory_order_relaxed); }

 private:
  bool is_permitted_;
  bool is_in_contact_ = false;
  bool is_engaged_ = false;   // by the press that was judged last
  std::uint64_t judged_ = 0;  // presses
  std::uint64_t refused_lifts_ = 0;
  Presses seen_;
  Vec3 ignored_m_ = Vec3::Zero();
  Vec3 pending_m_ = Vec3::Zero();  // until the presses of this tick are judged
  std::atomic<std::uint32_t> uses_{0};
};

}  // namespace palpate
