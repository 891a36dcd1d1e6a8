#include "engine/live/trial_watch.h"

#include <algorithm>
#include <cmath>

namespace palpate {

TrialWatch::TrialWatch(const TrialClock* clock, double dt_s, double longest_lateness_s,
                       const Clutch* clutch)
    : clock_(clock),
      clutch_(clutch),
      lost_after_ticks_(static_cast<std::uint64_t>(std::llround(kLostAfter_s / dt_s))),
      longest_lateness_ns_(std::llround(longest_lateness_s * 1e9)),
      period_ns_(std::llround(dt_s * 1e9)) {}

void TrialWatch::end(TrialCut cut) noexcept {
  if (is_over_.load(std::memory_order_relaxed)) return;
  cut_.store(cut, std::memory_order_release);
  is_over_.store(true, std::memory_order_release);
}

void TrialWatch::on_trip(const GovernorTrip&) noexcept {
  has_tripped_ = true;
}

// A tick that begins after the next one was due takes its place: the periods between are left out.
void TrialWatch::judge_lateness(const TickRecord& record) noexcept {
  if (clock_ == nullptr || clock_->has_started()) {
    left_out_ns_ += record.late_ns / period_ns_ * period_ns_;
  }
  if (std::max(record.late_ns, left_out_ns_) > longest_lateness_ns_) end(TrialCut::kLateTick);
}

// Nothing is measured before the clock has started.
void TrialWatch::judge_lifts() noexcept {
  if (clutch_ == nullptr || clutch_->refused_lifts() == refused_lifts_) return;
  refused_lifts_ = clutch_->refused_lifts();
  if (clock_->has_started()) end(TrialCut::kLift);
}

void TrialWatch::on_tick(const TickRecord& record) noexcept {
  if (has_tripped_) {
    if ((record.rules & kRuleRelease) == 0) end(TrialCut::kTrip);
    return;
  }
  judge_lateness(record);
  if (clock_ == nullptr) return;
  if (clock_->is_over()) end(TrialCut::kNone);
  judge_lifts();
  if (!clock_->has_started() && record.contact == 0) return;
  if (clock_->is_on_way()) {
    ticks_off_ = 0;
    is_lost_.store(false, std::memory_order_release);
    return;
  }
  if (++ticks_off_ != lost_after_ticks_) return;
  along_m_.store(clock_->along_m(), std::memory_order_release);
  times_lost_.store(times_lost_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  is_lost_.store(true, std::memory_order_release);
}

}  // namespace palpate
