#include "engine/experiment/dealt_run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <iterator>
#include <mutex>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/experiment/key_hash.h"
#include "engine/experiment/run_identity.h"
#include "engine/experiment/run_log.h"
#include "engine/experiment/strict_json.h"
#include "engine/experiment/traces_folder.h"
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

// The paths of the files that a run of these units writes, without the other files of units.
std::vector<std::string> written_paths(const DealtRun& run, const DealtSettings& settings,
                                       const std::vector<int>& units) {
  const std::string& folder = settings.out_folder;
  std::vector<std::string> paths{log_path(folder), part_identity_path(folder)};
  for (const int unit : units) paths.push_back(part_path(folder, run.units.noun, unit));
  if (settings.shard) return paths;
  for (const std::string& name : run.result_names) {
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

std::optional<Error> create_parts_folder(const std::string& folder) {
  std::error_code failed;
  fs::create_directories(parts_folder(folder), failed);
  if (!failed) return std::nullopt;
  if (fs::is_directory(folder)) {
    return Error{ErrorCode::kFileUnwritable, parts_folder(folder), "",
                 "cannot be created: " + failed.message(),
                 "move what has this name, or choose another folder"};
  }
  return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
               "cannot be created: " + failed.message(), "name a folder that can be written to"};
}

// Removes the parts of units with this noun that do not belong to a run.
void remove_other_parts(const std::string& folder, std::string_view noun, const DealtUnits& run) {
  for (const int unit : units_with_parts(folder, noun)) {
    const std::string part = part_path(folder, noun, unit);
    std::error_code failed;
    if (!read_part(part, run, unit)) fs::remove(part, failed);
  }
}

// Creates out_folder/parts and states there which run the parts belong to. Parts and traces of
// another run are removed.
std::optional<Error> prepare_folder(const std::string& folder, const DealtRun& run) {
  if (auto error = create_parts_folder(folder)) return error;
  const std::string path = part_identity_path(folder);
  const auto found = read_settings_text(path);
  if (found && *found == run.identity_json) return std::nullopt;
  if (found) {
    remove_traces(folder);
    for (const RunKindWords& words : kRunKinds) remove_other_parts(folder, words.noun, run.units);
  }
  auto file = WholeFile::create(path);
  if (!file) return file.error();
  file->add(run.identity_json);
  return file->finish();
}

// The threads that compute units, and what they share.
class DealtJobs {
 public:
  DealtJobs(const DealtRun& run, const std::string& folder, const StopFlag* stop)
      : run_(run), folder_(folder), stop_(stop), log_(log_path(folder)) {}

  // Computes the units and returns those that are complete, in ascending order.
  Result<std::vector<int>> compute(std::vector<int> units, int jobs,
                                   const std::function<void(const RunProgress&)>& progress);

 private:
  void work();
  void compute_one(int unit);
  void fail(Error error);
  bool goes_on() const { return !has_failed_.load() && !(stop_ && stop_->requested()); }
  RunProgress progress_now() const;

  const DealtRun& run_;
  const std::string& folder_;
  const StopFlag* stop_;
  RunLog log_;

  std::vector<int> units_;
  std::uint64_t trials_ = 0;  // of all units
  Clock::time_point start_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::uint64_t> trials_done_{0};
  std::atomic<bool> has_failed_{false};
  std::mutex mutex_;  // of the members below
  std::optional<Error> error_;
  std::vector<int> complete_;
};

void DealtJobs::fail(Error error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  has_failed_.store(true);
}

void DealtJobs::compute_one(int unit) {
  const Clock::time_point start = Clock::now();
  const std::uint64_t all_trials = run_.trials(unit);
  std::uint64_t trials = 0;
  const auto computed = run_.compute(unit, [&] {
    ++trials;
    trials_done_.fetch_add(1);
    return goes_on() || trials == all_trials;
  });
  if (!computed) return fail(computed.error());
  if (!*computed) return;
  const UnitRun& done = **computed;
  const std::string& noun = run_.units.noun;
  if (auto error = write_part(part_path(folder_, noun, unit), run_.units, unit, done.rows)) {
    return fail(*error);
  }
  log_.add(noun + " " + std::to_string(unit) + ": " +
           computing_text(trials, done.ticks, seconds_since(start), done.loop_ns));
  const std::lock_guard lock(mutex_);
  complete_.push_back(unit);
}

void DealtJobs::work() {
  while (goes_on()) {
    const std::size_t place = next_.fetch_add(1);
    if (place >= units_.size()) return;
    try {
      compute_one(units_[place]);
    } catch (const std::bad_alloc&) {
      fail({ErrorCode::kOutOfMemory, "", "", "the system refused memory",
            "use fewer jobs, or free memory"});
    }
  }
}

RunProgress DealtJobs::progress_now() const {
  const auto done = static_cast<double>(trials_done_.load());
  const auto all = static_cast<double>(trials_);
  if (done == 0.0) return {};
  return {done / all, seconds_since(start_) * (all - done) / done};
}

Result<std::vector<int>> DealtJobs::compute(
    std::vector<int> units, int jobs, const std::function<void(const RunProgress&)>& progress) {
  units_ = std::move(units);
  for (const int unit : units_) trials_ += run_.trials(unit);
  start_ = Clock::now();
  log_.add("run " + hash_text(run_.units.identity) + ": " + std::to_string(units_.size()) + " " +
           run_.units.noun + "s to compute with " + std::to_string(jobs) + " jobs");
  std::vector<std::future<void>> threads;
  const std::size_t count = std::min(units_.size(), static_cast<std::size_t>(jobs));
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

std::vector<int> units_of(const Shard& shard, int units) {
  std::vector<int> numbers;
  for (int unit = shard.number; unit <= units; unit += shard.count) numbers.push_back(unit);
  return numbers;
}

Result<DealtOutcome> run_dealt(const DealtRun& run, const DealtSettings& settings,
                               const std::function<void(const RunProgress&)>& progress,
                               const StopFlag* stop) {
  const std::string& folder = settings.out_folder;
  const std::vector<int> units = units_of(settings.shard.value_or(Shard{}), run.units.count);
  if (auto error = check_paths(written_paths(run, settings, units))) return *error;
  if (auto error = prepare_folder(folder, run)) return *error;

  DealtOutcome outcome;
  std::vector<int> to_compute;
  for (const int unit : units) {
    const bool is_there =
        read_part(part_path(folder, run.units.noun, unit), run.units, unit).ok() &&
        (!run.has_other_files || run.has_other_files(unit));
    (is_there ? outcome.kept : to_compute).push_back(unit);
  }
  DealtJobs jobs(run, folder, stop);
  auto computed = jobs.compute(to_compute, settings.jobs, progress);
  if (!computed) return computed.error();
  outcome.computed = std::move(*computed);
  std::set_difference(to_compute.begin(), to_compute.end(), outcome.computed.begin(),
                      outcome.computed.end(), std::back_inserter(outcome.not_done));
  return outcome;
}

}  // namespace palpate
