#pragma once

// Passes the rows of all ticks from the haptic thread to one reader, without waiting.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>

namespace palpate {

// The writer never waits: it overwrites the oldest row. The reader notices rows that were
// overwritten before it read them and counts them as lost. add() is wait-free.
//
// Every word is atomic, so that no data race exists; the stamp of a row tells whether its words
// belong together (as in SnapshotRing).
template <typename Row, std::size_t kRows = 4096>
class TickRing {
  static_assert(std::is_trivially_copyable_v<Row>);

 public:
  TickRing() : slots_(std::make_unique<std::array<Slot, kRows>>()) {}

  // Only one thread may call this function. Safe on the haptic thread.
  void add(const Row& row) noexcept {
    const std::uint64_t stamp = ++added_;
    Slot& slot = (*slots_)[stamp % kRows];
    slot.stamp.store(0, std::memory_order_relaxed);
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &row, sizeof(Row));
    for (std::size_t i = 0; i < kWords; ++i) {
      slot.words[i].store(words[i], std::memory_order_release);
    }
    slot.stamp.store(stamp, std::memory_order_release);
    newest_.store(stamp, std::memory_order_release);
  }

  // Calls take(row) for each row since the last call, in order. Returns the number of rows that
  // were lost. Only one thread may call this function.
  template <typename Take>
  std::uint64_t read(const Take& take) {
    const std::uint64_t newest = newest_.load(std::memory_order_acquire);
    std::uint64_t lost = 0;
    if (newest - read_ > kRows) {
      lost = newest - read_ - kRows;
      read_ += lost;
    }
    while (read_ < newest) {
      Row row;
      if (copy(++read_, row)) {
        take(row);
      } else {
        ++lost;
      }
    }
    return lost;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(Row) + 7) / 8;
  struct Slot {
    std::atomic<std::uint64_t> stamp{0};
    std::array<std::atomic<std::uint64_t>, kWords> words{};
  };

  bool copy(std::uint64_t stamp, Row& row) const noexcept {
    const Slot& slot = (*slots_)[stamp % kRows];
    if (slot.stamp.load(std::memory_order_acquire) != stamp) return false;
    std::array<std::uint64_t, kWords> words;
    for (std::size_t i = 0; i < kWords; ++i) {
      words[i] = slot.words[i].load(std::memory_order_acquire);
    }
    if (slot.stamp.load(std::memory_order_relaxed) != stamp) return false;
    std::memcpy(static_cast<void*>(&row), words.data(), sizeof(Row));
    return true;
  }

  std::unique_ptr<std::array<Slot, kRows>> slots_;
  std::atomic<std::uint64_t> newest_{0};
  std::uint64_t added_ = 0;  // used by the writer only
  std::uint64_t read_ = 0;   // used by the reader only
};

}  // namespace palpate
