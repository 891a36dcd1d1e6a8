#pragma once

// The stiffness of a run on a device that moves motors: chosen (`--stiffness auto`), or judged.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/accuracy/surface_couplings.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/run_command.h"
#include "engine/devices/guardable_device.h"
#include "engine/devices/stiffness_zones.h"
#include "geometry/base/result.h"

namespace palpate {

// A stiffness and its zone.
struct JudgedStiffness {
  std::string surface;           // of couplings_of()
  double stiffness_N_per_m = 0;  // the largest of the surface, with its relief at the peak force
  StiffnessZones zones;          // for the damping of the surface
  StiffnessZone zone() const { return zones.zone_of(stiffness_N_per_m); }
};

// The servo and the device with which surfaces are judged.
struct JudgedLoop {
  const DeviceDescription& device;
  double period_s = 0.0;
  double peak_force_N = 0.0;
};

// The surface that is furthest beyond its zones.
struct WorstSurface {
  JudgedStiffness judged;
  double relief_N_per_m = 0.0;  // what the relief adds to the stiffness
  bool is_of_loop = false;      // it has no stiffness of its own

  // The stiffness that fits this surface.
  double fitting_N_per_m() const;
};

// Errors: those of stiffness_zones().
Result<WorstSurface> worst_surface(const std::vector<SurfaceCoupling>& couplings,
                                   const JudgedLoop& loop);
// The largest stiffness of a surface that is pressed with at most this force, with its relief.
double stiffest_N_per_m(const SurfaceCoupling& surface, double peak_force_N);
// "is 2000 N/m; expected at most 1140 N/m: no damping that ..."
std::string too_stiff_text(const WorstSurface& worst);

// What a run on a device that pushes states about its stiffness.
struct RunStiffness {
  double stiffness_N_per_m = 0.0;  // of surfaces without their own
  bool is_auto = false;
  bool has_measured_delay = false;
  double peak_force_N = 0.0;
  StiffnessZones zones;   // for the damping of surfaces without their own
  JudgedStiffness worst;  // the surface that is furthest beyond its zones
  std::string allowed;    // the reason of --allow-unstable; empty without the option
};

// The device is open and has not got a force. Sets the delay and, if the request asks for `auto`,
// the stiffness of the setup, and judges the stiffness of all surfaces at the longest delay; the
// period is that of the slower of ticks and messages. No value: the device does not push, so that
// no stiffness is unstable; `auto` is then the initial value of the option. Errors: those of
// check_least_rates(); a surface is stiffer than the largest damping can hold, and the request does
// not allow it (--allow-unstable); no stiffness is stable.
Result<std::optional<RunStiffness>> choose_stiffness(const RunRequest& request,
                                                     const GuardableDevice& device,
                                                     PreparedRun& prepared);

// "calm only by the controller, which damps the motion". allowed: the reason of --allow-unstable.
std::string zone_text(StiffnessZone zone, const std::string& allowed);
// Tells the person the lines of stiffness_text(), on stderr.
void tell_stiffness(const RunStiffness& stiffness);
// Mechanics and delay, limits, and the zone.
std::string stiffness_text(const RunStiffness& stiffness);
nlohmann::ordered_json stiffness_json(const RunStiffness& stiffness);
// "mass 0.1 kg (assumed, of a bare tip), damping 0.5 N s/m, delay from a sample to its force 2 ms"
std::string mechanics_text(const AssumedMechanics& mechanics);
// "a wall is passive up to 250 N/m and stable below 333 N/m"; rounded down.
std::string limits_text(const StiffnessZones& zones);

}  // namespace palpate
