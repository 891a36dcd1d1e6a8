#pragma once

// Passes the latest value of one writer to any number of readers, without waiting.

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace palpate {

// publish() is wait-free and independent of readers. read() takes a bounded number of steps: it
// copies the newest slot and checks that the writer has not reused the slot meanwhile. The writer
// reuses a slot after kSlots - 1 further values (63 ms at 1 kHz); read() then tries once more.
//
// Every word is atomic, so that no data race exists. Release stores and acquire loads order the
// words relative to the slot's stamp.
template <typename T, std::size_t kSlots = 64>
class SnapshotRing {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Only one thread may call this function. Safe on the haptic thread.
  void publish(const T& value) noexcept {
    const std::uint64_t stamp = ++written_;
    Slot& slot = slots_[stamp % kSlots];
    slot.stamp.store(0, std::memory_order_relaxed);
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < kWords; ++i) {
      slot.words[i].store(words[i], std::memory_order_release);
    }
    slot.stamp.store(stamp, std::memory_order_release);
    latest_.store(stamp, std::memory_order_release);
  }

  // Copies the newest value to `value` and returns true. Returns false and leaves `value` unchanged
  // if no value has been published yet or if the thread was suspended twice while the writer
  // published kSlots values.
  bool read(T& value) const noexcept {
    for (int attempt = 0; attempt < 2; ++attempt) {
      const std::uint64_t stamp = latest_.load(std::memory_order_acquire);
      if (stamp == 0) return false;
      const Slot& slot = slots_[stamp % kSlots];
      std::array<std::uint64_t, kWords> words;
      if (slot.stamp.load(std::memory_order_acquire) != stamp) continue;
      for (std::size_t i = 0; i < kWords; ++i) {
        words[i] = slot.words[i].load(std::memory_order_acquire);
      }
      if (slot.stamp.load(std::memory_order_relaxed) != stamp) continue;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
      return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  struct Slot {
    std::atomic<std::uint64_t> stamp{0};
    std::array<std::atomic<std::uint64_t>, kWords> words{};
  };

  std::array<Slot, kSlots> slots_{};
  std::atomic<std::uint64_t> latest_{0};
  std::uint64_t written_ = 0;  // used by the writer only
};

}  // namespace palpate
