#pragma once

// Reports of a run on a device with motors.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/cli/run_stiffness.h"
#include "engine/rig/device_run.h"

namespace palpate {

// What the reports say about the device besides its run.
struct DeviceFacts {
  const DeviceDescription& device;
  std::string option;   // of --device
  std::string summary;  // GuardableDevice::summary()
  bool has_guard = true;
  bool without_realtime = false;
  std::optional<RunStiffness> stiffness = {};  // of a device that pushes
  EnergyBudgets budgets = {};
};

// One line: reason, time, tick and values of the trip.
std::string trip_text(const GovernorTrip& trip);
// The keys of the object "device".
nlohmann::ordered_json device_json(const DeviceFacts& facts, const DeviceRun& run);
// The lines below the table.
std::string device_text(const DeviceFacts& facts, const DeviceRun& run);
// One line each: what the person must know besides the results.
std::vector<std::string> device_warnings(const DeviceFacts& facts, const DeviceRun& run);

}  // namespace palpate
