#include "engine/cli/run_stiffness.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/printable.h"
#include "haptics/safety_governor.h"

namespace palpate {
namespace {

// Rounded down, so that a wall of the stiffness that is printed is in the zone.
std::string rounded_down(double stiffness_N_per_m) {
  std::ostringstream text;
  text << std::floor(stiffness_N_per_m) << " N/m";
  return text.str();
}

// Further beyond its zones.
bool is_worse(const JudgedStiffness& a, const JudgedStiffness& b) {
  if (a.zone() != b.zone()) return a.zone() > b.zone();
  return a.stiffness_N_per_m * b.zones.calm_N_per_m > b.stiffness_N_per_m * a.zones.calm_N_per_m;
}

std::string delay_text(const DelayInterval& delay) {
  std::ostringstream text;
  if (delay.least_s == delay.most_s) {
    text << 1e3 * delay.most_s << " ms";
  } else {
    text << 1e3 * delay.least_s << " to " << 1e3 * delay.most_s << " ms";
  }
  return text.str();
}

Error no_stable_wall(const StiffnessZones& zones, const CouplingSettings& loop) {
  const double fitting =
      largest_damping_Ns_per_m(zones.mechanics.mass_kg, zones.mechanics.delay.most_s,
                               zones.period_s, loop.velocity.window_ticks);
  std::ostringstream problem;
  problem << "is " << loop.damping_Ns_per_m << " N s/m, with which no wall is stable at a delay of "
          << delay_text(zones.mechanics.delay) << "; expected at most " << fitting << " N s/m";
  return invalid_argument("coupling.damping_Ns_per_m", problem.str());
}

Error too_stiff(const WorstSurface& worst) {
  return invalid_argument(
      worst.is_of_loop ? "coupling.stiffness_N_per_m"
                       : "material \"" + worst.judged.surface + "\": stiffness",
      too_stiff_text(worst),
      "use --stiffness auto or a softer material; --allow-unstable \"REASON\" runs it all the "
      "same");
}

}  // namespace

// In a relief, a surface is stiffest where the hand presses deepest: at the peak force F, which it
// reaches at the depth F / K.
double stiffest_N_per_m(const SurfaceCoupling& surface, double peak_force_N) {
  const double stiffness_N_per_m = surface.coupling.stiffness_N_per_m;
  if (stiffness_N_per_m <= 0.0 || surface.relief_per_m == 0.0) return stiffness_N_per_m;
  return surface.effective_stiffness_N_per_m(peak_force_N / stiffness_N_per_m);
}

double WorstSurface::fitting_N_per_m() const {
  return std::max(0.0, judged.zones.calm_N_per_m - relief_N_per_m);
}

std::string too_stiff_text(const WorstSurface& worst) {
  std::ostringstream problem;
  problem << "is " << worst.judged.stiffness_N_per_m << " N/m";
  if (worst.relief_N_per_m > 0.0) problem << " with its relief, at the peak force";
  problem << "; expected at most " << rounded_down(worst.fitting_N_per_m())
          << ": no damping that the delay of " << delay_text(worst.judged.zones.mechanics.delay)
          << " permits brings the device to rest";
  return problem.str();
}

Result<WorstSurface> worst_surface(const std::vector<SurfaceCoupling>& couplings,
                                   const JudgedLoop& loop) {
  WorstSurface worst;
  std::map<double, StiffnessZones> zones_of;  // by the damping; all surfaces share the velocity
  for (const SurfaceCoupling& surface : couplings) {
    const CouplingSettings& own = surface.coupling;
    auto zones = zones_of.find(own.damping_Ns_per_m);
    if (zones == zones_of.end()) {
      const auto found =
          stiffness_zones(loop.device, own.damping_Ns_per_m, loop.period_s, own.velocity);
      if (!found) return found.error();
      zones = zones_of.emplace(own.damping_Ns_per_m, *found).first;
    }
    JudgedStiffness judged{surface.name, stiffest_N_per_m(surface, loop.peak_force_N),
                           zones->second};
    const bool is_first = &surface == &couplings.front();
    if (!is_first && !is_worse(judged, worst.judged)) continue;
    worst.relief_N_per_m = judged.stiffness_N_per_m - own.stiffness_N_per_m;
    worst.is_of_loop = is_first;
    worst.judged = std::move(judged);
  }
  return worst;
}

Result<std::optional<RunStiffness>> choose_stiffness(const RunRequest& request,
                                                     const GuardableDevice& opened,
                                                     PreparedRun& prepared) {
  RunSetup& setup = prepared.setup;
  const DeviceDescription& device = opened.description();
  const LineRate line = opened.line_rate();
  if (auto error = check_least_rates(device, line, 1.0 / setup.dt_s)) return *error;
  setup.device.delay = device.delay;
  if (!pushes(device)) return std::optional<RunStiffness>();
  double period_s = setup.dt_s;
  if (line.at_start_Hz > 0.0) period_s = std::max(period_s, 1.0 / line.at_start_Hz);
  CouplingSettings& loop = setup.haptics.coupling;
  const auto zones = stiffness_zones(device, loop.damping_Ns_per_m, period_s, loop.velocity);
  if (!zones) return zones.error();
  if (request.options.has_auto_stiffness) {
    if (zones->auto_N_per_m <= 0.0) return no_stable_wall(*zones, loop);
    loop.stiffness_N_per_m = zones->auto_N_per_m;
  }
  RunStiffness chosen;
  chosen.stiffness_N_per_m = loop.stiffness_N_per_m;
  chosen.is_auto = request.options.has_auto_stiffness;
  chosen.has_measured_delay = !zones->mechanics.assumes_delay;
  chosen.zones = *zones;
  chosen.allowed = request.device.allow_unstable.value_or("");
  chosen.peak_force_N = SafetyGovernor::clamp_of(device, setup.max_force_N);
  auto worst =
      worst_surface(couplings_of(prepared.scene, loop), {device, period_s, chosen.peak_force_N});
  if (!worst) return worst.error();
  if (worst->judged.zone() == StiffnessZone::kRefused && chosen.allowed.empty()) {
    return too_stiff(*worst);
  }
  chosen.worst = std::move(worst->judged);
  return std::optional(std::move(chosen));
}

std::string mechanics_text(const AssumedMechanics& mechanics) {
  std::ostringstream text;
  const auto assumed = [](bool is_assumed) {
    return is_assumed ? std::string(" (assumed, of a ") + kBareTip.name + ")" : std::string();
  };
  text << "mass " << mechanics.mass_kg << " kg" << assumed(mechanics.assumes_mass) << ", damping "
       << mechanics.damping_Ns_per_m << " N s/m" << assumed(mechanics.assumes_damping)
       << ", delay from a sample to its force " << delay_text(mechanics.delay)
       << assumed(mechanics.assumes_delay);
  return text.str();
}

std::string limits_text(const StiffnessZones& zones) {
  const std::string passive = zones.passive_N_per_m > 0.0
                                  ? "a wall is passive up to " + rounded_down(zones.passive_N_per_m)
                                  : "no wall is passive";
  if (zones.stable_N_per_m <= 0.0) return passive + ", and none is stable";
  return passive + (zones.passive_N_per_m > 0.0 ? ", stable below " : "; one is stable below ") +
         rounded_down(zones.stable_N_per_m) + ", and calm by the controller up to " +
         rounded_down(zones.calm_N_per_m);
}

std::string zone_text(StiffnessZone zone, const std::string& allowed) {
  switch (zone) {
    case StiffnessZone::kStable:
      return "stable";
    case StiffnessZone::kControlled:
      return "calm only by the controller, which damps the motion";
    case StiffnessZone::kRefused:
      break;
  }
  return "unstable, and allowed, because: " + printable(allowed);
}

std::string stiffness_text(const RunStiffness& stiffness) {
  std::ostringstream text;
  text << "the device: " << mechanics_text(stiffness.zones.mechanics) << "\n";
  text << "at " << 1e3 * stiffness.zones.mechanics.delay.most_s << " ms and a period of "
       << 1e3 * stiffness.zones.period_s << " ms, " << limits_text(stiffness.zones) << "\n";
  text << "stiffness " << stiffness.stiffness_N_per_m << " N/m";
  if (stiffness.is_auto) text << " (auto: " << kAutoPart << " of the stable limit)";
  const JudgedStiffness& worst = stiffness.worst;
  if (worst.stiffness_N_per_m != stiffness.stiffness_N_per_m) {
    text << "; the stiffest surface, \"" << printable(worst.surface) << "\", has "
         << worst.stiffness_N_per_m << " N/m";
  }
  text << ": " << zone_text(worst.zone(), stiffness.allowed) << "\n";
  return text.str();
}

void tell_stiffness(const RunStiffness& stiffness) {
  std::istringstream lines(stiffness_text(stiffness));
  for (std::string line; std::getline(lines, line);) std::cerr << "palpate: " << line << "\n";
  std::cerr << std::flush;
}

nlohmann::ordered_json stiffness_json(const RunStiffness& stiffness) {
  const StiffnessZones& zones = stiffness.zones;
  const AssumedMechanics& mechanics = zones.mechanics;
  const auto assumed = [](bool is_assumed) {
    return is_assumed ? nlohmann::ordered_json(kBareTip.name) : nlohmann::ordered_json();
  };
  return {{"stiffness_N_per_m", stiffness.stiffness_N_per_m},
          {"auto", stiffness.is_auto},
          {"zone", name_of(stiffness.worst.zone())},
          {"stiffest_surface", stiffness.worst.surface},
          {"stiffest_N_per_m", stiffness.worst.stiffness_N_per_m},
          {"allow_unstable", stiffness.allowed.empty() ? nlohmann::ordered_json()
                                                       : nlohmann::ordered_json(stiffness.allowed)},
          {"passive_N_per_m", zones.passive_N_per_m},
          {"stable_N_per_m", zones.stable_N_per_m},
          {"calm_N_per_m", zones.calm_N_per_m},
          {"controller_damping_Ns_per_m", zones.damping_Ns_per_m},
          {"period_s", zones.period_s},
          {"delay_s", {mechanics.delay.least_s, mechanics.delay.most_s}},
          {"mass_kg", mechanics.mass_kg},
          {"damping_Ns_per_m", mechanics.damping_Ns_per_m},
          {"assumed",
           {{"delay_of", assumed(mechanics.assumes_delay)},
            {"mass_of", assumed(mechanics.assumes_mass)},
            {"damping_of", assumed(mechanics.assumes_damping)}}}};
}

}  // namespace palpate
