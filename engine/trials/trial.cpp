#include "engine/trials/trial.h"

#include <limits>

#include "engine/rig/rig.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/simulated_run.h"
#include "engine/trials/operator_hand.h"
#include "engine/trials/trial_clock.h"

namespace palpate {
namespace {

class SinkObserver final : public TickObserver {
 public:
  explicit SinkObserver(const TrialSink& sink) : sink_(sink) {}
  void on_tick(const TickRecord& record) noexcept override { sink_(record); }

 private:
  const TrialSink& sink_;
};

}  // namespace

class LoopTime final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override { sum_ns += record.step_ns; }
  std::int64_t sum_ns = 0;
};

PlantSettings plant_of(const RunSetup& setup, const OperatorParameters& person,
                       std::uint64_t noise_seed) {
  PlantSettings plant;
  plant.device = setup.device;
  plant.hand.stiffness_N_per_m = person.hand_stiffness_N_per_m;
  plant.hand.damping_Ns_per_m = person.hand_damping_Ns_per_m;
  plant.intention_noise_m = 0.0;
  plant.wander_m = person.intention_noise_m;
  plant.wander_Hz = person.intention_noise_Hz;
  plant.force_noise = person.force_noise;
  plant.seed = noise_seed;
  return plant;
}

Result<TrialOutcome> run_trial(const Scene& scene, const TrialWay& way, const RunSetup& setup,
                               const TrialSettings& settings, const OperatorParameters& person,
                               const TrialConditions& conditions, const TrialSink& sink) {
  RunSetup trial = setup;
  trial.haptics.force = conditions.force;
  trial.haptics.a4.enabled = conditions.a4;
  trial.haptics.strategy.reset();
  if (conditions.strategy) set_strategy(*conditions.strategy, trial.haptics);
  const PlantSettings plant = plant_of(trial, person, conditions.noise_seed);
  if (const auto error = check_setup(scene, trial)) return *error;
  if (const auto error = check_plant(plant, trial.dt_s)) return *error;
  const double radius_m = trial.haptics.god_object.radius_m;
  OperatorHand hand(way, person, conditions.following, settings, radius_m);
  TrialClock clock(way, settings, radius_m, trial.dt_s);
  SinkObserver to_sink(sink);
  LoopTime loop_time;
  SimulatedDevice device =
      device_in_hand(plant, trial, hand, trial.haptics.initial_pose.point(hand.start_scene_m()));
  std::vector<TickObserver*> observers{&clock, &loop_time};
  if (sink) observers.push_back(&to_sink);
  observers.push_back(&device);
  const auto rig = Rig::create(scene, trial, device, {.observers = observers});
  if (!rig) return rig.error();
  constexpr auto kUntilTheClockStops = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t before_start = 0;
  TrialOutcome outcome;
  outcome.ticks =
      run_simulated((*rig)->session(), trial.dt_s, kUntilTheClockStops, [&](std::uint64_t) {
        if (!clock.has_started()) before_start = hand.recoveries();
        return clock.is_over();
      });
  outcome.loop_ns = loop_time.sum_ns;
  outcome.status = clock.status();
  outcome.measures = clock.measures();
  if (clock.has_started()) {
    outcome.measures[kRecoveries] = static_cast<double>(hand.recoveries() - before_start);
  }
  return outcome;
}

}  // namespace palpate
