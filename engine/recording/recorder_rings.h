#pragma once

// The rings through which the haptic thread hands ticks and events to the thread of a recorder.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "engine/recording/block_codec.h"
#include "engine/recording/recorded_tick.h"
#include "engine/session/tick_sink.h"

namespace palpate {

// Rows of ticks and the bytes of their inputs. One thread adds, another one takes. A tick appears
// to the taker as a whole, with all its inputs, or not at all. All memory is allocated and touched
// by the constructor.
class RecorderRing {
 public:
  RecorderRing(std::size_t rows, std::size_t input_bytes)
      : slots_(std::max<std::size_t>(rows, 1)), input_bytes_(input_bytes) {}

  // Adds an input of the tick that add_tick() will end. False if there is no space.
  bool add_input(const TickInput& input) noexcept {
    const InputHeader header{0, static_cast<std::uint16_t>(input.kind),
                             static_cast<std::uint16_t>(input.bytes.size()), input.handle};
    const std::size_t bytes = sizeof header + input.bytes.size();
    const std::uint64_t end = next_input_ + staged_ + bytes;
    if (end - taken_inputs_.load(std::memory_order_acquire) > input_bytes_.size()) return false;
    put(std::as_bytes(std::span(&header, 1)));
    put(input.bytes);
    return true;
  }
  // Ends a tick. False if there is no space; the tick's inputs wait for another call.
  bool add_tick(const TickRecord& record, const TickReading& reading) noexcept {
    const std::uint64_t next = added_.load(std::memory_order_relaxed);
    if (next - taken_.load(std::memory_order_acquire) >= slots_.size()) return false;
    Slot& slot = slots_[next_slot_];
    copy_by_words(record, slot.row.record);
    slot.row.reading = reading;
    slot.input_bytes = staged_;
    next_input_ += staged_;
    staged_ = 0;
    added_.store(next + 1, std::memory_order_release);
    if (++next_slot_ == slots_.size()) next_slot_ = 0;
    fetch_next_slot();
    return true;
  }
  // Forgets the inputs of a tick that is dropped.
  void forget_inputs() noexcept { staged_ = 0; }
  bool has_staged_inputs() const noexcept { return staged_ > 0; }

  // On the taking thread: how many ticks can be taken.
  std::size_t ticks() const noexcept {
    return added_.load(std::memory_order_acquire) - taken_.load(std::memory_order_relaxed);
  }
  // The oldest tick. Requires ticks() > 0.
  const RecordedTick& front() const noexcept { return front_slot().row; }
  std::size_t front_input_bytes() const noexcept { return front_slot().input_bytes; }
  // Takes the oldest tick: appends its inputs, with `row` in their headers.
  void take(std::uint32_t row, std::vector<std::byte>& inputs) {
    const std::size_t begin = inputs.size();
    const std::size_t bytes = front_input_bytes();
    inputs.resize(begin + bytes);
    const std::uint64_t at = taken_inputs_.load(std::memory_order_relaxed);
    get(at, std::span(inputs).subspan(begin));
    for (std::size_t i = begin; i < inputs.size();) {
      InputHeader header;
      std::memcpy(&header, &inputs[i], sizeof header);
      header.row = row;
      std::memcpy(&inputs[i], &header, sizeof header);
      i += sizeof header + header.bytes;
    }
    taken_inputs_.store(at + bytes, std::memory_order_release);
    taken_.store(taken_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

 private:
  struct Slot {
    RecordedTick row;
    std::size_t input_bytes = 0;
  };

  const Slot& front_slot() const noexcept {
    return slots_[taken_.load(std::memory_order_relaxed) % slots_.size()];
  }
  // GCC copies a record by `rep movs`, which takes longer to start than this takes in all.
  static void copy_by_words(const TickRecord& from, TickRecord& to) noexcept {
    using Word = std::array<char, 16>;
    static_assert(sizeof(TickRecord) % sizeof(Word) == 0);
    const auto* source = reinterpret_cast<const char*>(&from);
    auto* target = reinterpret_cast<char*>(&to);
#pragma GCC unroll 32
    for (std::size_t at = 0; at < sizeof(TickRecord); at += sizeof(Word)) {
      Word word;
      std::memcpy(word.data(), source + at, sizeof word);
      std::memcpy(target + at, word.data(), sizeof word);
    }
  }
  // The ring is longer than the caches: the next tick finds its slot there all the same.
  void fetch_next_slot() const noexcept {
    constexpr std::size_t kLine = 64;
    const auto* line = reinterpret_cast<const char*>(&slots_[next_slot_]);
    for (std::size_t at = 0; at < sizeof(Slot); at += kLine) __builtin_prefetch(line + at, 1);
  }
  void put(std::span<const std::byte> bytes) noexcept {
    if (bytes.empty()) return;
    const std::size_t at = (next_input_ + staged_) % input_bytes_.size();
    const std::size_t first = std::min(bytes.size(), input_bytes_.size() - at);
    std::memcpy(input_bytes_.data() + at, bytes.data(), first);
    std::memcpy(input_bytes_.data(), bytes.data() + first, bytes.size() - first);
    staged_ += bytes.size();
  }
  void get(std::uint64_t from, std::span<std::byte> bytes) const noexcept {
    if (bytes.empty()) return;
    const std::size_t at = from % input_bytes_.size();
    const std::size_t first = std::min(bytes.size(), input_bytes_.size() - at);
    std::memcpy(bytes.data(), input_bytes_.data() + at, first);
    std::memcpy(bytes.data() + first, input_bytes_.data(), bytes.size() - first);
  }

  std::vector<Slot> slots_;
  std::vector<std::byte> input_bytes_;
  // Of the adding thread.
  std::size_t next_slot_ = 0;     // where the next tick goes
  std::uint64_t next_input_ = 0;  // where the inputs of this tick begin
  std::size_t staged_ = 0;        // bytes of the inputs of this tick
  alignas(64) std::atomic<std::uint64_t> added_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> taken_inputs_{0};
};

// The kinds of events.
enum class EventKind : std::uint8_t { kTrip, kLate };

// Something that happened in a tick, for the table of events. Plain numbers.
struct RecordedEvent {
  EventKind kind = EventKind::kTrip;
  LateCause cause = LateCause::kOurs;
  std::uint64_t tick = 0;
  double time_s = 0.0;
  GovernorTrip trip;         // of kTrip
  std::int64_t late_ns = 0;  // of kLate: how long after its due time the tick ended
};

// Events. One thread adds, another one takes. An event without space is counted.
class EventRing {
 public:
  static constexpr std::size_t kEvents = 1024;

  void add(const RecordedEvent& event) noexcept {
    const std::uint64_t next = added_.load(std::memory_order_relaxed);
    if (next - taken_.load(std::memory_order_acquire) >= kEvents) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    events_[next % kEvents] = event;
    added_.store(next + 1, std::memory_order_release);
  }
  bool take(RecordedEvent& event) noexcept {
    const std::uint64_t next = taken_.load(std::memory_order_relaxed);
    if (next == added_.load(std::memory_order_acquire)) return false;
    event = events_[next % kEvents];
    taken_.store(next + 1, std::memory_order_release);
    return true;
  }
  // How many events found no space since the last call.
  std::uint64_t take_lost() noexcept { return lost_.exchange(0, std::memory_order_relaxed); }

 private:
  std::array<RecordedEvent, kEvents> events_{};
  std::atomic<std::uint64_t> added_{0};
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace palpate
