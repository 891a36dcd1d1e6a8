#include "engine/devices/hapi_delay.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/devices/monotonic_clock.h"

namespace palpate {
namespace {

// Times, sorted on demand.
class Times {
 public:
  void add(std::int64_t time_ns) { times_ns_[count_++] = time_ns; }
  bool is_empty() const { return count_ == 0; }
  // The time that this share of all times is below. Requires !is_empty().
  std::int64_t at_share(double share) {
    const auto end = times_ns_.begin() + static_cast<std::ptrdiff_t>(count_);
    std::sort(times_ns_.begin(), end);
    const double last = static_cast<double>(count_ - 1);
    return times_ns_[static_cast<std::size_t>(std::llround(share * last))];
  }

 private:
  std::array<std::int64_t, HapiDelay::kMost> times_ns_{};
  std::size_t count_ = 0;
};

}  // namespace

HapiLine HapiDelay::line() const noexcept {
  if (count_ < kFewest) return {};
  return {delay(), rate_Hz()};
}

DelayInterval HapiDelay::delay() const noexcept {
  const auto tick_ns = static_cast<std::int64_t>(kShareOfTick * static_cast<double>(period_ns_));
  Times earliest, latest, round_trips;
  for (std::size_t k = 0; k < count_; ++k) {
    const Exchange& sampled = exchanges_[k];
    round_trips.add(sampled.answered_ns - sampled.sent_ns);
    if (k + 1 == count_) break;
    const std::int64_t written_ns = exchanges_[k + 1].answered_ns + tick_ns;
    std::optional<std::int64_t> first_ns, due_ns, replaced_ns;
    for (std::size_t j = k + 1; j < count_; ++j) {
      const std::int64_t sent_ns = exchanges_[j].sent_ns;
      if (!first_ns && sent_ns > sampled.answered_ns) first_ns = sent_ns;
      if (sent_ns < written_ns + period_ns_) replaced_ns = sent_ns;
      if (sent_ns < written_ns) continue;
      due_ns = sent_ns;
      break;
    }
    if (!due_ns) break;  // the rest is not known
    earliest.add(*first_ns - sampled.sent_ns);
    // A message that is due within the period is also the last one, or one before it.
    latest.add(std::max(*first_ns, std::min(*due_ns, *replaced_ns)) - sampled.sent_ns);
  }
  if (earliest.is_empty()) return {};
  const std::int64_t unsure_ns = round_trips.at_share(1.0 - kRare) - round_trips.at_share(0.0);
  const double second = 1.0 / static_cast<double>(kSecond_ns);
  const auto seconds = [&](std::int64_t time_ns) {
    return std::clamp(second * static_cast<double>(time_ns), 0.0, kLongestDelay_s);
  };
  return {seconds(earliest.at_share(kRare) - unsure_ns),
          seconds(latest.at_share(1.0 - kRare) + unsure_ns)};
}

// The median of the intervals between messages, because a stall of the machine is not the line's.
// A rate of n messages is uncertain by one of them, and a rate within this is the one asked.
double HapiDelay::rate_Hz() const noexcept {
  Times intervals;
  for (std::size_t k = 1; k < count_; ++k) {
    intervals.add(exchanges_[k].sent_ns - exchanges_[k - 1].sent_ns);
  }
  const double interval_s =
      static_cast<double>(intervals.at_share(0.5)) / static_cast<double>(kSecond_ns);
  const double asked_Hz = static_cast<double>(kSecond_ns) / static_cast<double>(period_ns_);
  const double counted = static_cast<double>(count_);
  const bool reaches_all = interval_s * asked_Hz * (counted - 1.0) <= counted;
  return reaches_all ? asked_Hz : 1.0 / interval_s;
}

}  // namespace palpate
