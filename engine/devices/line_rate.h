#pragma once

// How many messages a second the line to a device carries, and how many it must.

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "palpate/device.h"

namespace palpate {

// What is known of a line. A number is 0 if it is unknown.
struct LineRate {
  double asked_Hz = 0.0;
  double at_start_Hz = 0.0;  // what start() has measured, at most what was asked
  // Since start(), on average and in the slowest second.
  double in_session_Hz = 0.0;
  double slowest_Hz = 0.0;
  DelayInterval delay;  // from a sample to the force that answers it: median and longest
  // Of the messages with a force, how many were later than the delay that the device states.
  double delayed_share = 0.0;
};

// The least rates of ticks and messages for a device that moves motors. A force is held for a
// period: at 250 Hz, a bare tip (device_mechanics.h) leaves a stiffness below 200 N/m, and a hand
// that moves at 0.5 m/s is 2 mm further before a force answers it.
struct LeastRates {
  static constexpr double kRefused_Hz = 250.0;  // a lower rate is refused
  static constexpr double kWarned_Hz = 500.0;   // for a lower rate, the person is warned
};

// Whether the rules for forces apply to a device.
inline bool pushes(const DeviceDescription& device) {
  return device.moves_motors && device.motor_count > 0;
}

// The Error of a device that pushes and whose ticks or messages are rarer than
// LeastRates::kRefused_Hz. line: after start(); what it does not know is
// DeviceDescription::rate_Hz.
std::optional<Error> check_least_rates(const DeviceDescription& device, const LineRate& line,
                                       double tick_rate_Hz);
// Of such a device, after start(): ticks or messages are rarer than LeastRates::kWarned_Hz, or the
// line reaches less than half of what was asked.
std::vector<std::string> slow_rate_warnings(const DeviceDescription& device, const LineRate& line,
                                            double tick_rate_Hz);
// Of any device, after a session: the line became slower than it was at the start, below half of
// what was asked or below LeastRates::kWarned_Hz; or forces were later than the device states.
std::vector<std::string> line_warnings(const DeviceDescription& device, const LineRate& line);

}  // namespace palpate
