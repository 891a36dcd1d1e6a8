#pragma once

// The chart of the stiffness: at which stiffness, delay and rate a wall on a device with motors is
// stable, calm only by the controller, or refused.

#include <string>
#include <vector>

#include "engine/devices/stiffness_zones.h"
#include "geometry/base/result.h"
#include "haptics/effects/virtual_coupling.h"
#include "palpate/device.h"

namespace palpate {

// What the chart covers.
struct StiffnessChartRange {
  static constexpr double kLeast_N_per_m = 100.0, kMost_N_per_m = 20'000.0;
  static constexpr double kLongestDelay_s = 5e-3;
  static constexpr int kDelays = 51;  // from 0 on, equally far apart
};

// The limits of a wall, and of a groove: the walls of a groove push with K along each of its two
// directions, so that each of them is the loop of a wall. N/m.
struct ChartedLimits {
  double delay_s = 0.0;
  StiffnessZones zones;        // of a tip that nobody holds, which decide
  double light_N_per_m = 0.0;  // below it, a tip in a light grip is stable
  double firm_N_per_m = 0.0;   // the same for a firm grip
};

struct ChartedRate {
  double rate_Hz = 0.0;
  std::vector<ChartedLimits> limits;  // at increasing delays
};

struct StiffnessChart {
  // The coupling on the device, at its rate and the longest end of its delay.
  double stiffness_N_per_m = 0.0;
  double rate_Hz = 0.0;
  StiffnessZones own;
  // 250 Hz to 10 kHz. The rate of the device takes the place of the nearest one.
  std::vector<ChartedRate> rates;

  StiffnessZone own_zone() const { return own.zone_of(stiffness_N_per_m); }
};

// The device counts as one that moves motors; what it does not state is that of its class. Returns
// the errors of stability_limits(). Not for the haptic thread. Thread-safe.
Result<StiffnessChart> stiffness_chart(const DeviceDescription& device,
                                       const CouplingSettings& coupling, double rate_Hz);

// "mass 0.1 kg, damping 0.5 N s/m, delay at most 3.1 ms (assumed, of a bare tip)"
std::string assumed_text(const AssumedMechanics& mechanics);
// "K 1000 N/m is refused; stable below 139 N/m, calm by the controller up to 1089 N/m".
std::string zone_text(double stiffness_N_per_m, const StiffnessZones& zones);

// A line for each rate and delay.
std::string stiffness_chart_csv(const StiffnessChart& chart);

}  // namespace palpate
