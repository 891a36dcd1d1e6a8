#include "engine/cli/grip_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "engine/accuracy/surface_couplings.h"
#include "engine/cli/run_stiffness.h"
#include "engine/devices/coupling_dampers.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/live/led_hand.h"
#include "haptics/safety_governor.h"

namespace palpate {
namespace {

constexpr double kStep_Ns_per_m = 0.01;  // the damping in the text has two decimals, rounded up

// The stiffest surface of a material with this coupling.
struct Wall {
  std::string surface;
  CouplingSettings coupling;
  double stiffness_N_per_m = 0.0;
};

std::vector<Wall> walls_of(const std::vector<ExperimentScene>& scenes) {
  std::vector<Wall> walls;
  for (const ExperimentScene& scene : scenes) {
    const RunSetup& setup = scene.setup;
    const double peak_N = SafetyGovernor::clamp_of(setup.device, setup.max_force_N);
    for (const auto& surface : couplings_of(scene.scene, setup.haptics.coupling)) {
      walls.push_back({surface.name, surface.coupling, stiffest_N_per_m(surface, peak_N)});
    }
  }
  return walls;
}

// A force acts from the sample on from which it follows, until the next one.
double calm_N_per_m(const Wall& wall, const RunSetup& setup, const HandImpedance& grip) {
  DeviceMechanics held = DeviceMechanics::of(setup.device);
  held.hand = grip;
  double stable_N_per_m = std::numeric_limits<double>::infinity();
  const CouplingSettings& coupling = wall.coupling;
  for (const auto& dampers : coupling_dampers(coupling.damping_Ns_per_m, coupling.velocity)) {
    stable_N_per_m =
        std::min(stable_N_per_m, stable_stiffness_N_per_m(held, dampers, {setup.dt_s, 0.0, 1}));
  }
  return kAutoPart * stable_N_per_m;
}

bool is_calm(const std::vector<Wall>& walls, const RunSetup& setup, HandImpedance grip,
             double damping_Ns_per_m) {
  grip.damping_Ns_per_m = damping_Ns_per_m;
  return std::all_of(walls.begin(), walls.end(), [&](const Wall& wall) {
    return wall.stiffness_N_per_m <= calm_N_per_m(wall, setup, grip);
  });
}

// The smallest damping, at least that of the grip and at most `most`, in whole steps. No value:
// none is calm.
std::optional<double> fitting_damping(const std::vector<Wall>& walls, const RunSetup& setup,
                                      const HandImpedance& grip, double most_Ns_per_m) {
  double low = std::floor(grip.damping_Ns_per_m / kStep_Ns_per_m);
  double high = std::max(1.0, 2.0 * low);
  const double most = std::floor(most_Ns_per_m / kStep_Ns_per_m);
  while (high < most && !is_calm(walls, setup, grip, high * kStep_Ns_per_m)) {
    low = high;
    high *= 2.0;
  }
  high = std::min(high, most);
  if (!is_calm(walls, setup, grip, high * kStep_Ns_per_m)) return std::nullopt;
  while (high - low > 1.0) {
    const double middle = std::floor(0.5 * (low + high));
    (is_calm(walls, setup, grip, middle * kStep_Ns_per_m) ? high : low) = middle;
  }
  return high * kStep_Ns_per_m;
}

Error grip_error(const ExperimentPlan& plan, const char* key, const std::string& problem,
                 const char* hint) {
  return {ErrorCode::kInvalidContent, plan.path, std::string("/live/grip/") + key, problem, hint};
}

// The criterion of check_plant(), solved for the damping of the hand.
double most_damping_Ns_per_m(const PlantSettings& plant, double dt_s) {
  const double h_s = dt_s / plant.substeps;
  const double mass_kg = plant.device.mass_kg + plant.hand.mass_kg;
  return 2.0 * mass_kg / h_s - 0.5 * plant.hand.stiffness_N_per_m * h_s -
         plant.device.damping_Ns_per_m;
}

// The hand cannot be computed with this grip.
Error too_tight(const ExperimentPlan& plan, const PlantSettings& plant, double dt_s) {
  const double most_Ns_per_m = most_damping_Ns_per_m(plant, dt_s);
  const double h_s = dt_s / plant.substeps;
  std::ostringstream problem;
  const bool is_too_stiff = most_Ns_per_m <= 0.0;
  if (is_too_stiff) {
    const double excess = -2.0 * most_Ns_per_m / h_s;
    problem << "is " << plant.hand.stiffness_N_per_m << "; expected less than "
            << std::max(0.0, std::floor(plant.hand.stiffness_N_per_m - excess));
  } else {
    problem << "is " << plant.hand.damping_Ns_per_m << "; expected less than "
            << std::floor(most_Ns_per_m);
  }
  problem << ", with which the motion of the hand can be computed at " << plan.device.rate_Hz
          << " Hz";
  return grip_error(plan, is_too_stiff ? "stiffness_N_per_m" : "damping_Ns_per_m", problem.str(),
                    "or raise mass_kg or /device/rate_Hz");
}

}  // namespace

std::optional<Error> check_grip(const ExperimentPlan& plan,
                                const std::vector<ExperimentScene>& scenes) {
  const HandImpedance& grip = *plan.live->grip;
  const RunSetup& setup = scenes.front().setup;
  const PlantSettings plant = led_plant(setup, grip);
  if (check_plant(plant, setup.dt_s)) return too_tight(plan, plant, setup.dt_s);
  const std::vector<Wall> walls = walls_of(scenes);
  for (const Wall& wall : walls) {
    const double calm = calm_N_per_m(wall, setup, grip);
    if (wall.stiffness_N_per_m <= calm) continue;
    std::ostringstream problem;
    problem << "is " << grip.damping_Ns_per_m << ", with which the hand stays calm up to "
            << std::floor(calm) << " N/m, and " << wall.surface << " has " << wall.stiffness_N_per_m
            << " N/m; expected ";
    const auto fitting =
        fitting_damping(walls, setup, grip, most_damping_Ns_per_m(plant, setup.dt_s));
    if (fitting) {
      problem << "at least " << *fitting;
    } else {
      problem << "softer surfaces: no damping that can be computed at this rate is enough";
    }
    return grip_error(plan, "damping_Ns_per_m", problem.str(),
                      "or lower /device/stiffness_N_per_m, or raise /device/rate_Hz");
  }
  return std::nullopt;
}

}  // namespace palpate
