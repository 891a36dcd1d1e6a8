#pragma once

// Passes the poses of moving bodies from the haptic thread to one reader, without waiting.

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/viewer/messages.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// The poses of the last kSlots ticks. publish() takes time in proportion to the bodies that have
// moved. As in SnapshotRing, every word is atomic, and a stamp tells whether the words of a slot
// belong together.
class BodyPoseRing {
 public:
  static constexpr std::size_t kSlots = 8;

  // capacity: the largest number of moving bodies; 0: the ring is not used.
  explicit BodyPoseRing(std::size_t capacity) : capacity_(capacity) {
    for (Slot& slot : slots_) slot.words = std::vector<std::atomic<std::uint64_t>>(8 * capacity);
  }

  std::size_t capacity() const noexcept { return capacity_; }

  // Only the haptic thread may call this function. tick: one more than in the last call.
  void publish(std::uint64_t tick, const HapticLoop& loop) noexcept {
    const auto bodies = loop.moved_bodies();
    Slot& slot = slots_[tick % kSlots];
    slot.stamp.store(0, std::memory_order_relaxed);
    const std::size_t count = std::min(bodies.size(), capacity_);
    slot.count.store(count, std::memory_order_release);
    for (std::size_t i = 0; i < count; ++i) store(slot, i, bodies[i], loop.T_scene_body(bodies[i]));
    slot.stamp.store(tick + 1, std::memory_order_release);
  }

  // Copies the poses of a tick. Returns false if they have been overwritten.
  bool read(std::uint64_t tick, std::vector<BodyPose>& bodies) const {
    const Slot& slot = slots_[tick % kSlots];
    if (slot.stamp.load(std::memory_order_acquire) != tick + 1) return false;
    bodies.resize(slot.count.load(std::memory_order_acquire));
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i] = load(slot, i);
    return slot.stamp.load(std::memory_order_relaxed) == tick + 1;
  }

 private:
  struct Slot {
    std::atomic<std::uint64_t> stamp{0};
    std::atomic<std::size_t> count{0};
    std::vector<std::atomic<std::uint64_t>> words;  // 8 per body
  };

  static void store(Slot& slot, std::size_t i, std::uint32_t body,
                    const RigidTransform& T) noexcept {
    const std::array<double, 7> numbers = {
        T.rotation.w(),      T.rotation.x(),      T.rotation.y(),     T.rotation.z(),
        T.translation_m.x(), T.translation_m.y(), T.translation_m.z()};
    slot.words[8 * i].store(body, std::memory_order_release);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      slot.words[8 * i + 1 + k].store(std::bit_cast<std::uint64_t>(numbers[k]),
                                      std::memory_order_release);
    }
  }
  static BodyPose load(const Slot& slot, std::size_t i) {
    const auto number = [&](std::size_t k) {
      return std::bit_cast<double>(slot.words[8 * i + 1 + k].load(std::memory_order_acquire));
    };
    BodyPose pose;
    pose.body = static_cast<std::uint32_t>(slot.words[8 * i].load(std::memory_order_acquire));
    pose.q_wxyz = {number(0), number(1), number(2), number(3)};
    pose.o_m = {number(4), number(5), number(6)};
    return pose;
  }

  std::size_t capacity_;
  std::array<Slot, kSlots> slots_;
};

}  // namespace palpate
