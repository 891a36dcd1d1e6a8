#pragma once

// Publishes every tick of a viewed session to the network thread.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/session/haptic_session.h"
#include "engine/viewer/body_pose_ring.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/pointer_plan.h"
#include "engine/viewer/tick_ring.h"
#include "engine/viewer/tick_summary.h"

namespace palpate {

// The session publishes the record; this observer adds what the record lacks, in the same tick. A
// second copy of the record would take most of the time that this observer may use.
//
// on_tick() runs on the haptic thread; one other thread calls the other functions.
class StatePublisher final : public TickObserver {
 public:
  // loop: of the session. plan: of the simulated hand; null with a device that a person holds.
  // most_moving: how many bodies may move. All must outlive this object.
  StatePublisher(const HapticLoop& loop, const PointerPlan* plan, std::size_t most_moving)
      : loop_(loop), plan_(plan), bodies_(most_moving) {}

  void on_tick(const TickRecord& record) noexcept override {
    Hand hand;
    hand.tick = record.tick;
    if (plan_ != nullptr) {
      hand.pointer = plan_->sequence();
      const Vec3& target_m = plan_->target_m();
      hand.target_m = {target_m.x(), target_m.y(), target_m.z()};
      hand.flags = (plan_->has_target() ? kHandHasTarget : 0u) |
                   (plan_->is_held() ? static_cast<std::uint32_t>(kHandIsHeld) : 0u);
    }
    if (bodies_.capacity() > 0) bodies_.publish(record.tick, loop_);
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

  const HapticLoop& loop_;
  const PointerPlan* plan_;
  SnapshotRing<Hand> hands_;
  TickRing<TickSummary> ticks_;
  BodyPoseRing bodies_;
};

}  // namespace palpate
