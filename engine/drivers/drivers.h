#pragma once

// The drivers, and devices as a user names them: "hapi:port=/dev/ttyACM0,base=0.02".

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine/drivers/driver.h"
#include "geometry/base/result.h"

namespace palpate {

// All drivers. A new driver adds one line to drivers.cpp.
std::span<const Driver* const> drivers();

// The driver of this name; null: there is none.
const Driver* find_driver(std::string_view name);

// The names of all drivers: "hapi" or "hapi, other".
std::string driver_names();

// Makes the device that a text names. The text is the name of a driver and, after a colon, its
// settings as key=value, separated by commas. works_without_guard: see Driver. The Error's element
// is `option` and the key.
Result<std::unique_ptr<GuardableDevice>> make_device(const std::string& option,
                                                     std::string_view text,
                                                     bool works_without_guard);

// Reads the settings of one driver: key=value, separated by commas. The Error's element is the key,
// or empty.
Result<DriverValues> parse_driver_values(const Driver& driver, std::string_view list);

// The drivers with their keys, ranges and initial values, as `palpate devices` prints them.
std::string drivers_text();

}  // namespace palpate
