#pragma once

// Publishes every tick of a viewed session to the network thread.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/session/haptic_session.h"
#include "engine/session/live_setting.h"
#include "engine/viewer/body_pose_ring.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/pointed_hand.h"
#include "engine/viewer/tick_ring.h"
#include "engine/viewer/tick_summary.h"

namespace palpate {

// What a page shows of the loop's settings. Plain numbers, so that they can be copied bytewise.
struct LoopValues {
  std::array<double, kLiveSettings.size()> settings = {};
  std::uint32_t axis_count = 0;                    // actuators
  std::uint32_t sensors = 0;                       // 0: no tick has run
  std::array<std::array<double, 3>, 3> axes = {};  // a basis of the actuated span, device frame

  static LoopValues of(const HapticLoop& loop) noexcept {
    const ActuationModel& actuation = loop.actuation();
    LoopValues values;
    for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
      values.settings[i] = kLiveSettings[i].value(loop.settings());
    }
    values.axis_count = static_cast<std::uint32_t>(actuation.actuators());
    values.sensors = static_cast<std::uint32_t>(actuation.sensors());
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& axis = actuation.actuated_axis(static_cast<int>(i));
      values.axes[i] = {axis.x(), axis.y(), axis.z()};
    }
    return values;
  }
  bool operator==(const LoopValues&) const = default;
};

// The session publishes the record; this observer adds what the record lacks, in the same tick. A
// second copy of the record would take most of the time that this observer may use.
//
// on_tick() runs on the haptic thread; one other thread calls the other functions.
class StatePublisher final : public TickObserver {
 public:
  // loop: of the session. hand: that a pointer moves; null with a device that a person holds.
  // most_moving: how many bodies may move. All must outlive this object.
  StatePublisher(const HapticLoop& loop, const PointedHand* hand, std::size_t most_moving)
      : loop_(loop), pointed_(hand), bodies_(most_moving) {}

  void on_tick(const TickRecord& record) noexcept override {
    Hand hand;
    hand.tick = record.tick;
    if (pointed_ != nullptr) {
      hand.pointer = pointed_->sequence();
      const Vec3& target_m = pointed_->target_m();
      hand.target_m = {target_m.x(), target_m.y(), target_m.z()};
      hand.flags = (pointed_->has_target() ? kHandHasTarget : 0u) |
                   (pointed_->is_held() ? static_cast<std::uint32_t>(kHandIsHeld) : 0u);
    }
    if (bodies_.capacity() > 0) bodies_.publish(record.tick, loop_);
    if (!(LoopValues::of(loop_) == newest_)) publish_loop();
    hands_.publish(hand);
    ticks_.add(TickSummary::of(record));
  }

  // Copies the newest state of this session. Returns false if there is none yet, or if the haptic
  // thread overwrote it in every attempt.
  bool newest(const HapticSession& session, ViewState& state, std::vector<BodyPose>& bodies) const {
    constexpr int kAttempts = 8;
    for (int i = 0; i < kAttempts; ++i) {
      Hand hand;
      if (!hands_.read(hand) || !session.latest(state.record)) return false;
      if (state.record.tick != hand.tick) continue;  // a tick ended in between
      if (bodies_.capacity() > 0 && !bodies_.read(hand.tick, bodies)) continue;
      state.pointer = hand.pointer;
      state.target_m = hand.target_m;
      state.flags = hand.flags;
      return true;
    }
    return false;
  }
  // The settings with which the newest tick ran. Returns false before the first tick.
  bool loop_values(LoopValues& values) const { return loops_.read(values); }
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) {
    return ticks_.read([&rows](const TickSummary& row) { rows.push_back(row); });
  }

 private:
  // What a record does not hold.
  struct Hand {
    std::uint64_t tick = 0;
    std::uint64_t pointer = 0;
    std::array<double, 3> target_m = {};
    std::uint32_t flags = 0;
    std::uint32_t unused = 0;
  };

  [[gnu::noinline]] void publish_loop() noexcept {
    newest_ = LoopValues::of(loop_);
    loops_.publish(newest_);
  }

  const HapticLoop& loop_;
  const PointedHand* pointed_;
  LoopValues newest_;
  SnapshotRing<LoopValues, 8> loops_;
  SnapshotRing<Hand> hands_;
  TickRing<TickSummary> ticks_;
  BodyPoseRing bodies_;
};

}  // namespace palpate
