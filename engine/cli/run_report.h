#pragma once

// Results of runs as JSON for programs and as tables for people.

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/rig/replay.h"
#include "engine/scene/scene.h"
#include "engine/simulation/exploration.h"

namespace palpate {

nlohmann::ordered_json summary_json(const RunSummary& summary, const Scene& scene);
// Without a path, the keys about the path and the judgement are left out.
nlohmann::ordered_json run_json(const ExplorationRun& run, const Scene& scene);
// The work budget of a tick, and the price of a unit in ns if it was measured.
nlohmann::ordered_json work_budget_json(const RunSetup& setup);

// "3 too_far, 1 governor_slew": how many ticks had each fault; "none" if no tick had one.
std::string faults_text(const RunSummary& summary);

std::string summary_text(const RunSummary& summary, const Scene& scene);
// A table with one column per run. A run without a path, that of a person, has no line about it.
std::string runs_text(const std::vector<ExplorationRun>& runs, const Scene& scene);

}  // namespace palpate
