#include "engine/trials/compare/compare_run.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "engine/report/whole_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

std::string compare_trials_folder(const std::string& folder) {
  return (fs::path(folder) / "trials").string();
}

std::string compare_plan_path(const std::string& folder) {
  return (fs::path(folder) / "plan.json").string();
}

Result<CompareOutcome> run_comparison(const CompareSettings& settings,
                                      const ExperimentRunSettings& run,
                                      const TrialFunctions& functions,
                                      const std::function<void(const RunProgress&)>& progress,
                                      const StopFlag* stop) {
  const std::string& folder = run.out_folder;
  const auto plan = compare_plan(settings);
  if (!plan) return plan.error();
  CompareOutcome outcome;
  const MadeFolders made(folder);
  if (std::error_code failed; fs::is_directory(folder, failed)) {  // otherwise the run says why not
    auto lock = OutputLock::take(folder, run.shard ? FolderUse::kShard : FolderUse::kAlone);
    if (!lock) return lock.error();
    outcome.lock = std::move(*lock);
  }
  ExperimentRunSettings one = run;
  one.out_folder = compare_trials_folder(folder);
  auto done = run_experiment(*plan, one, functions, progress, stop);
  if (!done) return done.error();
  // After the run, because a run that is refused writes nothing.
  auto file = WholeFile::create(compare_plan_path(folder));
  if (!file) return file.error();
  file->add(compare_plan_text(settings, folder));
  if (auto error = file->finish()) return *error;
  outcome.run = std::move(*done);
  return outcome;
}

}  // namespace palpate
