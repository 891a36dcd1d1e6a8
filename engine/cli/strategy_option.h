#pragma once

// The option --strategy, which stands in place of --force and --a4.

#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "geometry/base/result.h"
#include "haptics/strategies/strategy.h"
#include "palpate/device.h"

namespace palpate {

void add_strategy(CLI::App& app, std::optional<Strategy>& strategy);

// An Error if the command line gives --strategy and also --force or --a4. is_given: whether it
// gives the option of a name.
std::optional<Error> check_strategy_options(
    const std::function<bool(const std::string&)>& is_given);

// Whether a strategy turns the scene as A4 does.
bool has_a4(const Strategy& strategy);

// An Error if the strategy is `full` and a device has fewer motors than sensors: the governor would
// mask the force in silence. device: with the motors that a run uses. Not for the simulated hand,
// which gets all motors.
std::optional<Error> check_motors(const std::optional<Strategy>& strategy,
                                  const DeviceDescription& device);

}  // namespace palpate
