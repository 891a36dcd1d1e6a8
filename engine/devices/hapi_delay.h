#pragma once

// The delay of a hAPI board and the rate of its line, from round trips at zero force.

#include <array>
#include <cstddef>
#include <cstdint>

#include "palpate/device.h"

namespace palpate {

// What the round trips show.
struct HapiLine {
  DelayInterval delay;  // from a sample to the torques that answer it; 0, 0: unknown
  double rate_Hz =
      0.0;  // messages per second that the line reaches, at most those asked; 0: unknown
};

// Collects the exchanges of a start. One thread owns an object. No function allocates or throws.
//
// What the host knows of exchange k: it wrote the message at s_k, and the answer came at a_k. The
// board read the message, set its torques and took the sample of the answer at one moment
// s_k + u_k, 0 <= u_k <= r_k = a_k - s_k. A tick that reads this sample runs from a_k until
// a_{k+1}, when a newer sample replaces it, and writes its force at most kShareOfTick periods
// later. The next message, j, carries the force, and the motors obey at s_j + u_j. The delay is
// therefore
//
//   s_j - s_k  +  u_j - u_k
//
// - j is at least the first message after a_k: a message that goes out while the answer is being
//   read still carries an older force.
// - j is at most the first message that is due when the latest of these ticks has written its
//   force. If messages are rarer than ticks, a newer tick takes its place; then j is at most the
//   last message before the next tick has written.
// - |u_j - u_k| <= the longest less the shortest round trip, if the shortest one had both the
//   shortest way to the board and the shortest way back.
//
// Both bounds of j come from the send times that were measured, so that the interval holds for any
// phase between the ticks and the messages. Exchanges that are rarer than kRare at either end do
// not count: a machine that stalls now and then is the governor's concern (late and stale samples).
class HapiDelay {
 public:
  static constexpr std::size_t kMost = 200;    // exchanges; later ones do not count
  static constexpr std::size_t kFewest = 20;   // fewer show nothing
  static constexpr double kRare = 1.0 / 20.0;  // the share of the exchanges left out at each end
  // The share of a period that the computation of a tick may take: that of the work budget.
  static constexpr double kShareOfTick = 0.5;

  // period_ns: of the messages, as asked. The ticks must not be longer; where they are, the delay
  // of a force that the link measures in the run (HapiCounts) shows it.
  explicit HapiDelay(std::int64_t period_ns) noexcept : period_ns_(period_ns) {}

  // In the order of the messages.
  void add(std::int64_t sent_ns, std::int64_t answered_ns) noexcept {
    if (count_ < kMost) exchanges_[count_++] = {sent_ns, answered_ns};
  }
  std::size_t count() const noexcept { return count_; }
  bool is_full() const noexcept { return count_ == kMost; }
  // Unknown with fewer than kFewest exchanges.
  HapiLine line() const noexcept;

 private:
  struct Exchange {
    std::int64_t sent_ns = 0;
    std::int64_t answered_ns = 0;
  };
  DelayInterval delay() const noexcept;
  double rate_Hz() const noexcept;

  std::int64_t period_ns_;
  std::array<Exchange, kMost> exchanges_{};
  std::size_t count_ = 0;
};

}  // namespace palpate
