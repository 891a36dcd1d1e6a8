#pragma once

// The option --strategy, which stands in place of --force and --a4.

#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "geometry/base/result.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

void add_strategy(CLI::App& app, std::optional<Strategy>& strategy);

// An Error if the command line gives --strategy and also --force or --a4. is_given: whether it
// gives the option of a name.
std::optional<Error> check_strategy_options(
    const std::function<bool(const std::string&)>& is_given);

// Whether a strategy turns the scene as A4 does.
bool has_a4(const Strategy& strategy);

// An Error if the strategy is `full` and a device has fewer motors than sensors: the device would
// mask the force in silence.
std::optional<Error> check_motors(const std::optional<Strategy>& strategy, int sensors, int motors);

}  // namespace palpate
