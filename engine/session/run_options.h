#pragma once

// What `run` and `replay` let a user choose, and how it becomes settings.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/light_device.h"
#include "engine/scene/scene.h"
#include "engine/session/node_motions.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// As given on the command line; texts are parsed by make_setup().
struct RunOptions {
  int sensors = 3;
  // Default: `default_actuators` but no more than sensors, or the number of axes given.
  std::optional<int> actuators;
  int default_actuators = 3;
  std::string actuated_axes;  // "0 0 1; 1 0 0", device frame
  std::string force = "actuated";
  std::string a4 = "off";
  std::string table1 = "corrected";
  std::string a4_step = "exact";
  std::string accuracy = "balanced";
  std::optional<std::int64_t> work_budget =
      {};  // units of haptics/proxy/work.h; that of --accuracy
  double rate_Hz = 1000.0;
  double stiffness_N_per_m = CouplingSettings{}.stiffness_N_per_m;
  double damping_Ns_per_m = CouplingSettings{}.damping_Ns_per_m;
  std::string velocity_estimator = "difference";
  int velocity_window_ticks = 1;
  std::optional<double> encoder_quantum_m;
  double radius_m = 0.0;
  std::optional<double> plane_height_m;  // of a planar device; `run` chooses one, else 0
  std::string place;                     // "x y z qw qx qy qz": T_device_scene at the start
  std::vector<std::string> moves;        // "NODE=vx vy vz wx wy wz" each
  bool effect_times = false;
  DeviceDescription device = light_device();  // but for sensed axes, motors, rate
};

// Which part of a file is loaded, and how large. As given on the command line.
struct SceneOptions {
  std::string path;
  std::string node;
  std::optional<double> scale;
  std::optional<double> fit_size_m;
  bool fits_workspace = false;  // --fit auto: to the workspace, where it does not fit as it is
  std::string pose;             // "NAME@SECONDS"; empty: at rest
  std::vector<std::string> materials;  // "NAME.key=value" each
  std::string max_memory;              // "500M"; empty: half of what is free
};

struct RunSetup {
  ActuationModel actuation;
  HapticSettings haptics;
  double dt_s;
  std::vector<SteadyMotion> moves;
  DeviceDescription device = light_device();  // that a simulated hand holds
};

// Checks ranges and finiteness; an error names the option.
Result<RunSetup> make_setup(const RunOptions& options);

// What a loop on this scene would refuse in every tick (check_settings, is_time_step); the error
// names the option, or the field of HapticSettings that has none. replay() and explore() ask it.
std::optional<Error> check_setup(const Scene& scene, const RunSetup& setup);

// Checks likewise, and loads the scene.
Result<Scene> load_scene(const SceneOptions& options, double proxy_radius_m);

// The same for a session: refuses what ticks at this rate cannot make felt.
Result<Scene> load_scene(const SceneOptions& options, const RunOptions& run);

}  // namespace palpate
