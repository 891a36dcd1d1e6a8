#pragma once

// `run --device`: a person explores a scene with a device that has motors.

#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/cli/run_command.h"
#include "geometry/base/result.h"
#include "haptics/energy_budgets.h"

namespace palpate {

// Adds --device and the options that need it.
void add_motors(CLI::App& app, DeviceRequest& device);

// Whether the command line gives the option of this name.
using IsGiven = std::function<bool(const std::string&)>;

// An Error if options contradict each other: some are only for the simulated hand, others only for
// a device.
std::optional<Error> check_device_options(const RunRequest& request, const IsGiven& is_given);

// Tells the person, on stderr, which budgets are not the initial ones.
void tell_energy_budgets(const EnergyBudgets& budgets);

// Makes the one run of a strategy, if the request names one.
void take_strategy(RunRequest& request);

// The settings of a run with the properties of the device. The device has no workspace across its
// plane; the scene may have any height there.
void set_device(const DeviceDescription& device, RunSettings& settings);
// The same, with the rate and the stiffness of the device unless the command line gives them.
void describe_device(const DeviceDescription& device, const IsGiven& is_given, RunRequest& request);

// Requires check_device_options(), and a device. Returns the exit code.
int run_on_device(RunRequest request, const IsGiven& is_given);

}  // namespace palpate
