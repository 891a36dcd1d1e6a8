#pragma once

// A pointer on a page as the target of the simulated hand.

#include <array>
#include <atomic>
#include <cstdint>

#include "engine/devices/snapshot_ring.h"
#include "engine/simulation/simulated_device.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/pointed_hand.h"

namespace palpate {

// The hand follows the newest pointer message while it holds. It lets go, which means that its
// target becomes the place where the device is: after a message that does not hold, after
// let_go(), and if no newer message arrives for kPatience_s of the hand's time. start() moves the
// target to the start position, in a straight line at kStartSpeed_m_per_s, until a newer message
// comes; the hand lets go kPatience_s after the target has arrived.
//
// Thread-safety: one thread calls point(), let_go() and start(); target() runs on the haptic
// thread, and the thread of an observer there may call the other functions.
class PointerPlan final : public HandPlan, public PointedHand {
 public:
  static constexpr double kPatience_s = 0.3;
  static constexpr double kStartSpeed_m_per_s = 0.1;

  explicit PointerPlan(const Vec3& start_device_m) : start_m_(start_device_m) {}

  // A message with a sequence that is not greater than the last one is ignored.
  void point(const PointerMessage& message);
  void let_go();
  void start();

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // Of the last target().
  std::uint64_t sequence() const noexcept override { return used_.sequence; }
  const Vec3& target_m() const noexcept override { return target_m_; }
  bool is_held() const noexcept override { return mode_ == Mode::kHeld; }
  bool has_target() const noexcept override { return mode_ != Mode::kFree; }

 private:
  enum class Mode : std::uint32_t { kFree, kHeld, kStarts };
  struct Wish {
    std::uint64_t number = 0;    // counts the wishes
    std::uint64_t sequence = 0;  // of the newest pointer message
    Mode mode = Mode::kFree;
    std::uint32_t unused = 0;
    std::array<double, 3> target_m = {};
  };

  void publish();
  void take_wish(double time_s);
  void move_to_start(double time_s, const Vec3& device_m);

  Vec3 start_m_;
  Wish wish_;  // of the thread that calls point()
  std::atomic<std::uint64_t> newest_{0};
  SnapshotRing<Wish, 8> mailbox_;

  // Of the haptic thread.
  Wish used_;
  Mode mode_ = Mode::kFree;
  double wish_time_s_ = 0.0;
  double last_time_s_ = 0.0;
  bool begins_ = false;   // the motion to the start has not begun yet
  double moved_s_ = 0.0;  // when the target was last on its way to the start
  Vec3 target_m_ = Vec3::Zero();
};

}  // namespace palpate
