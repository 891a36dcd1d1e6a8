#include "engine/cli/run_progress.h"

#include <algorithm>
#include <iostream>

#include "engine/cli/command_line.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/shard_option.h"
#include "geometry/base/parallel.h"

namespace palpate {

std::function<void(const RunProgress&)> shown_in(ProgressBar& bar) {
  return [&bar](const RunProgress& progress) { bar.show(progress.share, progress.found); };
}

Result<DealtSettings> dealt_settings(const std::string& out_dir, const std::string& shard,
                                     std::optional<int> jobs) {
  DealtSettings settings;
  settings.out_folder = out_dir;
  if (!shard.empty()) {
    const auto parsed = parse_shard(shard);
    if (!parsed) return parsed.error();
    settings.shard = *parsed;
  }
  const int cores = static_cast<int>(std::min<std::size_t>(core_count(), kMostJobs));
  settings.jobs = jobs.value_or(settings.shard ? 1 : cores);
  return settings;
}

std::string count_text(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string shard_text(const DealtOutcome& outcome, const DealtSettings& settings,
                       const std::string& noun, const std::string& merged_dir) {
  const std::string shard = "shard " + std::to_string(settings.shard->number) + "/" +
                            std::to_string(settings.shard->count);
  if (outcome.computed.empty() && outcome.kept.empty()) return shard + " has no " + noun + "\n";
  const std::string& folder = settings.out_folder;
  return shard + " is complete in " + folder + "/parts\nmerge all shards: " +
         shell_line({"experiment", "merge", folder, "...", "--out", merged_dir}) + "\n";
}

std::string kept_trials_text(std::uint64_t trials, const std::string& noun) {
  if (trials == 0) return "";
  return count_text(trials, "trial") + " of " +
         (trials == 1 ? "an incomplete " + noun : "incomplete " + noun + "s");
}

int report_interruption(const DealtOutcome& outcome, const std::string& noun,
                        const std::string& out_dir) {
  const std::size_t done = outcome.computed.size() + outcome.kept.size();
  const std::size_t all = done + outcome.not_done.size();
  std::string text = std::to_string(done) + " of " + count_text(all, noun) +
                     (all == 1 ? " is" : " are") + " complete in " + out_dir + "/parts";
  if (outcome.trials_done > 0) {
    text += ", " + kept_trials_text(outcome.trials_done, noun) +
            (outcome.trials_done == 1 ? " is" : " are") + " kept there";
  }
  std::cerr << "palpate: interrupted; " << text << ", and the same command goes on from there\n";
  return exit_code_after_signals(0);
}

}  // namespace palpate
