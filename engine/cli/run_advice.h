#pragma once

// Proposes options for a run that is not comparable.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/cli/prepared_run.h"
#include "engine/cli/run_command.h"
#include "engine/simulation/exploration.h"

namespace palpate {

struct Advice {
  std::string command_line;  // for a POSIX shell
  bool ends_comparable = false;
  double least_way_share = 0.0;  // the smallest of its runs
};

// Tries other options in simulated time, in a fixed order: more time, a larger scene, a smaller
// sphere, other planes, single nodes, another number of sensors, a larger workspace for parts that
// are small compared with the press depth, and last the removal of the user's --place,
// --plane-height and --actuated-axes. Returns the first options whose runs are comparable.
// Otherwise returns the options whose proxy came near most of the path, if that exceeds the given
// runs by 5 % of the path. A request to stop ends the search with the result so far. Not for the
// haptic thread.
std::optional<Advice> advise(const RunRequest& command, const PreparedRun& prepared,
                             const std::vector<ExplorationRun>& runs, const Progress& progress,
                             const StopFlag* stop = nullptr);

// States that the runs are not comparable, why, and the advice; empty for comparable runs.
// Interrupted runs are not judged. is_search_cut: advise() was stopped, or not called.
std::string judgement_text(const std::vector<ExplorationRun>& runs,
                           const std::optional<Advice>& advice, bool is_search_cut);

}  // namespace palpate
