#pragma once

// The changes that a program may make to a haptic loop before a tick.

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/session/tick_sink.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// Makes changes to a loop and hands each of them to a recording, at the place where it acts. Code
// that runs before a tick gets this object in place of the loop, so that no change can miss the
// recording: each function packs its arguments into a TickInput, and apply_change() unpacks them,
// also when a recording is replayed. (The parameters of effects are unpacked by the replay.) A copy
// refers to the same loop.
//
// The functions are those of HapticLoop with the same names. Call them on the haptic thread.
class LoopChanges {
 public:
  // sink: null without a recording.
  LoopChanges(HapticLoop& loop, TickSink* sink = nullptr)  // NOLINT(google-explicit-constructor)
      : loop_(&loop), sink_(sink) {}

  void move_body(std::uint32_t body, const RigidTransform& T_scene_body) noexcept;
  void refuse_body_pose() noexcept { make({InputKind::kBadBodyPose}); }
  void set_actuation(const ActuationModel& actuation) noexcept;
  // effect: its index in compiled_effects(). The input holds the numbers of the effect's keys only:
  // the other bytes are fixed when a scene is compiled, and may be addresses of this process.
  void set_effect_parameters(std::uint32_t call, std::uint16_t effect,
                             std::span<const std::byte> parameters) noexcept;
  // setting: its place in kLiveSettings. The value must be one that the setting can have.
  void set(std::size_t setting, double value) noexcept;
  void free_hand() noexcept { make({InputKind::kFreeHand, 1}); }
  void hold_hand() noexcept { make({InputKind::kFreeHand, 0}); }

  const HapticLoop& loop() const noexcept { return *loop_; }

  // Makes a change of a recording. False, and no change, if the input is none of a loop, has bytes
  // that no change has, or needs the scene's effects: see set_effect_parameters().
  bool make(const TickInput& input) noexcept;

 private:
  HapticLoop* loop_;
  TickSink* sink_;
};

}  // namespace palpate
