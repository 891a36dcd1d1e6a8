#pragma once

// Publishes every tick of a viewed session to the network thread.

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

// on_tick() runs on the haptic thread; one other thread calls the other functions.
class StatePublisher final : public TickObserver {
 public:
  // loop: of the session. plan: of the simulated hand; null with a device that a person holds.
  // most_moving: how many bodies may move. All must outlive this object.
  StatePublisher(const HapticLoop& loop, const PointerPlan* plan, std::size_t most_moving)
      : loop_(loop), plan_(plan), bodies_(most_moving) {}

  void on_tick(const TickRecord& record) noexcept override {
    ViewState state;
    state.record = record;
    if (plan_ != nullptr) {
      state.pointer = plan_->sequence();
      const Vec3& target_m = plan_->target_m();
      state.target_m = {target_m.x(), target_m.y(), target_m.z()};
      state.flags = (plan_->has_target() ? kHandHasTarget : 0u) |
                    (plan_->is_held() ? static_cast<std::uint32_t>(kHandIsHeld) : 0u);
    }
    if (bodies_.capacity() > 0) bodies_.publish(record.tick, loop_);
    states_.publish(state);
    ticks_.add(TickSummary::of(record));
  }

  // Copies the newest state. Returns false if there is none yet.
  bool newest(ViewState& state, std::vector<BodyPose>& bodies) const {
    constexpr int kAttempts = 4;  // the next tick may overwrite one of the two
    for (int i = 0; i < kAttempts; ++i) {
      if (!states_.read(state)) return false;
      if (bodies_.capacity() == 0 || bodies_.read(state.record.tick, bodies)) return true;
    }
    return false;
  }
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) {
    return ticks_.read([&rows](const TickSummary& row) { rows.push_back(row); });
  }

 private:
  const HapticLoop& loop_;
  const PointerPlan* plan_;
  // Few slots, so that they use little of the haptic thread's cache.
  SnapshotRing<ViewState, 8> states_;
  TickRing<TickSummary> ticks_;
  BodyPoseRing bodies_;
};

}  // namespace palpate
