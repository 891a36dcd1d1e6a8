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

struct RunAdvice {
  std::string command_line;  // for a POSIX shell
  bool ends_comparable = false;
  double least_way_share = 0.0;  // the smallest way_share of the runs
};

// Tries other options in simulated time, in a fixed order: more time, a larger scene, a smaller
// sphere, other planes, single nodes, another number of sensors, a larger workspace (for scenes
// with parts that are small compared with the press depth), and last the removal of the user's
// --place, --plane-height and --actuated-axes. Returns the first options whose runs are comparable.
// Otherwise returns the options with which the proxy covered the largest share of the path, if this
// share exceeds that of the original runs by more than 5 % of the path. A request to stop ends the
// search; the result so far is returned. Not for the haptic thread.
std::optional<RunAdvice> advise_run(const RunRequest& command, const PreparedRun& prepared,
                                    const std::vector<ExplorationRun>& runs,
                                    const Progress& progress, const StopFlag* stop = nullptr);

// A text that states that the runs are not comparable, and gives the reasons and the advice. Empty
// if the runs are comparable. Interrupted runs are not judged. is_search_cut: whether advise_run()
// was stopped or not called.
std::string judgement_text(const std::vector<ExplorationRun>& runs,
                           const std::optional<RunAdvice>& advice, bool is_search_cut);

}  // namespace palpate
