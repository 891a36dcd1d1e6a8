#pragma once

// What a run may be told, and what a haptic loop and a simulated hand are made with.

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/devices/light_device.h"
#include "engine/scene/scene.h"
#include "engine/session/node_motions.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// Numbers and choices, checked by make_setup().
struct RunSettings {
  int sensors = 3;
  // Nothing: as many as actuated_axes, or default_actuators but no more than sensors.
  std::optional<int> actuators;
  int default_actuators = 3;
  std::vector<Vec3> actuated_axes;  // directions, device frame; empty: the first of A1 A2 A3
  ForceMode force = ForceMode::kActuated;
  bool a4 = false;
  Table1Form table1 = Table1Form::kCorrected;
  StepRule a4_step = StepRule::kExact;
  Accuracy accuracy;
  std::optional<std::int64_t> work_budget = {};  // units of haptics/proxy/work.h; else accuracy's
  double rate_Hz = 1000.0;
  double stiffness_N_per_m = CouplingSettings{}.stiffness_N_per_m;
  double damping_Ns_per_m = CouplingSettings{}.damping_Ns_per_m;
  VelocityMethod velocity_estimator = VelocityMethod::kDifference;
  int velocity_window_ticks = 1;
  std::optional<double> encoder_quantum_m;  // for the adaptive estimator; also the device's
  double radius_m = 0.0;
  std::optional<double> plane_height_m;  // of a planar device; who runs may choose one, else 0
  ScenePose place;                       // T_device_scene at the start
  std::vector<SteadyMotion> moves;
  bool effect_times = false;
  DeviceDescription device = light_device();  // but for sensed axes, motors and rate
};

struct RunSetup {
  ActuationModel actuation;
  HapticSettings haptics;
  double dt_s;
  std::vector<SteadyMotion> moves;
  DeviceDescription device = light_device();  // that a simulated hand holds
};

// Checks ranges and finiteness; an error names the field of RunSettings.
Result<RunSetup> make_setup(const RunSettings& settings);

// What a loop on this scene would refuse in every tick (check_settings, is_time_step), or a hand
// with this device; the error names the field of HapticSettings or of RunSettings. replay() and
// explore() ask it.
std::optional<Error> check_setup(const Scene& scene, const RunSetup& setup);

}  // namespace palpate
