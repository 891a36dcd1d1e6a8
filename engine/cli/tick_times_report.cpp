#include "engine/cli/tick_times_report.h"

#include <cmath>
#include <string_view>

#include <nlohmann/json.hpp>

#include "engine/cli/formatted.h"
#include "engine/session/reached_timing.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

// "buckets": pairs of a bound and the number of times in the bucket below it; empty buckets are
// left out. The bound of the last bucket is null.
ordered_json histogram_json(const TimeHistogram& times) {
  ordered_json buckets = ordered_json::array();
  for (std::size_t i = 0; i < TimeHistogram::kBuckets; ++i) {
    if (times.in_bucket(i) == 0) continue;
    const bool is_last = i + 1 == TimeHistogram::kBuckets;
    ordered_json bucket = ordered_json::array();
    bucket.push_back(is_last ? ordered_json() : ordered_json(TimeHistogram::bound_ns(i)));
    bucket.push_back(times.in_bucket(i));
    buckets.push_back(std::move(bucket));
  }
  const auto or_null = [&](std::int64_t time_ns) {
    return times.count() > 0 ? ordered_json(time_ns) : ordered_json();
  };
  return {{"p50", or_null(times.percentile_ns(0.5))},
          {"p99", or_null(times.percentile_ns(0.99))},
          {"p999", or_null(times.percentile_ns(0.999))},
          {"max", or_null(times.largest_ns())},
          {"buckets", buckets}};
}

}  // namespace

ordered_json tick_times_json(const TickTimes& times) {
  ordered_json causes = ordered_json::object();
  for (std::size_t i = 0; i < kLateCauseNames.size(); ++i) {
    causes[std::string(kLateCauseNames[i])] = times.late_ticks[i];
  }
  const TickCost& longest = times.longest;
  ordered_json json = {{"late_ns", histogram_json(times.late)},
                       {"period_ns", histogram_json(times.period)},
                       {"wall_ns", histogram_json(times.wall)},
                       {"cpu_ns", histogram_json(times.cpu)},
                       {"step_ns", histogram_json(times.step)},
                       {"delay_ns", histogram_json(times.delay)},
                       {"late_ticks", causes},
                       {"longest_late_tick", nullptr},
                       {"page_faults", times.faults},
                       {"preemptions", times.preemptions}};
  if (times.all_late_ticks() > 0) {
    json["longest_late_tick"] = {
        {"cause", kLateCauseNames[static_cast<std::size_t>(cause_of(longest))]},
        {"late_ns", longest.late_ns},
        {"wall_ns", longest.wall_ns},
        {"step_ns", longest.loop_ns},
        {"cpu_ns", longest.cpu_ns}};
  }
  return json;
}

ordered_json reached_timing_json(const RunSetup& setup, const TickTimes& times) {
  if (times.period.count() == 0) return nullptr;
  const auto timing = reached_timing(setup, times);
  if (!timing) return nullptr;
  return {{"period_ns", timing->period_ns},
          {"delay_ns", timing->delay_ns},
          {"delay_to_force_ns", 1e9 * timing->to_force_s},
          {"passive_N_per_m", timing->limits.passive_N_per_m},
          {"stable_N_per_m", timing->limits.stable_N_per_m}};
}

std::string late_causes_text(const TickTimes& times) {
  std::string text;
  for (std::size_t i = 0; i < kLateCauseNames.size(); ++i) {
    const std::uint64_t ticks = times.late_ticks[i];
    if (ticks == 0) continue;
    text += (text.empty() ? " (" : ", ") + std::to_string(ticks) + " " +
            std::string(kLateCauseNames[i]);
  }
  return text.empty() ? text : text + ")";
}

std::string reached_timing_text(const RunSetup& setup, const TickTimes& times) {
  if (times.period.count() == 0) return {};
  const auto timing = reached_timing(setup, times);
  if (!timing) return {};
  const StabilityLimits& limits = timing->limits;
  // Rounded down, so that a wall of the stiffness that is printed is passive, or stable.
  const std::string passive =
      limits.allows_passive_walls()
          ? formatted("a wall is passive up to %.0f N/m", std::floor(limits.passive_N_per_m))
          : std::string("no wall is passive");
  const double delay_s = 1e-9 * static_cast<double>(timing->delay_ns);
  std::string text =
      formatted("at the period and the delay that 99.9 %% of the ticks kept (%.3f ms, %.1f us), ",
                1e-6 * static_cast<double>(timing->period_ns), 1e6 * delay_s);
  if (timing->to_force_s > delay_s) {
    text += formatted("and the %.1f ms from a sample to its force, ", 1e3 * timing->to_force_s);
  }
  return text + passive +
         (limits.stable_N_per_m > 0.0
              ? formatted(limits.allows_passive_walls() ? " and stable below %.0f N/m\n"
                                                        : "; one is stable below %.0f N/m\n",
                          std::floor(limits.stable_N_per_m))
              : std::string(", and none is stable\n"));
}

}  // namespace palpate
