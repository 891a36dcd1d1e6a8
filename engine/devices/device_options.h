#pragma once

// Devices as a user names them: "hapi:port=/dev/ttyACM0,base=0.02".

#include <string>
#include <string_view>

#include "engine/devices/hapi_settings.h"
#include "geometry/base/result.h"

namespace palpate {

// The text names a driver and, after a colon, its settings as key=value, separated by commas. The
// only driver is "hapi". Its keys:
//   port           the terminal of the board; required
//   base, proximal, distal   lengths of the links, m
//   torque-per-Nm  the board's torque number for 1 N m; without it the driver commands zero
//   peak-torque    of a motor, N m; required beside torque-per-Nm
//   dev            the number of the device on its board
//   counts         steps of an encoder per turn
//   angle1, angle2 the angles of the joints in the rest pose, degrees
//   rate           messages per second
// The result is checked (check_hapi_settings()). The Error's element is `option` and the key.
Result<HapiSettings> parse_device(const std::string& option, std::string_view text);

}  // namespace palpate
