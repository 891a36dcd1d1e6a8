#pragma once

// The settings of the driver of a hAPI board.

#include <optional>
#include <string>

#include "engine/devices/five_bar.h"
#include "engine/devices/hapi_protocol.h"

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

}  // namespace palpate
