#include "engine/session/run_summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/base/degrees.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kFeasibleAngleRad = 30.0 / kDegreesPerRad;  // Barbagli & Salisbury 2003

}  // namespace

StepTimes StepTimes::of(std::vector<std::int64_t> steps_ns) {
  if (steps_ns.empty()) return {};
  std::sort(steps_ns.begin(), steps_ns.end());
  const auto percentile = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(steps_ns.size()));
    return steps_ns[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  };
  return {percentile(0.5), percentile(0.99), percentile(0.999), steps_ns.back(), steps_ns.size()};
}

void SummaryAccumulator::add(const TickRecord& record) noexcept {
  ++sums_.ticks;
  for (int bit = 0; bit < kFaultCount; ++bit) {
    sums_.faults[static_cast<std::size_t>(bit)] += record.faults >> bit & 1u;
  }
  for (int bit = 0; bit < kGovernorRuleCount; ++bit) {
    sums_.governor_rules[static_cast<std::size_t>(bit)] += record.rules >> bit & 1u;
  }
  if (was_in_contact_ && !record.contact) ++sums_.losses_of_contact;
  was_in_contact_ = record.contact != 0;
  gap_ticks_ = record.contact ? 0 : gap_ticks_ + 1;
  if (sums_.contact_ticks > 0) {
    sums_.longest_gap_ticks = std::max(sums_.longest_gap_ticks, gap_ticks_);
  }
  add_work(record);
  if (record.rotation_rad > 0.0) ++sums_.a4_ticks;
  if (!record.contact) return;
  ++sums_.contact_ticks;
  const double penetration_m = (vec3(record.proxy_scene_m) - vec3(record.goal_scene_m)).norm();
  penetration_sum_m_ += penetration_m;
  sums_.max_penetration_m = std::max(sums_.max_penetration_m, penetration_m);
  angle_sum_rad_ += record.alpha_rad;
  if (record.alpha_rad <= kFeasibleAngleRad) ++within_30deg_;
}

void SummaryAccumulator::add(const GovernorTrip& trip) noexcept {
  ++sums_.trips;
  sums_.last_trip = trip;
}

void SummaryAccumulator::add_work(const TickRecord& record) noexcept {
  if (record.faults & kFaultsWithoutSample) {
    last_force_N_.setZero();
    last_full_force_N_.setZero();
    return;
  }
  if (!has_position_) lowest_m_ = highest_m_ = last_device_m_ = vec3(record.device_m);
  has_position_ = true;
  lowest_m_ = lowest_m_.cwiseMin(vec3(record.device_m));
  highest_m_ = highest_m_.cwiseMax(vec3(record.device_m));
  const Vec3 moved_m = vec3(record.device_m) - last_device_m_;
  sums_.work_lost_J += (last_full_force_N_ - last_force_N_).dot(moved_m);
  sums_.port_work_J += last_force_N_.dot(moved_m);
  last_device_m_ = vec3(record.device_m);
  last_force_N_ = vec3(record.force_device_N);
  last_full_force_N_ = vec3(record.full_force_device_N);
}

RunSummary SummaryAccumulator::finish(std::vector<std::int64_t> steps_ns) const {
  RunSummary summary = sums_;
  if (summary.contact_ticks > 0) {
    const auto contact_ticks = static_cast<double>(summary.contact_ticks);
    summary.mean_penetration_m = penetration_sum_m_ / contact_ticks;
    summary.mean_contact_angle_deg = angle_sum_rad_ / contact_ticks * kDegreesPerRad;
    summary.share_within_30deg = static_cast<double>(within_30deg_) / contact_ticks;
  }
  summary.device_extent_m = highest_m_ - lowest_m_;
  summary.step_ns = StepTimes::of(std::move(steps_ns));
  return summary;
}

std::vector<std::int64_t> steps_of(const std::vector<TickRecord>& records) {
  std::vector<std::int64_t> steps_ns(records.size());
  std::transform(records.begin(), records.end(), steps_ns.begin(),
                 [](const TickRecord& record) { return record.step_ns; });
  return steps_ns;
}

void take_effects(const HapticLoop& loop, bool has_times, const std::vector<std::int64_t>& steps_ns,
                  RunSummary& summary) {
  const EffectCounters* counters = loop.effect_counters();
  if (!counters) return;
  summary.effect_ticks = counters->ticks;
  if (!has_times) return;
  auto& shares = summary.effect_time_shares.emplace();
  const auto all_ns = std::accumulate(steps_ns.begin(), steps_ns.end(), std::int64_t{0});
  if (all_ns <= 0) return;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    shares[i] = static_cast<double>(counters->time_ns[i]) / static_cast<double>(all_ns);
  }
}

}  // namespace palpate
