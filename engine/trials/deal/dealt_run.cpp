#include "engine/trials/deal/dealt_run.h"

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

#include <nlohmann/json.hpp>

#include "engine/report/whole_file.h"
#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/deal/run_identity.h"
#include "engine/trials/deal/run_log.h"
#include "engine/trials/deal/shard_locks.h"
#include "engine/trials/deal/traces_folder.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/strict_json.h"
#include "geometry/base/file_roles.h"
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
  for (const int unit : units) {
    paths.push_back(part_path(folder, run.units.noun, unit));
    paths.push_back(journal_path(folder, run.units.noun, unit));
  }
  if (settings.shard) return paths;
  for (const std::string& name : run.result_names) {
    paths.push_back((fs::path(folder) / name).string());
  }
  return paths;
}

// Registers these paths as outputs (file_roles.h). An error if one is an input, or if something
// other than a file has it, such as a folder or a pipe: this would be found when the trials have
// run, and opening a pipe waits for a reader.
std::optional<Error> add_outputs(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    if (auto error = add_output(path)) return error;
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (!fs::exists(status) || fs::is_regular_file(status)) continue;
    return Error{ErrorCode::kFileUnwritable, path, "",
                 "is not a file, but a result needs this name",
                 "move it, or choose another folder"};
  }
  return std::nullopt;
}

std::optional<Error> create_run_folder(const std::string& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (!failed) return std::nullopt;
  return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
               "cannot be created: " + failed.message(), "name a folder that can be written to"};
}

std::optional<Error> create_parts_folder(const std::string& folder) {
  std::error_code failed;
  fs::create_directories(parts_folder(folder), failed);
  if (!failed) return std::nullopt;
  return Error{ErrorCode::kFileUnwritable, parts_folder(folder), "",
               "cannot be created: " + failed.message(),
               "move what has this name, or choose another folder"};
}

// The text of one of the program's own files; empty if it cannot be read. An error if a standard
// stream is redirected to it.
Result<std::string> own_text(const std::string& path) {
  const OwnResultsScope own;
  const auto text = read_settings_text(path);
  if (!text && text.error().code == ErrorCode::kFileUnwritable) return text.error();
  return text ? *text : std::string();
}

// The hash of a run, as a text of the entry "run" of its identity or of its results states it.
std::string stated_run(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  const bool has_run = json.is_object() && json.contains("run") && json["run"].is_string();
  return has_run ? json["run"].get<std::string>() : std::string();
}

bool has_unit_files(const std::string& folder) {
  return std::any_of(kRunKinds.begin(), kRunKinds.end(), [&](const RunKindWords& words) {
    return !units_with_parts(folder, words.noun).empty() ||
           !units_with_journals(folder, words.noun).empty();
  });
}

// Removes the files of units that do not belong to a run.
void remove_other_units(const std::string& folder, std::string_view noun, const DealtUnits& run) {
  std::error_code failed;
  for (const int unit : units_with_parts(folder, noun)) {
    const std::string part = part_path(folder, noun, unit);
    if (!read_part(part, run, unit)) fs::remove(part, failed);
  }
  for (const int unit : units_with_journals(folder, noun)) {
    const std::string journal = journal_path(folder, noun, unit);
    if (!TrialJournal::open(journal, run, unit)) fs::remove(journal, failed);
  }
}

// The error if the files of units in the folder are of another run. found: the identity of that
// run.
Error other_run_error(const std::string& folder, const std::string& found, const DealtRun& run) {
  Error error{ErrorCode::kInvalidContent, part_identity_path(folder), "",
              "does not say which run the files beside it belong to", ""};
  const auto theirs = parse_identity(found, error.path);
  const auto mine = parse_identity(run.identity_json, "this run");
  const auto difference =
      theirs && mine ? find_difference(*theirs, *mine, "this run") : std::nullopt;
  if (difference) {
    error.element = difference->element;
    error.problem = difference->problem;
  }
  error.problem += "; the trials of that run are in no results yet, and would be lost";
  error.hint = "choose another folder, or remove " + parts_folder(folder);
  return error;
}

// States in out_folder/parts which run the parts belong to. Parts and traces of another run whose
// results are there are removed.
std::optional<Error> prepare_parts(const std::string& folder, const DealtRun& run,
                                   const ShardLocks& locks) {
  const std::string path = part_identity_path(folder);
  const auto own = own_text(path);
  if (!own) return own.error();
  const std::string& found = *own;
  if (found == run.identity_json) return std::nullopt;
  if (locks.are_others_running()) {
    return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
                 "is in use: a shard of another run is writing there",
                 "wait until it has ended, or choose another folder"};
  }
  if (has_unit_files(folder)) {
    const auto results = own_text((fs::path(folder) / kRunFile).string());
    if (!results) return results.error();
    const bool is_merged = !stated_run(found).empty() && stated_run(found) == stated_run(*results);
    if (!is_merged) return other_run_error(folder, found, run);
  }
  if (!found.empty()) {
    remove_traces(folder);
    for (const RunKindWords& words : kRunKinds) remove_other_units(folder, words.noun, run.units);
  }
  auto file = WholeFile::create(path);
  if (!file) return file.error();
  file->add(run.identity_json);
  return file->finish();
}

// The locks of a running process.
struct FolderLocks {
  std::vector<OutputLock> folders;
  ShardLocks shards;
};

// The error if the folder is one of parts: its files would be taken for those of another run.
std::optional<Error> check_is_no_parts_folder(const std::string& folder) {
  const auto text = own_text((fs::path(folder) / kRunFile).string());
  if (!text) return text.error();
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (stated_run(*text).empty() || json.contains("palpate_run")) return std::nullopt;
  return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
               "has the parts of another run", "choose another folder"};
}

// Keeps other processes out of the folder, but for other shards, and prepares it.
Result<FolderLocks> prepare_folder(const std::string& folder, const DealtRun& run,
                                   const DealtSettings& settings, const std::vector<int>& units) {
  if (auto error = create_run_folder(folder)) return *error;
  const FolderUse use = settings.shard ? FolderUse::kShard : FolderUse::kAlone;
  auto of_folder = OutputLock::take(folder, use);
  if (!of_folder) return of_folder.error();
  if (auto error = check_is_no_parts_folder(folder)) return *error;
  if (auto error = create_parts_folder(folder)) return *error;
  // The folder of another command may be this subfolder.
  auto of_parts = OutputLock::take(parts_folder(folder), use);
  if (!of_parts) return of_parts.error();
  ShardLocks shards(log_path(folder));
  if (auto error = prepare_parts(folder, run, shards)) return *error;
  if (const auto unit = shards.take(units)) {
    return Error{ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`",
                 "is in use: another process computes " + run.units.noun + " " +
                     std::to_string(*unit) + " there",
                 "wait until it has ended, or choose another folder"};
  }
  shards.end_preparation();
  return FolderLocks{{std::move(*of_folder), std::move(*of_parts)}, std::move(shards)};
}

void remove_journal(const std::string& folder, const DealtUnits& units, int unit) {
  std::error_code ignored;
  fs::remove(journal_path(folder, units.noun, unit), ignored);
}

// The threads that compute units, and what they share.
class DealtJobs {
 public:
  DealtJobs(const DealtRun& run, const std::string& folder, const StopFlag* stop)
      : run_(run), folder_(folder), stop_(stop), log_(log_path(folder)) {}

  // Reads the journals of the units to compute. Call it before compute().
  std::optional<Error> read_journals(std::vector<int> units);
  // Computes the units and returns those that are complete, in ascending order.
  Result<std::vector<int>> compute(int jobs,
                                   const std::function<void(const RunProgress&)>& progress);
  // The number of trials that the journals had.
  std::uint64_t kept_trials() const { return kept_trials_; }

 private:
  void work();
  void compute_one(std::size_t place);
  void fail(Error error);
  bool goes_on() const { return !has_failed_.load() && !(stop_ && stop_->requested()); }
  RunProgress progress_now() const;

  const DealtRun& run_;
  const std::string& folder_;
  const StopFlag* stop_;
  RunLog log_;

  std::vector<int> units_;
  std::vector<TrialJournal> journals_;  // of each of the units
  std::uint64_t trials_ = 0;            // of all units
  std::uint64_t kept_trials_ = 0;
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

std::optional<Error> DealtJobs::read_journals(std::vector<int> units) {
  units_ = std::move(units);
  const std::string& noun = run_.units.noun;
  for (const int unit : units_) {
    auto journal = TrialJournal::open(journal_path(folder_, noun, unit), run_.units, unit);
    if (!journal) return journal.error();
    kept_trials_ += journal->count();
    trials_ += run_.trials(unit);
    journals_.push_back(std::move(*journal));
  }
  return std::nullopt;
}

void DealtJobs::compute_one(std::size_t place) {
  const int unit = units_[place];
  TrialJournal& journal = journals_[place];
  const Clock::time_point start = Clock::now();
  const std::uint64_t all_trials = run_.trials(unit);
  std::uint64_t computed_trials = 0;
  UnitTrials trials(journal, [&](std::uint64_t trial) {
    ++computed_trials;
    trials_done_.fetch_add(1);
    return goes_on() || trial == all_trials;
  });
  const auto computed = run_.compute(unit, trials);
  if (!computed) return fail(computed.error());
  if (!*computed) return;
  const UnitRun& done = **computed;
  const std::string& noun = run_.units.noun;
  if (auto error = write_part(part_path(folder_, noun, unit), run_.units, unit, done.rows)) {
    return fail(*error);
  }
  journal.remove();
  log_.add(noun + " " + std::to_string(unit) + ": " +
           computing_text(computed_trials, done.ticks, seconds_since(start), done.loop_ns));
  const std::lock_guard lock(mutex_);
  complete_.push_back(unit);
}

void DealtJobs::work() {
  while (goes_on()) {
    const std::size_t place = next_.fetch_add(1);
    if (place >= units_.size()) return;
    try {
      compute_one(place);
    } catch (const std::bad_alloc&) {
      fail({ErrorCode::kOutOfMemory, "", "", "the system refused memory",
            "use fewer jobs, or free memory"});
    }
  }
}

RunProgress DealtJobs::progress_now() const {
  const auto all = static_cast<double>(trials_);
  const auto kept = static_cast<double>(kept_trials_);
  return {(kept + static_cast<double>(trials_done_.load())) / all, kept / all};
}

Result<std::vector<int>> DealtJobs::compute(
    int jobs, const std::function<void(const RunProgress&)>& progress) {
  log_.add("run " + hash_text(run_.units.identity) + ": " + std::to_string(units_.size()) + " " +
           run_.units.noun + "s to compute with " + std::to_string(jobs) + " jobs" +
           (kept_trials_ > 0
                ? ", without " + std::to_string(kept_trials_) + " trials that are finished"
                : ""));
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
  if (error_) {
    if (error_->code == ErrorCode::kFileUnwritable) {
      error_->hint += "; finished trials are kept, and the same command goes on from there";
    }
    return *error_;
  }
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
  if (auto error = add_outputs(written_paths(run, settings, units))) return *error;
  auto locks = prepare_folder(folder, run, settings, units);
  if (!locks) return locks.error();

  DealtOutcome outcome;
  outcome.locks = std::move(locks->folders);
  std::vector<int> to_compute;
  for (const int unit : units) {
    const auto part = read_part(part_path(folder, run.units.noun, unit), run.units, unit);
    if (!part && part.error().code == ErrorCode::kFileUnwritable) return part.error();
    const bool is_there = part.ok() && (!run.has_other_files || run.has_other_files(unit));
    (is_there ? outcome.kept : to_compute).push_back(unit);
    // A process that was killed as it completed the unit has left its journal.
    if (is_there) remove_journal(folder, run.units, unit);
  }
  DealtJobs jobs(run, folder, stop);
  if (auto error = jobs.read_journals(to_compute)) return *error;
  outcome.kept_trials = jobs.kept_trials();
  auto computed = jobs.compute(settings.jobs, progress);
  if (!computed) return computed.error();
  outcome.computed = std::move(*computed);
  std::set_difference(to_compute.begin(), to_compute.end(), outcome.computed.begin(),
                      outcome.computed.end(), std::back_inserter(outcome.not_done));
  for (const int unit : outcome.not_done) {
    const auto journal =
        TrialJournal::open(journal_path(folder, run.units.noun, unit), run.units, unit);
    if (journal) outcome.trials_done += journal->count();
  }
  return outcome;
}

}  // namespace palpate
