#include "engine/session/reached_timing.h"

namespace palpate {

Result<ReachedTiming> reached_timing(const RunSetup& setup, const TickTimes& times) {
  constexpr double kShare = 0.999;
  ReachedTiming timing;
  timing.period_ns = times.period.percentile_ns(kShare);
  timing.delay_ns = times.delay.percentile_ns(kShare);
  const double longer_s = 1e-9 * static_cast<double>(timing.period_ns + 2 * timing.delay_ns);
  const auto limits =
      stability_limits(DeviceMechanics::of(setup.device), setup.haptics.coupling.damping_Ns_per_m,
                       {.period_s = longer_s});
  if (!limits) return limits.error();
  timing.limits = *limits;
  return timing;
}

}  // namespace palpate
