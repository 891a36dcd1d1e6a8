#pragma once

// What to change of a run whose figures mean nothing.

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
  double least_way_share = 0.0;  // of its runs
};

// Tries other options in simulated time, one after the other in a fixed order: more time, a larger
// scene, a smaller sphere, other planes, single nodes, another number of sensors, a larger
// workspace for parts that are small beside the hand; and at last those for which an option that
// was given has to go: --place, --plane-height, --actuated-axes. Returns the first with which the
// runs are comparable; else the one with which the hand gets farthest, if that is farther than the
// runs got. Ends when it is asked to stop, with what it has found. Not for the haptic thread.
std::optional<Advice> advise(const RunRequest& command, const PreparedRun& prepared,
                             const std::vector<ExplorationRun>& runs, const Progress& progress,
                             const StopFlag* stop = nullptr);

// That runs are not comparable, why, and what to try; empty for runs that are. Runs that were
// interrupted are not judged. is_search_cut: advise() was asked to stop, or not asked at all.
std::string judgement_text(const std::vector<ExplorationRun>& runs,
                           const std::optional<Advice>& advice, bool is_search_cut);

}  // namespace palpate
