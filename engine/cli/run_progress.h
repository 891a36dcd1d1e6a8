#pragma once

// The progress of runs that are dealt to shards and jobs.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "engine/cli/command_output.h"
#include "engine/trials/deal/dealt_run.h"

namespace palpate {

// A function that shows the progress in the bar, which must outlive the function.
std::function<void(const RunProgress&)> shown_in(ProgressBar& bar);

// The settings of a run. shard: "i/n", or empty for all units. jobs: no value for the number of
// cores, and for 1 if there is a shard.
Result<DealtSettings> dealt_settings(const std::string& out_dir, const std::string& shard,
                                     std::optional<int> jobs);

// "1 point", "12 points"
std::string count_text(std::size_t count, const std::string& noun);

// What a shard did. merged_dir: the folder of the merge that is shown.
std::string shard_text(const DealtOutcome& outcome, const DealtSettings& settings,
                       const std::string& noun, const std::string& merged_dir);

// "12 trials of incomplete participants"; empty without trials.
std::string kept_trials_text(std::uint64_t trials, const std::string& noun);

// Says on stderr how many units are complete, and returns the exit code.
int report_interruption(const DealtOutcome& outcome, const std::string& noun,
                        const std::string& out_dir);

}  // namespace palpate
