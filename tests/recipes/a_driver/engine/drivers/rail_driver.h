#pragma once

// The driver of a made-up device: a handle on a rail along x, with one motor.

#include "engine/drivers/driver.h"

namespace palpate {

extern const Driver kRailDriver;

}  // namespace palpate
