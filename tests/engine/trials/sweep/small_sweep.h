#pragma once

// Small sweeps, one of them with every parameter, and a stand-in for its trials that depends on all
// of them.

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/experiment_scene.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/sweep/sweep_file.h"
#include "tests/engine/trials/stand_in_trial.h"

namespace palpate::test {

inline nlohmann::json small_sweep_json() {
  return nlohmann::json::parse(R"({"palpate_sweep": 1, "name": "small",
      "plan": {"palpate_plan": 1, "name": "base", "seed": 7, "participants": 2, "blocks": 1,
        "practice_blocks": 0,
        "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                   "damping_Ns_per_m": 2},
        "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
        "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"],
        "objects": {"O1": "star.glb"}, "operator": "people2005", "followings": ["delayed"]},
      "parameters": {"sight_delay_s": [0.2, 0.1], "intention_noise_m": [0.001, 0.002],
        "force_noise": [0, 0.05], "press_depth_m": [0.004, 0.008],
        "hand_stiffness_N_per_m": [200, 400], "speed_m_per_s": [0.03, 0.06],
        "stiffness_N_per_m": [500, 1000], "comfortable_depth_m": [0.005, 0.01],
        "following": ["delayed", "frozen"], "align": ["nearest", "forward"],
        "start_orientation_deg": [0, 45], "scale": [0.5, 1]},
      "hypercube": {"points": 6, "seed": 3, "participants": 1}})");
}

inline Sweep sweep_of(const nlohmann::json& json) {
  auto sweep = parse_sweep(json.dump(), "sweep.json", PALPATE_MODELS_DIR);
  EXPECT_TRUE(sweep.ok()) << sweep.error().to_string();
  return *sweep;
}

inline Sweep small_sweep() {
  return sweep_of(small_sweep_json());
}

// The same with three of the parameters, so that a report has three figures.
inline nlohmann::json quick_sweep_json() {
  nlohmann::json json = small_sweep_json();
  nlohmann::json parameters;
  for (const char* const name : {"sight_delay_s", "following", "scale"}) {
    parameters[name] = json["parameters"][name];
  }
  json["parameters"] = parameters;
  return json;
}

// stand_in_trials(), and the time depends on everything else that a sweep sets.
inline TrialFunctions sweep_stand_in(std::chrono::microseconds duration = {}) {
  TrialFunctions functions = stand_in_trials(duration);
  functions.run = [run = functions.run](const Scene& scene, const TrialWay& way,
                                        const RunSetup& setup, const TrialSettings& settings,
                                        const OperatorParameters& person,
                                        const TrialConditions& conditions, const TrialSink& sink) {
    auto outcome = run(scene, way, setup, settings, person, conditions, sink);
    KeyHash key;
    for (const PersonParameter& parameter : person_parameters()) {
      key.add(person.*parameter.field);
    }
    key.add(person.comfortable_depth_m).add(setup.haptics.coupling.stiffness_N_per_m);
    key.add(static_cast<std::uint64_t>(setup.haptics.a4.align));
    key.add(setup.haptics.initial_pose.rotation.z()).add(conditions.noise_seed);
    SeededRandom random(key.value());
    outcome->measures[kTotalTime] = random.uniform(10.0, 30.0);
    const auto& depth_m = outcome->measures[kPenetration];  // in two units, as of a real trial
    outcome->measures[kPenetrationDm] = depth_m ? std::optional(10.0 * *depth_m) : std::nullopt;
    return outcome;
  };
  return functions;
}

}  // namespace palpate::test
