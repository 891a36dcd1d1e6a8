#pragma once

// A simulated person in the place of a participant, in simulated time and without a page:
// `palpate experiment live --script`.

#include <functional>
#include <optional>
#include <string>

#include "engine/session/stop_flag.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"

namespace palpate {

struct ScriptSettings {
  int participant = 1;
  std::string folder = "experiment";
  bool is_pilot = false;
};

// Takes the whole course, with all followings of the plan: the same steps, journal and rows as of a
// person, where the trials are those of `experiment run`. plan: with a `live`; its person is the
// script. progress: called after each trial with the numbers of finished and of all trials. Returns
// whether the course is complete; false: `stop` was requested. Errors: those of LiveRun::open() and
// of run_trial().
Result<bool> run_script(const ExperimentPlan& plan, const ScriptSettings& settings,
                        const TrialFunctions& functions,
                        const std::function<void(std::size_t, std::size_t)>& progress,
                        const StopFlag& stop);

}  // namespace palpate
