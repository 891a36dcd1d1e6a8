#pragma once

// The settings of a run, and the setup of the haptic loop and the simulated hand that results from
// these settings.

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/devices/light_device.h"
#include "engine/scene/scene.h"
#include "engine/session/node_motions.h"
#include "engine/session/work_price.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"
#include "haptics/haptic_loop.h"
#include "haptics/safety_governor.h"

namespace palpate {

inline HapticSettings settings_without_a4() {
  HapticSettings settings;
  settings.a4.enabled = false;
  return settings;
}

// The settings of a run. make_setup() checks them. run_setting.h lists them.
struct RunSettings {
  int sensors = 3;
  // The number of actuators. If there is no value, the number is the size of actuated_axes or, if
  // that list is empty, the smaller of default_actuators and `sensors`.
  std::optional<int> actuators;
  int default_actuators = 3;
  std::vector<Vec3> actuated_axes;  // directions, device frame; empty: A1, A2, A3 in this order
  // The settings below replace some of them. Alignment::kForward is for one actuator and the
  // corrected Table 1; make_setup() refuses other combinations.
  HapticSettings haptics = settings_without_a4();
  // Replaces haptics.force and haptics.a4.enabled. No value: the two count.
  std::optional<Strategy> strategy = {};
  // See haptics/proxy/work.h. No value: the work budget of haptics.god_object.accuracy.
  std::optional<std::int64_t> work_budget = {};
  // If true, make_setup() chooses the work budget for this machine and this rate (work_price.h);
  // work_budget must then have no value.
  bool measures_work_budget = false;
  double rate_Hz = 1000.0;
  std::optional<double> max_force_N;        // lowers the device's peak force; no value: not lowered
  EnergyBudgets energy_budgets = {};        // of the governor, on a device that moves motors
  std::optional<double> encoder_quantum_m;  // quantum of the device and of the adaptive estimator
  std::optional<double> plane_height_m;  // for a planar device; no value: chosen by the run, or 0
  std::vector<SteadyMotion> moves;
  // The settings above replace the sensed axes, the motors and the rate of this description. If
  // encoder_quantum_m has a value, this value replaces the encoder quantum of the description.
  DeviceDescription device = light_device();
};

struct RunSetup {
  ActuationModel actuation;
  HapticSettings haptics;
  double dt_s;
  std::vector<SteadyMotion> moves;
  std::optional<double> max_force_N = {};     // see SessionParts
  DeviceDescription device = light_device();  // held by the simulated hand
  std::optional<MeasuredBudget> measured_budget = {};
  GovernorSettings governor = {};  // see SessionParts
};

// Checks that all settings are finite and within their ranges, and creates the setup. An error
// names the field of RunSettings or, without `haptics.`, of its HapticSettings.
Result<RunSetup> make_setup(const RunSettings& settings);

// An error names the field of HapticSettings: kForward is refused unless there is one actuator, and
// with Table 1 as printed.
std::optional<Error> check_align(Alignment align, Table1Form table1, int actuators);

// Gives a device a motor along every sensed axis, as the simulated hand's device has under
// ForceMode::kFull.
void give_all_motors(DeviceDescription& device, int sensors);

// Returns an error if no haptic loop can be created with this setup on this scene
// (check_settings), if it would refuse every tick (is_time_step), or if the device has no workspace
// for the simulated hand. The error names the field of HapticSettings or RunSettings. replay() and
// explore() call this function.
std::optional<Error> check_setup(const Scene& scene, const RunSetup& setup);

}  // namespace palpate
