#include "engine/trials/compare/compare_run.h"

#include <filesystem>
#include <utility>

#include "engine/report/whole_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::vector<CompareHands> hands_of(const CompareSettings& settings) {
  if (!settings.is_tuned) return {CompareHands::kCompared};
  return {CompareHands::kCompared, CompareHands::kTuning};
}

std::optional<Error> write_plan_file(const CompareSettings& settings, CompareHands hands,
                                     const std::string& folder) {
  auto file = WholeFile::create(compare_plan_path(folder, hands));
  if (!file) return file.error();
  file->add(compare_plan_text(settings, hands, folder));
  return file->finish();
}

// Makes a folder and its parents. At its end, those that it made and that are still empty are
// removed: a comparison that is refused leaves none.
class MadeFolders {
 public:
  explicit MadeFolders(const fs::path& folder) {
    fs::path path;
    std::error_code failed;
    for (const fs::path& part : folder) {
      path /= part;
      if (!part.empty() && fs::create_directory(path, failed)) made_.push_back(path);
    }
  }
  ~MadeFolders() {
    std::error_code is_used;
    for (auto path = made_.rbegin(); path != made_.rend(); ++path) fs::remove(*path, is_used);
  }
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;

 private:
  std::vector<fs::path> made_;  // outermost first
};

// The trials of one plan count more in the progress, the more strategies the plan has.
double share_of_trials(const std::vector<ExperimentPlan>& plans, std::size_t run) {
  std::uint64_t all = 0;
  for (const ExperimentPlan& plan : plans) all += plan.trials_per_participant();
  return static_cast<double>(plans[run].trials_per_participant()) / static_cast<double>(all);
}

}  // namespace

std::string compare_trials_folder(const std::string& folder, CompareHands hands) {
  return (fs::path(folder) / (hands == CompareHands::kCompared ? "trials" : "tuning")).string();
}

std::string compare_plan_path(const std::string& folder, CompareHands hands) {
  const char* const name = hands == CompareHands::kCompared ? "plan.json" : "tuning-plan.json";
  return (fs::path(folder) / name).string();
}

Result<CompareOutcome> run_comparison(const CompareSettings& settings,
                                      const ExperimentRunSettings& run,
                                      const TrialFunctions& functions,
                                      const std::function<void(const RunProgress&)>& progress,
                                      const StopFlag* stop) {
  const std::string& folder = run.out_folder;
  std::vector<ExperimentPlan> plans;
  for (const CompareHands hands : hands_of(settings)) {
    auto plan = compare_plan(settings, hands);
    if (!plan) return plan.error();
    plans.push_back(std::move(*plan));
  }
  CompareOutcome outcome;
  const MadeFolders made(folder);
  if (std::error_code failed; fs::is_directory(folder, failed)) {  // otherwise the run says why not
    auto lock = OutputLock::take(folder, run.shard ? FolderUse::kShard : FolderUse::kAlone);
    if (!lock) return lock.error();
    outcome.lock = std::move(*lock);
  }
  double share_before = 0.0;
  double found_before = 0.0;
  for (const CompareHands hands : hands_of(settings)) {
    const std::size_t number = outcome.runs.size();
    ExperimentRunSettings one = run;
    one.out_folder = compare_trials_folder(folder, hands);
    const double share = share_of_trials(plans, number);
    double found_of_run = 1.0;  // if nothing is left to compute
    const auto show = [&](const RunProgress& of_run) {
      found_of_run = of_run.found;
      if (!progress) return;
      progress({share_before + share * of_run.share, found_before + share * of_run.found});
    };
    auto done = run_experiment(plans[number], one, functions, show, stop);
    if (!done) return done.error();
    // After the run, because a run that is refused writes nothing.
    if (auto error = write_plan_file(settings, hands, folder)) return *error;
    share_before += share;
    found_before += share * found_of_run;
    const bool is_stopped = !done->not_done.empty();
    outcome.runs.push_back(std::move(*done));
    if (is_stopped) return outcome;
  }
  return outcome;
}

}  // namespace palpate
