#include "engine/accuracy/stiffness_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include "engine/devices/coupling_dampers.h"
#include "engine/report/csv.h"
#include "engine/report/human_units.h"
#include "engine/simulation/port_loop.h"

namespace palpate {
namespace {

constexpr std::array kChartRates_Hz = {250.0, 1000.0, 4000.0, 10'000.0};
// A delay of 0 is an unknown one in a description. This one is none for any loop.
constexpr double kNoDelay_s = 1e-9;

std::array<double, kChartRates_Hz.size()> rates_with(double own_Hz) {
  auto rates_Hz = kChartRates_Hz;
  const auto is_nearer = [own_Hz](double a_Hz, double b_Hz) {
    return std::abs(std::log(a_Hz / own_Hz)) < std::abs(std::log(b_Hz / own_Hz));
  };
  *std::min_element(rates_Hz.begin(), rates_Hz.end(), is_nearer) = own_Hz;
  return rates_Hz;
}

// The zones of the adaptive method are those of its worst window, which is nearly always the
// longest. The chart takes that for all its points, which is sixty times as fast.
VelocitySettings charted(VelocitySettings velocity) {
  if (velocity.method == VelocityMethod::kAdaptive) velocity.method = VelocityMethod::kDifference;
  return velocity;
}

Result<ChartedLimits> limits_at(DeviceDescription device, const CouplingSettings& coupling,
                                double rate_Hz, double delay_s) {
  const double damping_Ns_per_m = coupling.damping_Ns_per_m;
  const double stated_s = std::max(delay_s, kNoDelay_s);
  device.delay = {stated_s, stated_s};
  device.rate_Hz = rate_Hz;
  ChartedLimits limits;
  limits.delay_s = delay_s;
  const auto zones =
      stiffness_zones(device, damping_Ns_per_m, 1.0 / rate_Hz, charted(coupling.velocity));
  if (!zones) return zones.error();
  limits.zones = *zones;
  DeviceMechanics held = DeviceMechanics::of(device);
  held.mass_kg = zones->mechanics.mass_kg;
  held.damping_Ns_per_m = zones->mechanics.damping_Ns_per_m;
  // Not adaptive: one entry.
  const std::vector<LoopDamper> dampers =
      coupling_dampers(damping_Ns_per_m, charted(coupling.velocity)).front();
  const ServoTiming timing{1.0 / rate_Hz, delay_s};
  held.hand = kLightGrip;
  limits.light_N_per_m = stable_stiffness_N_per_m(held, dampers, timing);
  held.hand = kFirmGrip;
  limits.firm_N_per_m = stable_stiffness_N_per_m(held, dampers, timing);
  return limits;
}

std::string whole_N_per_m(double stiffness_N_per_m) {
  std::ostringstream text;
  text << std::floor(stiffness_N_per_m) << " N/m";
  return text.str();
}

}  // namespace

Result<StiffnessChart> stiffness_chart(const DeviceDescription& device,
                                       const CouplingSettings& coupling, double rate_Hz) {
  const double damping = coupling.damping_Ns_per_m;
  StiffnessChart chart;
  chart.stiffness_N_per_m = coupling.stiffness_N_per_m;
  chart.rate_Hz = rate_Hz;
  const auto own = stiffness_zones(device, damping, 1.0 / rate_Hz, coupling.velocity);
  if (!own) return own.error();
  chart.own = *own;
  for (const double charted_Hz : rates_with(rate_Hz)) {
    ChartedRate rate{charted_Hz, {}};
    constexpr int kDelays = StiffnessChartRange::kDelays;
    for (int n = 0; n < kDelays; ++n) {
      const double delay_s = StiffnessChartRange::kLongestDelay_s * n / (kDelays - 1);
      const auto limits = limits_at(device, coupling, charted_Hz, delay_s);
      if (!limits) return limits.error();
      rate.limits.push_back(*limits);
    }
    chart.rates.push_back(std::move(rate));
  }
  return chart;
}

std::string assumed_text(const AssumedMechanics& mechanics) {
  const auto assumed = [](bool is_assumed) {
    return is_assumed ? std::string(" (assumed, of a ") + kBareTip.name + ")" : std::string();
  };
  return "mass " + human(mechanics.mass_kg, "kg") + assumed(mechanics.assumes_mass) + ", damping " +
         human(mechanics.damping_Ns_per_m, "N s/m") + assumed(mechanics.assumes_damping) +
         ", delay at most " + human(mechanics.delay.most_s, "s") + assumed(mechanics.assumes_delay);
}

std::string zone_text(double stiffness_N_per_m, const StiffnessZones& zones) {
  const std::string is =
      "K " + human(stiffness_N_per_m, "N/m") + " is " + name_of(zones.zone_of(stiffness_N_per_m));
  if (zones.stable_N_per_m <= 0.0) return is + "; no wall with this damper is stable";
  return is + "; stable below " + whole_N_per_m(zones.stable_N_per_m) +
         ", calm by the controller up to " + whole_N_per_m(zones.calm_N_per_m);
}

std::string stiffness_chart_csv(const StiffnessChart& chart) {
  CsvLines csv(
      "rate_Hz,delay_s,passive_N_per_m,stable_N_per_m,calm_N_per_m,stable_light_grip_N_per_m,"
      "stable_firm_grip_N_per_m,controller_damping_Ns_per_m");
  for (const ChartedRate& rate : chart.rates) {
    for (const ChartedLimits& at : rate.limits) {
      csv.add(rate.rate_Hz).add(at.delay_s).add(at.zones.passive_N_per_m);
      csv.add(at.zones.stable_N_per_m).add(at.zones.calm_N_per_m);
      csv.add(at.light_N_per_m).add(at.firm_N_per_m).add(at.zones.damping_Ns_per_m).end_line();
    }
  }
  return csv.text();
}

}  // namespace palpate
