#pragma once

// The summary of a run, accumulated tick by tick.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/haptic_loop.h"
#include "haptics/safety_governor.h"

namespace palpate {

// Percentiles of the durations of the loop's ticks, in nanoseconds, as the clock of this machine
// measured them, also where the ticks run in simulated time. All are 0 without a measured tick.
struct StepTimes {
  std::int64_t p50_ns = 0;
  std::int64_t p99_ns = 0;
  std::int64_t p999_ns = 0;
  std::int64_t max_ns = 0;
  std::size_t ticks = 0;  // that were measured

  static StepTimes of(std::vector<std::int64_t> steps_ns);
};

// Means, shares and the largest penetration are those of contact ticks; without a contact tick they
// do not exist, and the fields are 0 (has_contact()). The device holds a force until the next tick;
// therefore work is the force times the displacement that follows it. Ticks with an invalid sample
// add no work.
struct RunSummary {
  std::uint64_t ticks = 0;
  std::uint64_t contact_ticks = 0;
  double mean_penetration_m = 0.0;
  double max_penetration_m = 0.0;
  double mean_contact_angle_deg = 0.0;
  double share_within_30deg = 0.0;      // share of contact ticks; Barbagli & Salisbury's limit
  std::uint64_t losses_of_contact = 0;  // transitions from contact to no contact, not debounced
  std::uint64_t longest_gap_ticks = 0;  // longest interval without contact after the first contact
  double work_lost_J = 0.0;             // sum (f_full - f_commanded) . dx_device
  double port_work_J = 0.0;  // sum f_commanded . dx_device; > 0: the device did work on the hand
  std::array<std::uint64_t, kFaultCount> faults{};
  // The ticks in which each rule of the governor acted, indexed like kGovernorRuleNames.
  std::array<std::uint64_t, kGovernorRuleCount> governor_rules{};
  std::uint64_t trips = 0;
  GovernorTrip last_trip;      // of trips > 0
  std::uint64_t a4_ticks = 0;  // ticks in which A4 rotated the scene
  // Indexed like compiled_effects().
  std::array<std::uint64_t, kMostEffects> effect_ticks{};              // ticks with active effect
  std::optional<std::array<double, kMostEffects>> effect_time_shares;  // no value: not measured
  Vec3 device_extent_m = Vec3::Zero();  // of the device's positions along each axis
  StepTimes step_ns;

  bool has_contact() const { return contact_ticks > 0; }
  // The largest of the three extents, device frame.
  double device_travel_m() const { return device_extent_m.maxCoeff(); }
  // 0 for a run without ticks.
  double contact_share() const {
    return ticks > 0 ? static_cast<double>(contact_ticks) / static_cast<double>(ticks) : 0.0;
  }
};

// The time of each tick in nanoseconds, for SummaryAccumulator::finish().
std::vector<std::int64_t> steps_of(const std::vector<TickRecord>& records);

// Copies the effect counters of a loop into a summary: the number of ticks in which each effect was
// active and, if has_times, the share of each effect in the time of all ticks.
void take_effects(const HapticLoop& loop, bool has_times, const std::vector<std::int64_t>& steps_ns,
                  RunSummary& summary);

class SummaryAccumulator {
 public:
  // Does not allocate, so that the haptic thread may call it.
  void add(const TickRecord& record) noexcept;
  void add(const GovernorTrip& trip) noexcept;
  RunSummary finish(std::vector<std::int64_t> steps_ns) const;

 private:
  void add_work(const TickRecord& record) noexcept;

  RunSummary sums_;
  double penetration_sum_m_ = 0.0;
  double angle_sum_rad_ = 0.0;
  std::uint64_t within_30deg_ = 0;
  bool was_in_contact_ = false;
  std::uint64_t gap_ticks_ = 0;  // ticks since the last contact
  bool has_position_ = false;
  Vec3 last_device_m_ = Vec3::Zero();
  Vec3 last_force_N_ = Vec3::Zero();
  Vec3 last_full_force_N_ = Vec3::Zero();
  Vec3 lowest_m_ = Vec3::Zero();
  Vec3 highest_m_ = Vec3::Zero();
};

}  // namespace palpate
