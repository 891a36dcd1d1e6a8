#include "engine/trials/canonical/canonical_trial.h"

#include <cmath>

#include "engine/rig/rig.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/simulated_run.h"
#include "engine/trials/canonical/canonical_measures.h"
#include "engine/trials/canonical/canonical_wall.h"
#include "engine/trials/trial.h"

namespace palpate {
namespace {

// The number of ticks after which the motion is over if the picture of time 0 is seen.
std::uint64_t ticks_until_over(const OperatorParameters& person, CanonicalMotion motion,
                               double dt_s) {
  const double over_s = person.sight_delay_s + canonical_duration_s(person, motion);
  // The delay and the motion each end with the tick after them; one tick finds the motion over; and
  // the rounding of times may add one.
  constexpr double kMoreTicks = 4.0;
  return static_cast<std::uint64_t>(std::ceil(over_s / dt_s) + kMoreTicks);
}

}  // namespace

Result<CanonicalOutcome> run_canonical_trial(const Scene& wall, const RunSetup& device,
                                             double display_Hz, const OperatorParameters& person,
                                             const CanonicalConditions& conditions) {
  const RunSetup setup =
      canonical_setup(device, conditions.cell.angle_deg, conditions.cell.rotates);
  const PlantSettings plant = plant_of(setup, person, conditions.noise_seed);
  if (const auto error = check_setup(wall, setup)) return *error;
  if (const auto error = check_plant(plant, setup.dt_s)) return *error;
  const double radius_m = setup.haptics.god_object.radius_m;
  CanonicalHand hand(person, conditions.cell.motion, display_Hz, radius_m);
  CanonicalMeasures measures(radius_m);
  SimulatedDevice simulated =
      device_in_hand(plant, setup, hand, setup.haptics.initial_pose.point(hand.start_scene_m()));
  const auto rig = Rig::create(wall, setup, simulated, {.observers = {&measures, &simulated}});
  if (!rig) return rig.error();
  CanonicalOutcome outcome;
  outcome.ticks = run_simulated(
      (*rig)->session(), setup.dt_s, ticks_until_over(person, conditions.cell.motion, setup.dt_s),
      [&](std::uint64_t) { return hand.is_over() || measures.is_spoilt(); });
  outcome.loop_ns = measures.loop_ns();
  outcome.is_spoilt = measures.is_spoilt();
  if (outcome.is_spoilt) return outcome;
  outcome.along_over_into = measures.along_over_into();
  outcome.share_within_30deg = measures.share_within_30deg();
  return outcome;
}

}  // namespace palpate
