#include "engine/devices/stiffness_zones.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "engine/devices/coupling_dampers.h"

namespace palpate {

const char* name_of(StiffnessZone zone) {
  switch (zone) {
    case StiffnessZone::kStable:
      return "stable";
    case StiffnessZone::kControlled:
      return "calm only by the controller";
    case StiffnessZone::kRefused:
      break;
  }
  return "refused";
}

Result<StiffnessZones> stiffness_zones(const DeviceDescription& device,
                                       double coupling_damping_Ns_per_m, double period_s,
                                       const VelocitySettings& velocity) {
  StiffnessZones zones;
  zones.mechanics = assumed_mechanics(device);
  // Where samples are rarer than ticks, the newest sample is older by as much.
  const double between_s = device.rate_Hz > 0.0 ? 1.0 / device.rate_Hz - period_s : 0.0;
  zones.mechanics.delay.most_s += std::max(0.0, between_s);
  zones.period_s = period_s;
  zones.passive_N_per_m = zones.stable_N_per_m = std::numeric_limits<double>::infinity();
  double limit_N_per_m = zones.stable_N_per_m;
  zones.velocity_ticks = controller_velocity_ticks(period_s);
  DeviceMechanics tip = DeviceMechanics::of(device);
  tip.mass_kg = zones.mechanics.mass_kg;
  tip.damping_Ns_per_m = zones.mechanics.damping_Ns_per_m;
  zones.damping_Ns_per_m = largest_damping_Ns_per_m(tip.mass_kg, zones.mechanics.delay.most_s,
                                                    period_s, zones.velocity_ticks);
  const double rest = std::max(0.0, zones.damping_Ns_per_m - coupling_damping_Ns_per_m);
  const auto couplings = coupling_dampers(coupling_damping_Ns_per_m, velocity);
  // The longest delay is the worst one but for dampers that are near their own limit.
  for (const double delay_s : {zones.mechanics.delay.least_s, zones.mechanics.delay.most_s}) {
    const ServoTiming timing{period_s, delay_s, 1};
    const Result<StabilityLimits> limits = stability_limits(tip, coupling_damping_Ns_per_m, timing);
    if (!limits) return limits.error();
    zones.passive_N_per_m = std::min(zones.passive_N_per_m, limits->passive_N_per_m);
    for (std::vector<LoopDamper> dampers : couplings) {
      zones.stable_N_per_m =
          std::min(zones.stable_N_per_m, stable_stiffness_N_per_m(tip, dampers, timing));
      dampers.push_back({rest, zones.velocity_ticks});
      limit_N_per_m = std::min(limit_N_per_m, stable_stiffness_N_per_m(tip, dampers, timing));
    }
  }
  zones.calm_N_per_m = std::max(zones.stable_N_per_m, kCalmPart * limit_N_per_m);
  zones.auto_N_per_m = kAutoPart * zones.stable_N_per_m;
  return zones;
}

DeviceMechanics wall_mechanics(const DeviceDescription& device) {
  DeviceMechanics tip = DeviceMechanics::of(device);
  if (!device.moves_motors) return tip;
  const AssumedMechanics mechanics = assumed_mechanics(device);
  tip.mass_kg = mechanics.mass_kg;
  tip.damping_Ns_per_m = mechanics.damping_Ns_per_m;
  return tip;
}

double wall_delay_s(const DeviceDescription& device) {
  if (device.moves_motors) return assumed_mechanics(device).delay.most_s;
  return device.delay.most_s;
}

}  // namespace palpate
