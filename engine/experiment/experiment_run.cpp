#include "engine/experiment/experiment_run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <future>
#include <mutex>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/experiment/key_hash.h"
#include "engine/experiment/participant_part.h"
#include "engine/experiment/participant_run.h"
#include "engine/experiment/run_identity.h"
#include "engine/experiment/run_log.h"
#include "engine/experiment/strict_json.h"
#include "engine/report/whole_file.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string log_path(const std::string& folder) {
  return (fs::path(folder) / "run.log").string();
}

// The paths of the files that a run of these participants writes, without the folder's traces.
std::vector<std::string> written_paths(const ExperimentRunSettings& settings,
                                       const std::vector<int>& participants) {
  const std::string& folder = settings.out_folder;
  std::vector<std::string> paths{log_path(folder), part_identity_path(folder)};
  for (const int participant : participants) paths.push_back(part_path(folder, participant));
  if (settings.shard) return paths;
  for (const char* const name : {kTrialsFile, kColumnsFile, kRunFile}) {
    paths.push_back((fs::path(folder) / name).string());
  }
  return paths;
}

// An error if something other than a file has one of these paths, such as a folder or a pipe. It
// would be found when the trials have run, and opening a pipe waits for a reader.
std::optional<Error> check_paths(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (!fs::exists(status) || fs::is_regular_file(status)) continue;
    return Error{ErrorCode::kFileUnwritable, path, "",
                 "is not a file, but a result needs this name",
                 "move it, or choose another folder"};
  }
  return std::nullopt;
}

std::string traces_folder_of(const std::string& folder) {
  return (fs::path(folder) / "traces").string();
}

// Removes the traces of another run, but no other files. A trace does not state its run, so that a
// later run would take it for its own.
void remove_traces(const std::string& folder) {
  std::vector<fs::path> traces;
  std::error_code failed;
  for (const std::string_view following : kFollowingNames) {
    const fs::path persons = fs::path(traces_folder_of(folder)) / following;
    for (fs::recursive_directory_iterator file(persons, failed), end; !failed && file != end;
         file.increment(failed)) {
      if (is_trace_name(file->path().filename().string())) traces.push_back(file->path());
    }
  }
  for (const fs::path& trace : traces) fs::remove(trace, failed);
}

// Creates out_folder/parts and states there which run the parts belong to. Parts and traces of
// another run are removed.
std::optional<Error> prepare_folder(const std::string& folder, const RunIdentity& identity) {
  std::error_code failed;
  fs::create_directories(parts_folder(folder), failed);
  if (failed && fs::is_directory(folder)) {
    return Error{ErrorCode::kFileUnwritable, parts_folder(folder), "",
                 "cannot be created: " + failed.message(),
                 "move what has this name, or choose another folder"};
  }
  if (failed) {
    return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
                 "cannot be created: " + failed.message(), "name a folder that can be written to"};
  }
  const std::string path = part_identity_path(folder);
  const auto found = read_settings_text(path);
  if (found && *found == identity.json()) return std::nullopt;
  if (found) {
    remove_traces(folder);
    for (const int participant : participants_with_parts(folder)) {
      const std::string part = part_path(folder, participant);
      if (!read_part(part, identity.hash(), participant, identity.columns())) {
        fs::remove(part, failed);
      }
    }
  }
  auto file = WholeFile::create(path);
  if (!file) return file.error();
  file->add(identity.json());
  return file->finish();
}

bool has_traces(const ExperimentPlan& plan, const std::string& traces_folder, int participant) {
  const auto trials = planned_trials(plan, participant);
  return std::all_of(trials.begin(), trials.end(), [&](const PlannedTrial& trial) {
    std::error_code failed;
    return fs::exists(fs::path(traces_folder) / trace_name(plan, participant, trial), failed);
  });
}

// The threads that run participants, and what they share.
class ExperimentJobs {
 public:
  ExperimentJobs(const ExperimentPlan& plan, const std::vector<ExperimentScene>& scenes,
                 const TrialFunctions& functions, const std::string& folder, std::uint64_t run,
                 std::string traces_folder, const StopFlag* stop)
      : plan_(plan),
        scenes_(scenes),
        functions_(functions),
        folder_(folder),
        run_(run),
        traces_folder_(std::move(traces_folder)),
        stop_(stop),
        log_(log_path(folder)) {}

  // Runs the participants and returns those that are complete, in ascending order.
  Result<std::vector<int>> run(std::vector<int> participants, int jobs,
                               const std::function<void(const ExperimentProgress&)>& progress);

 private:
  void work();
  void run_one(int participant);
  void fail(Error error);
  bool goes_on() const { return !has_failed_.load() && !(stop_ && stop_->requested()); }
  ExperimentProgress progress_now() const;

  const ExperimentPlan& plan_;
  const std::vector<ExperimentScene>& scenes_;
  const TrialFunctions& functions_;
  const std::string& folder_;
  std::uint64_t run_;
  std::string traces_folder_;
  const StopFlag* stop_;
  RunLog log_;

  std::vector<int> participants_;
  Clock::time_point start_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::uint64_t> trials_done_{0};
  std::atomic<bool> has_failed_{false};
  std::mutex mutex_;  // of the members below
  std::optional<Error> error_;
  std::vector<int> complete_;
};

void ExperimentJobs::fail(Error error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  has_failed_.store(true);
}

void ExperimentJobs::run_one(int participant) {
  const Clock::time_point start = Clock::now();
  std::uint64_t trials = 0;
  const auto run = run_participant(plan_, scenes_, functions_, participant, traces_folder_, [&] {
    ++trials;
    trials_done_.fetch_add(1);
    return goes_on() || trials == plan_.trials_per_participant();
  });
  if (!run) return fail(run.error());
  if (!*run) return;
  const ParticipantRun& done = **run;
  const TrialColumns columns =
      plan_.strategies.empty() ? TrialColumns::kFactors : TrialColumns::kStrategies;
  if (auto error =
          write_part(part_path(folder_, participant), run_, participant, done.rows, columns)) {
    return fail(*error);
  }
  log_.add("participant " + std::to_string(participant) + ": " +
           computing_text(trials, done.ticks, seconds_since(start), done.loop_ns));
  const std::lock_guard lock(mutex_);
  complete_.push_back(participant);
}

void ExperimentJobs::work() {
  while (goes_on()) {
    const std::size_t place = next_.fetch_add(1);
    if (place >= participants_.size()) return;
    try {
      run_one(participants_[place]);
    } catch (const std::bad_alloc&) {
      fail({ErrorCode::kOutOfMemory, "", "", "the system refused memory",
            "use fewer jobs, or free memory"});
    }
  }
}

ExperimentProgress ExperimentJobs::progress_now() const {
  const auto done = static_cast<double>(trials_done_.load());
  const auto all = static_cast<double>(participants_.size() * plan_.trials_per_participant());
  if (done == 0.0) return {};
  return {done / all, seconds_since(start_) * (all - done) / done};
}

Result<std::vector<int>> ExperimentJobs::run(
    std::vector<int> participants, int jobs,
    const std::function<void(const ExperimentProgress&)>& progress) {
  participants_ = std::move(participants);
  start_ = Clock::now();
  log_.add("run " + hash_text(run_) + ": " + std::to_string(participants_.size()) +
           " participants to compute with " + std::to_string(jobs) + " jobs");
  std::vector<std::future<void>> threads;
  const std::size_t count = std::min(participants_.size(), static_cast<std::size_t>(jobs));
  for (std::size_t i = 0; i < count; ++i) {
    auto thread = start_thread([this] { work(); });
    if (thread.valid()) threads.push_back(std::move(thread));
  }
  if (threads.empty()) work();  // also if the system has no thread left
  constexpr std::chrono::milliseconds kBetweenProgress(100);
  for (std::future<void>& thread : threads) {
    while (thread.wait_for(kBetweenProgress) != std::future_status::ready) {
      if (progress) progress(progress_now());
    }
    thread.get();
  }
  if (error_) return *error_;
  std::sort(complete_.begin(), complete_.end());
  return complete_;
}

}  // namespace

std::vector<int> participants_of(const Shard& shard, int participants) {
  std::vector<int> numbers;
  for (int p = shard.number; p <= participants; p += shard.count) numbers.push_back(p);
  return numbers;
}

Result<ExperimentRunOutcome> run_experiment(
    const ExperimentPlan& plan, const ExperimentRunSettings& settings,
    const TrialFunctions& functions, const std::function<void(const ExperimentProgress&)>& progress,
    const StopFlag* stop) {
  const auto scenes = load_experiment_scenes(plan, functions);
  if (!scenes) return scenes.error();
  if (auto error = check_persons(plan, scenes->front().setup)) return *error;
  const RunIdentity identity = identity_of(plan, *scenes);
  const std::string& folder = settings.out_folder;
  const std::vector<int> participants =
      participants_of(settings.shard.value_or(Shard{}), plan.participants);
  if (auto error = check_paths(written_paths(settings, participants))) return *error;
  if (auto error = prepare_folder(folder, identity)) return *error;
  const std::string traces = settings.writes_traces ? traces_folder_of(folder) : std::string();

  ExperimentRunOutcome outcome;
  std::vector<int> to_compute;
  for (const int participant : participants) {
    const bool is_there =
        read_part(part_path(folder, participant), identity.hash(), participant, identity.columns())
            .ok() &&
        (traces.empty() || has_traces(plan, traces, participant));
    (is_there ? outcome.kept : to_compute).push_back(participant);
  }
  ExperimentJobs jobs(plan, *scenes, functions, folder, identity.hash(), traces, stop);
  auto computed = jobs.run(to_compute, settings.jobs, progress);
  if (!computed) return computed.error();
  outcome.computed = std::move(*computed);
  std::set_difference(to_compute.begin(), to_compute.end(), outcome.computed.begin(),
                      outcome.computed.end(), std::back_inserter(outcome.not_done));
  if (settings.shard || !outcome.not_done.empty()) return outcome;
  auto merged = merge_experiment({folder}, folder);
  if (!merged) return merged.error();
  outcome.merged = *merged;
  return outcome;
}

}  // namespace palpate
