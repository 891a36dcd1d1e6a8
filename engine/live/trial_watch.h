#pragma once

// Watches a trial of a person: when it is over, and when the person has lost the way.

#include <atomic>
#include <cstdint>

#include "engine/live/clutch.h"
#include "engine/session/haptic_session.h"
#include "engine/trials/trial_clock.h"

namespace palpate {

// A trial of a person ends by itself for these reasons, besides those of its clock.
enum class TrialCut : std::uint8_t { kNone, kLateTick, kTrip, kLift };

// A trip ends the trial once the governor's rule *release* has let go of the hand: a session that
// stopped at once would drop it. Behind the clock in the list of observers. on_tick() runs on the
// haptic thread; any thread may call the const functions.
class TrialWatch final : public TickObserver {
 public:
  // A person who is lost needs to know after this time without a contact on the way. The clock
  // moves its place at most ContourPlace::kReach_m ahead, and otherwise would wait for the time
  // limit.
  static constexpr double kLostAfter_s = 1.0;

  // clock: must outlive this object; null: there is none, and nobody gets lost.
  // longest_lateness_s: a tick that begins later ends the trial, and so do ticks that together have
  // left out more time since the start of the clock: the clock counts ticks.
  // clutch: of the hand, must outlive this object; null: there is none. A lift that it refuses ends
  // the trial, once the clock has started.
  TrialWatch(const TrialClock* clock, double dt_s, double longest_lateness_s,
             const Clutch* clutch = nullptr);

  void on_tick(const TickRecord& record) noexcept override;
  void on_trip(const GovernorTrip& trip) noexcept override;

  bool is_over() const noexcept { return is_over_.load(std::memory_order_acquire); }
  TrialCut cut() const noexcept { return cut_.load(std::memory_order_acquire); }
  // The person should return to along_m() on the way: before the start of the clock, to the green
  // sphere, if they touch the object elsewhere.
  bool is_lost() const noexcept { return is_lost_.load(std::memory_order_acquire); }
  double along_m() const noexcept { return along_m_.load(std::memory_order_acquire); }
  std::uint32_t times_lost() const noexcept { return times_lost_.load(std::memory_order_acquire); }

 private:
  void end(TrialCut cut) noexcept;
  void judge_lateness(const TickRecord& record) noexcept;

  void judge_lifts() noexcept;

  const TrialClock* clock_;
  const Clutch* clutch_;
  std::uint64_t refused_lifts_ = 0;  // that were judged
  bool has_tripped_ = false;
  std::uint64_t lost_after_ticks_;
  std::int64_t longest_lateness_ns_;
  std::int64_t period_ns_;
  std::int64_t left_out_ns_ = 0;  // by ticks that began after the next one was due
  std::uint64_t ticks_off_ =
      0;  // since the last contact on the way, or in contact before the start
  std::atomic<bool> is_over_{false};
  std::atomic<TrialCut> cut_{TrialCut::kNone};
  std::atomic<bool> is_lost_{false};
  std::atomic<double> along_m_{0.0};
  std::atomic<std::uint32_t> times_lost_{0};
};

}  // namespace palpate
