#pragma once

// The driver of a pantograph on a hAPI board, for the list of drivers.

#include "engine/devices/hapi_settings.h"
#include "engine/drivers/driver.h"

namespace palpate {

// The settings that the values state, checked (check_hapi_settings()). The Error's element is the
// key.
Result<HapiSettings> hapi_settings_of(const DriverValues& values);

extern const Driver kHapiDriver;

}  // namespace palpate
