#pragma once

// The messages whose answers have not come yet.

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

// A queue: answers carry no number, but they come in the order of their messages. An answer
// therefore belongs to the oldest message without one, and is at most as old as that message.
class HapiFlights {
 public:
  static constexpr std::size_t kMost = 8;
  struct Flight {
    std::int64_t sent_ns = 0;
    bool is_missed = false;  // counted as a missing answer
  };

  bool is_empty() const noexcept { return count_ == 0; }
  bool is_full() const noexcept { return count_ == kMost; }
  // Requires !is_full().
  void add(std::int64_t sent_ns) noexcept {
    flights_[(first_ + count_++) % kMost] = {sent_ns, false};
    is_newest_met_ = false;
  }
  // Removes the oldest message. Requires !is_empty().
  Flight take() noexcept {
    const Flight oldest = flights_[first_];
    first_ = (first_ + 1) % kMost;
    --count_;
    is_newest_met_ = true;
    return oldest;
  }
  void clear() noexcept { count_ = 0; }
  // Requires !is_empty().
  Flight& newest() noexcept { return flights_[(first_ + count_ - 1) % kMost]; }
  const Flight& newest() const noexcept { return flights_[(first_ + count_ - 1) % kMost]; }
  // An answer has come since the newest message was sent: its own one, or that of a message before.
  bool is_newest_met() const noexcept { return is_newest_met_; }

 private:
  std::array<Flight, kMost> flights_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool is_newest_met_ = false;
};

}  // namespace palpate
