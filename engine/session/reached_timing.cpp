#include "engine/session/reached_timing.h"

#include <algorithm>

#include "engine/devices/stiffness_zones.h"

namespace palpate {

Result<ReachedTiming> reached_timing(const RunSetup& setup, const TickTimes& times) {
  constexpr double kShare = 0.999;
  ReachedTiming timing;
  timing.period_ns = times.period.percentile_ns(kShare);
  timing.delay_ns = times.delay.percentile_ns(kShare);
  timing.to_force_s =
      std::max(wall_delay_s(setup.device), 1e-9 * static_cast<double>(timing.delay_ns));
  const auto limits =
      stability_limits(wall_mechanics(setup.device), setup.haptics.coupling.damping_Ns_per_m,
                       {1e-9 * static_cast<double>(timing.period_ns), timing.to_force_s});
  if (!limits) return limits.error();
  timing.limits = *limits;
  return timing;
}

}  // namespace palpate
