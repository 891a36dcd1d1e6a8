#pragma once

// The settings of the driver of a hAPI board.

#include <optional>
#include <string>

#include "engine/devices/five_bar.h"
#include "engine/devices/hapi_protocol.h"
#include "geometry/base/result.h"

namespace palpate {

struct HapiSettings {
  std::string port;  // the terminal, for example /dev/ttyACM0
  FiveBarLinks links;
  HapiWiring wiring;
  // The torque number of the board for 1 N m, not 0; negative if the motors turn the other way. It
  // must be measured. No value: the driver reads, and commands zero.
  std::optional<double> torque_per_Nm;
  double peak_torque_Nm = 0.0;  // of each motor, > 0 if torque_per_Nm has a value
  double rate_Hz = 1000.0;      // of the messages
  // True: the driver commands forces although nothing stops the motors if this process hangs or
  // ends (WriteGuard). For tests.
  bool works_without_guard = false;
};

// What the driver accepts.
struct HapiLimits {
  static constexpr double kShortest_m = 1e-3;  // of a link
  static constexpr double kLongest_m = 1.0;
  static constexpr double kMostCounts = 1 << 24;  // the protocol's numbers have 24 bits
  static constexpr double kSlowest_Hz = 50.0;
  static constexpr double kFastest_Hz = 4000.0;
  static constexpr double kMostPerNm = 1e6;
  static constexpr double kMostPeak_Nm = 10.0;
};

// An Error if a setting is out of range or if the linkage has no workspace. Its element is the
// setting, by the name of its key (engine/drivers/hapi_driver.h).
std::optional<Error> check_hapi_settings(const HapiSettings& settings);

}  // namespace palpate
