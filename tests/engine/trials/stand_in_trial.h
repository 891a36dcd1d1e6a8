#pragma once

// A trial that only computes random numbers from everything that a trial may depend on, for tests
// of the code around a trial.

#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "engine/trials/experiment_scene.h"
#include "engine/trials/key_hash.h"
#include "geometry/base/random.h"

namespace palpate::test {

// duration: the duration of a trial.
inline TrialFunctions stand_in_trials(std::chrono::microseconds duration = {}) {
  TrialFunctions functions;
  functions.find_way = [](const Scene&, const RunSetup&, const TrialSettings&) {
    return Result<TrialWay>(TrialWay{});
  };
  functions.run = [duration](const Scene& scene, const TrialWay&, const RunSetup& setup,
                             const TrialSettings& settings, const OperatorParameters& person,
                             const TrialConditions& conditions,
                             const TrialSink& sink) -> Result<TrialOutcome> {
    KeyHash key;
    key.add(conditions.noise_seed).add(std::uint64_t{conditions.a4});
    key.add(static_cast<std::uint64_t>(conditions.force));
    if (conditions.strategy) key.add(name_of(*conditions.strategy));
    // Without rotation, the Following has no effect.
    key.add(static_cast<std::uint64_t>(conditions.a4 ? conditions.following : Following::kDelayed));
    key.add(person.speed_m_per_s).add(settings.limit_s).add(setup.haptics.plane_height_m);
    key.add(scene.statistics().extent_m.x());
    SeededRandom random(key.value());
    TrialOutcome outcome;
    const double draw = random.uniform(0.0, 1.0);
    outcome.status = draw < 0.9    ? TrialStatus::kDone
                     : draw < 0.95 ? TrialStatus::kTimeout
                                   : TrialStatus::kFault;
    for (auto& measure : outcome.measures) {
      if (random.uniform(0.0, 1.0) < 0.95) measure = std::abs(random.normal());
    }
    outcome.ticks = 10;
    TickRecord record{};
    for (std::uint64_t tick = 0; sink && tick < outcome.ticks; ++tick) {
      record.tick = tick;
      sink(record);
    }
    if (duration.count() > 0) std::this_thread::sleep_for(duration);
    return outcome;
  };
  return functions;
}

}  // namespace palpate::test
