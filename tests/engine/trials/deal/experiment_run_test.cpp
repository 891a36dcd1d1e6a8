// Shards, jobs, interruptions and merging, with a stand-in for the trial.

#include "engine/trials/deal/experiment_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/deal/trial_journal.h"
#include "engine/trials/deal/unit_part.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/random.h"
#include "tests/engine/trials/stand_in_trial.h"
#include "tests/helpers/child_process.h"
#include "tests/helpers/deadly_rename.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using std::chrono::microseconds;
using test::run_in_child;
using test::stand_in_trials;
using test::TemporaryFolder;

constexpr int kParticipants = 9;

nlohmann::json small_plan_json() {
  return nlohmann::json::parse(R"({"palpate_plan": 1, "name": "small", "seed": 7,
      "participants": 9, "blocks": 1, "practice_blocks": 1,
      "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                 "damping_Ns_per_m": 2},
      "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
      "haptic": ["NoH", "H"], "rotation": ["NoR", "R"],
      "objects": {"O1": "star.glb", "O2": {"file": "star.glb", "scale": 0.5}},
      "operator": "literature", "followings": ["delayed", "replan"]})");
}

ExperimentPlan plan_of(const nlohmann::json& json) {
  auto plan = parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR);
  EXPECT_TRUE(plan.ok()) << plan.error().to_string();
  return *plan;
}

ExperimentPlan small_plan() {
  return plan_of(small_plan_json());
}

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The bytes of all results.
std::string results_in(const std::string& folder) {
  std::string all;
  for (const char* name : {kTrialsFile, kColumnsFile, kRunFile}) {
    const std::string text = content((fs::path(folder) / name).string());
    EXPECT_FALSE(text.empty()) << folder << " " << name;
    all += text;
  }
  return all;
}

// All files below a folder, by their path below it.
std::set<std::string> files_below(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), folder).string());
  }
  return names;
}

std::string part_of(const std::string& folder, int participant) {
  return part_path(folder, "participant", participant);
}

std::vector<int> participants_with_parts(const std::string& folder) {
  return units_with_parts(folder, "participant");
}

ExperimentRunOutcome run_into(const std::string& folder, const ExperimentPlan& plan,
                              std::optional<Shard> shard = {}, int jobs = 1) {
  const auto outcome = run_experiment(plan, {folder, shard, jobs, false}, stand_in_trials());
  EXPECT_TRUE(outcome.ok()) << outcome.error().to_string();
  return outcome ? *outcome : ExperimentRunOutcome{};
}

// The results of an undisturbed run with one job.
const std::string& reference() {
  static const std::string results = [] {
    const TemporaryFolder folder;
    run_into(folder.path(), small_plan());
    return results_in(folder.path());
  }();
  return results;
}

// Trials of which the last one kills the process. trials: how many begin, at least 1. Other threads
// begin no trial after it: they may run for some time before the kill reaches them.
TrialFunctions deadly_trials(std::size_t trials) {
  TrialFunctions functions = stand_in_trials();
  functions.run = [left = std::make_shared<std::atomic<long>>(static_cast<long>(trials)),
                   run = functions.run](auto&&... arguments) {
    if (left->fetch_sub(1) <= 1) {
      ::kill(::getpid(), SIGKILL);
      ::pause();
    }
    return run(arguments...);
  };
  return functions;
}

// What holds in the folder of an experiment whenever its process is killed: a result or a part is
// whole or absent, and run.json is there only beside the other results.
void expect_whole_files(const std::string& out) {
  static const std::map<std::string, std::string> whole = [] {
    const TemporaryFolder folder;
    run_into(folder.path(), small_plan());
    std::map<std::string, std::string> contents;
    for (const std::string& name : files_below(folder.path())) {
      if (name != "run.log") contents[name] = content(folder.path(name));
    }
    return contents;
  }();
  std::set<std::string> results;
  for (const auto& [name, text] : whole) {
    const std::string path = (fs::path(out) / name).string();
    if (!fs::exists(path)) continue;
    EXPECT_EQ(content(path), text) << name;
    if (!name.starts_with("parts/")) results.insert(name);
  }
  EXPECT_TRUE(results.size() == 3 || !results.contains(kRunFile))
      << "run.json without other results";
}

// The files of a complete experiment; the program leaves no others.
std::set<std::string> expected_files() {
  std::set<std::string> names{"trials.csv", "columns.csv", "run.json", "run.log", "parts/run.json"};
  for (int p = 1; p <= kParticipants; ++p) {
    names.insert("parts/participant-" + std::to_string(p) + ".csv");
  }
  return names;
}

TEST(ExperimentRun, WritesEveryPlannedTrialOnce) {
  const TemporaryFolder folder;
  const ExperimentPlan plan = small_plan();
  const ExperimentRunOutcome outcome = run_into(folder.path(), plan);
  EXPECT_EQ(outcome.computed.size(), 9u);
  ASSERT_TRUE(outcome.merged.has_value());
  const auto rows = read_trials(folder.path(kTrialsFile));
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->size(), 9u * 2 * 2 * 8);
  EXPECT_EQ(outcome.merged->trials, rows->size());
  EXPECT_EQ(std::accumulate(outcome.merged->by_status.begin(), outcome.merged->by_status.end(),
                            std::uint64_t{0}),
            rows->size());
  // Each block of each participant and following has each condition once, in places 1 to 8.
  std::map<std::string, std::set<int>> places;
  std::set<std::string> orders;
  std::map<std::string, std::string> order;
  for (const TrialRow& row : *rows) {
    const std::string block = row.participant + " " + std::to_string(row.block);
    places[row.following + " " + block].insert(row.trial);
    order[row.following + " " + block] += row.haptic + row.rotation + row.object + " ";
  }
  EXPECT_EQ(places.size(), 9u * 2 * 2);
  for (const auto& [block, numbers] : places) {
    EXPECT_EQ(numbers.size(), 8u);
    EXPECT_EQ(*numbers.begin(), 1);
    EXPECT_EQ(*numbers.rbegin(), 8);
    orders.insert(order[block]);
  }
  EXPECT_EQ(orders.size(), 9u * 2) << "the followings share the order, participants and blocks not";
}

TEST(ExperimentRun, FollowingsShareTheRandomNumbers) {
  const TemporaryFolder folder;
  run_into(folder.path(), small_plan());
  std::map<std::string, std::string> without_rotation;
  std::map<std::string, std::string> with_rotation;
  const auto rows = read_trials(folder.path(kTrialsFile));
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  for (TrialRow row : *rows) {
    const std::string following = row.following;
    row.following.clear();
    CsvLines lines("");
    lines.clear();
    add_row(lines, row);
    (row.rotation == "NoR" ? without_rotation : with_rotation)[following] += lines.text();
  }
  EXPECT_EQ(without_rotation["delayed"], without_rotation["replan"]);
  EXPECT_NE(with_rotation["delayed"], with_rotation["replan"]);
}

TEST(ExperimentRun, GivesTheSameBytesWithAnyNumberOfJobs) {
  for (const int jobs : {1, 2, 5, 20}) {
    const TemporaryFolder folder;
    run_into(folder.path(), small_plan(), {}, jobs);
    EXPECT_EQ(results_in(folder.path()), reference()) << jobs << " jobs";
  }
}

TEST(ExperimentRun, ShardsInAnyOrderGiveTheSameBytes) {
  constexpr std::uint64_t kSeed = 18;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  for (int count = 1; count <= 7; ++count) {
    for (const bool in_one_folder : {false, true}) {
      SCOPED_TRACE(std::to_string(count) + " shards");
      const TemporaryFolder folder;
      std::vector<int> numbers(static_cast<std::size_t>(count));
      std::iota(numbers.begin(), numbers.end(), 1);
      for (std::size_t left = numbers.size(); left > 1; --left) {
        std::swap(numbers[left - 1], numbers[random.index(left)]);
      }
      std::vector<std::string> folders;
      for (const int number : numbers) {
        folders.push_back(folder.path(in_one_folder ? "all" : std::to_string(number)));
        const auto outcome = run_into(folders.back(), small_plan(), Shard{number, count});
        EXPECT_FALSE(outcome.merged.has_value());
        EXPECT_FALSE(fs::exists(fs::path(folders.back()) / kTrialsFile));
      }
      if (in_one_folder) folders = {folders.front()};
      const auto merged = merge_experiment(folders, folder.path("out"));
      ASSERT_TRUE(merged.ok()) << merged.error().to_string();
      EXPECT_EQ(results_in(folder.path("out")), reference());
    }
  }
}

TEST(ExperimentRun, ShardsThatAreKilledAndStartedAgainGiveTheSameBytes) {
  constexpr std::uint64_t kSeed = 5;
  constexpr std::size_t kTrialsEach = 2 * 2 * 8;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  const ExperimentPlan plan = small_plan();
  for (int count = 1; count <= 7; ++count) {
    const TemporaryFolder folder;
    std::vector<std::string> folders;
    for (int number = 1; number <= count; ++number) {
      folders.push_back(folder.path(std::to_string(number)));
      const Shard shard{number, count};
      const std::size_t participants = units_of(shard, kParticipants).size();
      const std::size_t all = participants * kTrialsEach;
      for (std::size_t finished = 0; finished < all;) {
        // A start kills itself in its first or second participant, unless it ends before.
        const std::size_t trials = 1 + random.index(2 * kTrialsEach);
        const bool is_over = run_in_child([&] {
          return run_experiment(plan, {folders.back(), shard, 1, false}, deadly_trials(trials))
              .ok();
        });
        EXPECT_EQ(is_over, trials > all - finished) << "a finished trial runs again";
        finished = is_over ? all : finished + trials - 1;
        EXPECT_EQ(participants_with_parts(folders.back()).size(), finished / kTrialsEach);
        expect_whole_files(folders.back());
      }
      EXPECT_EQ(run_into(folders.back(), plan, shard).kept.size(), participants);
    }
    const auto merged = merge_experiment(folders, folder.path("out"));
    ASSERT_TRUE(merged.ok()) << merged.error().to_string();
    EXPECT_EQ(results_in(folder.path("out")), reference());
  }
}

TEST(ExperimentRun, KilledBetweenAnyTwoRenamesLeavesWholeFiles) {
  constexpr int kRenames = 1 + kParticipants + 3;  // parts/run.json, the parts and the results
  for (int last = 1; last <= kRenames; ++last) {
    SCOPED_TRACE(last);
    const TemporaryFolder folder;
    const std::string out = folder.path("out");
    EXPECT_FALSE(run_in_child([&] {
      test::die_at_rename(last);
      return run_experiment(small_plan(), {out, {}, 1, false}, stand_in_trials()).ok();
    }));
    expect_whole_files(out);
    const std::size_t parts = static_cast<std::size_t>(std::clamp(last - 2, 0, kParticipants));
    EXPECT_EQ(participants_with_parts(out).size(), parts);
    EXPECT_EQ(run_into(out, small_plan()).kept.size(), parts);
    EXPECT_EQ(results_in(out), reference());
    EXPECT_EQ(files_below(out), expected_files());
  }
}

TEST(ExperimentRun, ARunWithTwoJobsThatIsKilledAtAnyInstantResumes) {
  const ExperimentPlan plan = small_plan();
  const TrialFunctions slow = stand_in_trials(microseconds(200));
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  EXPECT_FALSE(run_in_child([&] {
    return run_experiment(plan, {out, {}, 2, false}, deadly_trials(100)).ok();
  }));
  const std::size_t complete = participants_with_parts(out).size();
  EXPECT_GE(complete, 2u);  // 100 trials without 32 of each running participant
  EXPECT_LE(complete, 3u);
  expect_whole_files(out);
  // Each start has more time than the last one, so that also a slow machine reaches the end.
  const auto run = [&] { return run_experiment(plan, {out, {}, 2, false}, slow).ok(); };
  int kills = 0;
  for (microseconds life(1000); !run_in_child(life, run); life += life / 4) {
    ++kills;
    expect_whole_files(out);
  }
  std::cout << kills << " kills by time\n";
  EXPECT_EQ(results_in(out), reference());
  const ExperimentRunOutcome again = run_into(out, plan);
  EXPECT_EQ(again.kept.size(), 9u);
  EXPECT_TRUE(again.computed.empty());
  EXPECT_EQ(results_in(out), reference());
  EXPECT_EQ(files_below(out), expected_files());
}

TEST(ExperimentRun, AShardRunTwiceGivesTheSameBytes) {
  const ExperimentPlan plan = small_plan();
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  for (const int number : {2, 1, 2}) run_into(out, plan, Shard{number, 2});
  EXPECT_EQ(run_into(out, plan, Shard{1, 2}).kept.size(), 5u);
  ASSERT_TRUE(merge_experiment({out}, out).ok());
  EXPECT_EQ(results_in(out), reference());
}

// A child process that runs a shard, or a whole experiment, and stands still in its first trial
// until it is released.
class StandingRun {
 public:
  StandingRun(const std::string& out, std::optional<Shard> shard) {
    EXPECT_EQ(::pipe(begun_.data()), 0);
    EXPECT_EQ(::pipe(released_.data()), 0);
    child_ = ::fork();
    if (child_ != 0) {
      char byte = 0;
      EXPECT_EQ(::read(begun_[0], &byte, 1), 1);
      return;
    }
    TrialFunctions functions = stand_in_trials();
    functions.run = [this, is_first = true, run = functions.run](auto&&... arguments) mutable {
      char byte = 0;
      if (is_first && (::write(begun_[1], &byte, 1) != 1 || ::read(released_[0], &byte, 1) != 1)) {
        ::_exit(2);
      }
      is_first = false;
      return run(arguments...);
    };
    ::_exit(run_experiment(small_plan(), {out, shard, 1, false}, functions).ok() ? 0 : 1);
  }
  // Lets it go on, and waits for its end.
  void release() {
    const char byte = 0;
    EXPECT_EQ(::write(released_[1], &byte, 1), 1);
    EXPECT_TRUE(test::has_ended(child_));
  }
  void kill() {
    ::kill(child_, SIGKILL);
    EXPECT_FALSE(test::has_ended(child_));
  }

 private:
  pid_t child_ = 0;
  std::array<int, 2> begun_{};
  std::array<int, 2> released_{};
};

void expect_in_use(const std::string& out, const ExperimentPlan& plan, std::optional<Shard> shard) {
  const auto refused = run_experiment(plan, {out, shard, 1, false}, stand_in_trials());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kFileUnwritable);
  EXPECT_EQ(refused.error().path, out);
  EXPECT_NE(refused.error().problem.find("is in use"), std::string::npos)
      << refused.error().problem;
}

TEST(ExperimentRun, ASecondRunInTheFolderOfARunningOneIsRefused) {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  nlohmann::json other = small_plan_json();
  other["seed"] = 8;
  StandingRun first(out, {});
  const std::set<std::string> before = files_below(out);
  expect_in_use(out, small_plan(), {});
  expect_in_use(out, small_plan(), Shard{2, 2});
  expect_in_use(out, plan_of(other), {});
  EXPECT_EQ(files_below(out), before);
  first.release();
  EXPECT_EQ(results_in(out), reference());
  StandingRun killed(out + "-2", {});
  killed.kill();
  run_into(out + "-2", small_plan());
  EXPECT_EQ(results_in(out + "-2"), reference()) << "the lock of a killed run is gone";
}

TEST(ExperimentRun, ShardsShareAFolderUnlessTheyHaveAParticipantInCommon) {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  nlohmann::json other = small_plan_json();
  other["seed"] = 8;
  StandingRun first(out, Shard{1, 2});
  expect_in_use(out, small_plan(), Shard{1, 2});
  expect_in_use(out, small_plan(), Shard{2, 3});  // both have participant 5
  expect_in_use(out, small_plan(), {});
  expect_in_use(out, plan_of(other), Shard{2, 2});
  run_into(out, small_plan(), Shard{2, 2});
  first.release();
  ASSERT_TRUE(merge_experiment({out}, out).ok());
  EXPECT_EQ(results_in(out), reference());
}

// The journal of participant 1 of small_plan() after `trials` trials.
std::string journal_text(std::size_t trials) {
  const TemporaryFolder folder;
  EXPECT_FALSE(run_in_child([&] {
    return run_experiment(small_plan(), {folder.path("out"), {}, 1, false},
                          deadly_trials(trials + 1))
        .ok();
  }));
  return content(journal_path(folder.path("out"), "participant", 1));
}

// The number of trials that a run of the plan computes.
std::size_t trials_computed(const std::string& out, const ExperimentPlan& plan) {
  std::atomic<std::size_t> trials{0};
  TrialFunctions functions = stand_in_trials();
  functions.run = [&, run = functions.run](auto&&... arguments) {
    ++trials;
    return run(arguments...);
  };
  EXPECT_TRUE(run_experiment(plan, {out, {}, 1, false}, functions).ok());
  return trials;
}

TEST(TrialJournal, LosesNoMoreThanTheTrialThatWasCut) {
  const std::string three = journal_text(3);
  const std::string two = journal_text(2);
  const std::string one = journal_text(1);
  ASSERT_TRUE(three.starts_with(two) && two.starts_with(one));
  const std::uint64_t run = std::stoull(three.substr(three.find("run ") + 4, 16), nullptr, 16);
  const DealtUnits units{"participant", kParticipants, run, trials_columns()};
  const TemporaryFolder folder;
  for (std::size_t bytes = 0; bytes <= three.size(); ++bytes) {
    const std::string path = folder.write("cut.trials", three.substr(0, bytes));
    auto journal = TrialJournal::open(path, units, 1);
    ASSERT_TRUE(journal.ok()) << bytes << ": " << journal.error().to_string();
    const std::size_t whole =
        (bytes >= one.size()) + (bytes >= two.size()) + std::size_t{bytes == three.size()};
    EXPECT_EQ(journal->count(), whole) << bytes;
    // What is appended stands behind the last whole trial.
    ASSERT_FALSE(journal->add(7, "some,rows\n"));
    const auto again = TrialJournal::open(path, units, 1);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->count(), whole + 1) << bytes;
    ASSERT_TRUE(again->rows_of(7));
    EXPECT_EQ(*again->rows_of(7), "some,rows\n");
  }
  for (std::size_t at = two.size(); at < three.size(); ++at) {
    std::string changed = three;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    const auto journal = TrialJournal::open(folder.write("changed.trials", changed), units, 1);
    ASSERT_TRUE(journal.ok());
    EXPECT_EQ(journal->count(), 2u) << at;
  }
  const auto other = TrialJournal::open(folder.write("other.trials", three), units, 2);
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().element, "line 1");
}

TEST(ExperimentRun, AKilledRunKeepsEachFinishedTrial) {
  const ExperimentPlan plan = small_plan();
  constexpr std::size_t kTrials = kParticipants * 2 * 2 * 8;
  for (const std::size_t finished : {1u, 31u, 32u, 33u, 100u, 287u}) {
    SCOPED_TRACE(finished);
    const TemporaryFolder folder;
    const std::string out = folder.path("out");
    EXPECT_FALSE(run_in_child([&] {
      return run_experiment(plan, {out, {}, 1, false}, deadly_trials(finished + 1)).ok();
    }));
    EXPECT_EQ(trials_computed(out, plan), kTrials - finished);
    EXPECT_EQ(results_in(out), reference());
    EXPECT_EQ(files_below(out), expected_files()) << "no journal is left";
  }
}

TEST(ExperimentRun, UnfinishedTrialsOfAnotherRunAreRefusedAndStay) {
  for (const std::size_t finished : {1u, 32u, 40u}) {  // a journal, a part, both
    const TemporaryFolder folder;
    const std::string out = folder.path("out");
    nlohmann::json other = small_plan_json();
    other["seed"] = 8;
    EXPECT_FALSE(run_in_child([&] {
      return run_experiment(small_plan(), {out, {}, 1, false}, deadly_trials(finished + 1)).ok();
    }));
    for (const auto& shard : {std::optional<Shard>(), std::optional(Shard{2, 2})}) {
      const auto refused =
          run_experiment(plan_of(other), {out, shard, 1, false}, stand_in_trials());
      ASSERT_FALSE(refused.ok());
      EXPECT_EQ(refused.error().path, part_identity_path(out));
      EXPECT_EQ(refused.error().element, "/plan/hash");
      EXPECT_NE(refused.error().hint.find(parts_folder(out)), std::string::npos);
    }
    EXPECT_EQ(trials_computed(out, small_plan()), kParticipants * 2 * 2 * 8 - finished);
    EXPECT_EQ(results_in(out), reference());
    // Its results are there now, so that another run may replace the parts.
    EXPECT_EQ(run_into(out, plan_of(other)).computed.size(), 9u);
  }
}

// A process that may not write files beyond a size is refused like one with a full disk.
TEST(ExperimentRun, AFullDiskIsRefusedAndALaterRunResumes) {
  const ExperimentPlan plan = small_plan();
  const std::size_t part_bytes = [&] {
    const TemporaryFolder folder;
    run_into(folder.path(), plan, Shard{1, 9});
    return content(part_of(folder.path(), 1)).size();
  }();
  // No file at all; the identity, but no part; all parts, but not trials.csv.
  for (const std::size_t limit : {std::size_t{0}, part_bytes / 2, 2 * part_bytes}) {
    for (const std::optional<Shard>& shard : {std::optional<Shard>(), std::optional(Shard{1, 2})}) {
      const bool is_refused = limit < part_bytes || !shard;
      SCOPED_TRACE(std::to_string(limit) + (shard ? " bytes, shard" : " bytes"));
      const TemporaryFolder folder;
      const std::string out = folder.path("out");
      const bool is_over = run_in_child([&] {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit most{limit, limit};
        ::setrlimit(RLIMIT_FSIZE, &most);
        const auto outcome = run_experiment(plan, {out, shard, 2, false}, stand_in_trials());
        if (!is_refused) return outcome.ok();
        return !outcome && outcome.error().code == ErrorCode::kFileUnwritable &&
               outcome.error().path.starts_with(out) && !fs::exists(fs::path(out) / kTrialsFile);
      });
      EXPECT_TRUE(is_over);
      for (const std::string& name : files_below(out)) {
        EXPECT_EQ(name.find(".part"), std::string::npos) << name;
      }
      const ExperimentRunOutcome later = run_into(out, plan);
      EXPECT_EQ(later.kept.size(), limit > part_bytes ? (shard ? 5u : 9u) : 0u);
      EXPECT_EQ(later.kept_trials > 0, limit == part_bytes / 2) << "finished trials";
      EXPECT_EQ(results_in(out), reference());
    }
  }
}

TEST(ExperimentRun, ADamagedPartIsComputedAgain) {
  const ExperimentPlan plan = small_plan();
  const TemporaryFolder folder;
  run_into(folder.path(), plan);
  std::string part = content(part_of(folder.path(), 4));
  fs::resize_file(part_of(folder.path(), 3), part.size() / 2);
  part[part.size() - 10] ^= 1;
  std::ofstream(part_of(folder.path(), 4), std::ios::binary) << part;
  fs::remove(part_of(folder.path(), 9));
  EXPECT_EQ(run_into(folder.path(), plan).computed, (std::vector<int>{3, 4, 9}));
  EXPECT_EQ(results_in(folder.path()), reference());
}

TEST(ExperimentRun, AnotherPlanReplacesTheParts) {
  const TemporaryFolder folder;
  nlohmann::json other = small_plan_json();
  other["seed"] = 8;
  other["participants"] = 12;
  run_into(folder.path(), plan_of(other));
  EXPECT_EQ(run_into(folder.path(), small_plan()).computed.size(), 9u);
  EXPECT_EQ(results_in(folder.path()), reference());
}

TEST(ExperimentRun, AnEditedOperatorFileOrSceneReplacesTheParts) {
  const TemporaryFolder folder;
  nlohmann::json person = nlohmann::json::parse(shipped_operator_text("literature"));
  nlohmann::json json = small_plan_json();
  json["operator"] = folder.write("own.json", person.dump());
  json["objects"]["O1"] = folder.path("own.glb");
  const std::string models = PALPATE_MODELS_DIR;
  fs::copy_file(models + "/star.glb", folder.path("own.glb"));
  EXPECT_EQ(run_into(folder.path("out"), plan_of(json)).computed.size(), 9u);
  EXPECT_EQ(run_into(folder.path("out"), plan_of(json)).kept.size(), 9u);
  person["parameters"]["speed_m_per_s"]["high"] = 0.07;
  folder.write("own.json", person.dump());
  EXPECT_EQ(run_into(folder.path("out"), plan_of(json)).computed.size(), 9u);
  fs::copy_file(models + "/lock.glb", folder.path("own.glb"), fs::copy_options::overwrite_existing);
  EXPECT_EQ(run_into(folder.path("out"), plan_of(json)).computed.size(), 9u);
  EXPECT_EQ(run_into(folder.path("out"), plan_of(json)).kept.size(), 9u);
}

TEST(ExperimentRun, AStopLeavesCompleteParticipantsOnly) {
  const ExperimentPlan plan = small_plan();
  const TemporaryFolder folder;
  StopFlag stop;
  TrialFunctions functions = stand_in_trials();
  int trials = 0;
  functions.run = [&, run = functions.run](auto&&... arguments) {
    if (++trials == 32 * 2 + 5) stop.request();  // in the third participant
    return run(arguments...);
  };
  const auto outcome = run_experiment(plan, {folder.path(), {}, 1, false}, functions, {}, &stop);
  ASSERT_TRUE(outcome.ok()) << outcome.error().to_string();
  EXPECT_EQ(outcome->computed, (std::vector<int>{1, 2}));
  EXPECT_EQ(outcome->not_done, (std::vector<int>{3, 4, 5, 6, 7, 8, 9}));
  EXPECT_FALSE(outcome->merged.has_value());
  EXPECT_EQ(trials, 32 * 2 + 5);
  EXPECT_EQ(outcome->trials_done, 5u);
  const ExperimentRunOutcome again = run_into(folder.path(), plan);
  EXPECT_EQ(again.kept, (std::vector<int>{1, 2}));
  EXPECT_EQ(again.kept_trials, 5u);
  EXPECT_EQ(results_in(folder.path()), reference());
}

TEST(ExperimentRun, AnErrorOfATrialEndsTheRun) {
  const TemporaryFolder folder;
  TrialFunctions functions = stand_in_trials();
  functions.run = [](auto&&...) -> Result<TrialOutcome> {
    return invalid_argument("rate_Hz", "is wrong");
  };
  const auto outcome = run_experiment(small_plan(), {folder.path("out"), {}, 2, false}, functions);
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().problem, "is wrong");
  EXPECT_TRUE(participants_with_parts(folder.path("out")).empty());
}

TEST(ExperimentRun, TracesHaveEveryTickOfEveryTrial) {
  nlohmann::json json = small_plan_json();
  json["participants"] = 2;
  const ExperimentPlan plan = plan_of(json);
  const TemporaryFolder folder;
  const ExperimentRunSettings with_traces{folder.path(), {}, 2, true};
  EXPECT_EQ(run_into(folder.path(), plan).computed.size(), 2u);
  // The parts are there, but not their traces.
  ASSERT_EQ(run_experiment(plan, with_traces, stand_in_trials())->computed.size(), 2u);
  std::size_t traces = 0;
  for (const int participant : {1, 2}) {
    for (const PlannedTrial& trial : planned_trials(plan, participant)) {
      const std::string text = content(
          (fs::path(folder.path("traces")) / trace_name(plan, participant, trial)).string());
      EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 10);
      ++traces;
    }
  }
  EXPECT_EQ(traces, 2u * 32);
  EXPECT_TRUE(fs::exists(folder.path("traces/delayed/participant-2")));
  EXPECT_EQ(run_experiment(plan, with_traces, stand_in_trials())->kept.size(), 2u);
}

// A later run of a plan keeps the traces of that plan, not those of another one with equal names.
TEST(ExperimentRun, TracesOfAnotherPlanAreReplaced) {
  nlohmann::json json = small_plan_json();
  json["participants"] = 2;
  const TemporaryFolder folder;
  const ExperimentRunSettings with_traces{folder.path(), {}, 2, true};
  ASSERT_EQ(run_experiment(plan_of(json), with_traces, stand_in_trials())->computed.size(), 2u);
  const std::string notes = folder.path("traces/delayed/participant-1/notes.txt");
  std::ofstream(notes) << "mine\n";
  json["limit_s"] = 60;
  EXPECT_EQ(run_into(folder.path(), plan_of(json)).computed.size(), 2u);
  EXPECT_EQ(run_experiment(plan_of(json), with_traces, stand_in_trials())->computed.size(), 2u);
  EXPECT_EQ(content(notes), "mine\n");
}

TEST(ExperimentRun, ReportsProgressUpToTheEnd) {
  const TemporaryFolder folder;
  std::mutex mutex;
  std::condition_variable shown;
  std::vector<double> shares;
  TrialFunctions functions = stand_in_trials();
  // All trials wait for the first report; the second half waits for one after a trial.
  std::atomic<std::size_t> trials{0};
  constexpr std::size_t kTrials = kParticipants * 2 * 2 * 8;
  functions.run = [&, run = functions.run](auto&&... arguments) {
    const bool is_late = trials.fetch_add(1) >= kTrials / 2;
    std::unique_lock lock(mutex);
    shown.wait(lock, [&] { return !shares.empty() && (!is_late || shares.back() > 0.0); });
    lock.unlock();
    return run(arguments...);
  };
  const auto outcome = run_experiment(small_plan(), {folder.path(), {}, 2, false}, functions,
                                      [&](const RunProgress& progress) {
                                        const std::lock_guard lock(mutex);
                                        shares.push_back(progress.share);
                                        EXPECT_EQ(progress.found, 0.0);
                                        shown.notify_all();
                                      });
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(shares.front(), 0.0);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.back(), 0.0);
  EXPECT_LE(shares.back(), 1.0);
}

TEST(ExperimentRun, IsRefusedBeforeTheFirstTrial) {
  const auto expect_refused = [](const nlohmann::json& json, const TrialFunctions& functions,
                                 const std::string& path, const std::string& element,
                                 const std::string& problem) {
    const TemporaryFolder folder;
    TrialFunctions never = functions;
    never.run = [](auto&&...) -> Result<TrialOutcome> {
      return invalid_argument("trial", "a trial ran");
    };
    const auto outcome = run_experiment(plan_of(json), {folder.path("out"), {}, 1, false}, never);
    ASSERT_FALSE(outcome.ok()) << json.dump();
    const std::string line = outcome.error().to_string();
    EXPECT_TRUE(outcome.error().path.ends_with(path)) << line;
    EXPECT_EQ(outcome.error().element, element) << line;
    EXPECT_NE(outcome.error().problem.find(problem), std::string::npos) << line;
    EXPECT_EQ(line.find("Settings::"), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(folder.path("out")));
  };
  const auto with = [](const char* pointer, const nlohmann::json& value) {
    nlohmann::json json = small_plan_json();
    json[nlohmann::json::json_pointer(pointer)] = value;
    return json;
  };
  const TrialFunctions good = stand_in_trials();
  TrialFunctions no_contour = good;
  no_contour.find_way = [](const Scene&, const RunSetup&, const TrialSettings&) {
    return Result<TrialWay>(invalid_argument("contour", "has no closed contour"));
  };
  expect_refused(small_plan_json(), no_contour, "star.glb", "contour", "no closed contour");
  expect_refused(with("/objects/O2", "missing.glb"), good, "missing.glb", "", "cannot be opened");
  expect_refused(with("/objects/O2/node", "Moon"), good, "star.glb", "node \"Moon\"", "");
  expect_refused(with("/objects/O2/scene", "Moon"), good, "star.glb", "scene", "is \"Moon\"");
  expect_refused(with("/objects/O2/scale", 100), good, "plan.json", "/objects/O2", "spans");
  expect_refused(with("/objects/O2/scale", 1e-4), good, "plan.json", "/objects/O2", "spans");
  expect_refused(with("/device/workspace_m", 1e-3), good, "plan.json", "/device/workspace_m",
                 "expected at least");
  TrialFunctions real = good;
  real.find_way = find_trial_way;
  expect_refused(with("/device/plane_height_m", 1.5), real, "plan.json", "/device/plane_height_m",
                 "is 1.5 m; expected a height at which object O1 has a contour; it spans -0.0");
  expect_refused(with("/device/place", {1e9, 0, 0, 1, 0, 0, 0}), good, "plan.json", "/device/place",
                 "");
  expect_refused(with("/device/stiffness_N_per_m", 1e300), good, "plan.json",
                 "/device/stiffness_N_per_m", "");
  expect_refused(with("/device/device_damping_Ns_per_m", 1e6), good, "plan.json",
                 "/device/device_damping_Ns_per_m", "unstable");
}

// Something other than a file at a path that the run would write, or at `parts`.
TEST(ExperimentRun, IsRefusedBeforeTheFirstTrialIfAFileCannotHaveItsName) {
  TrialFunctions never = stand_in_trials();
  never.run = [](auto&&...) -> Result<TrialOutcome> {
    return invalid_argument("trial", "a trial ran");
  };
  const std::vector<std::function<void(const std::string&)>> takers = {
      [](const std::string& path) { fs::create_directories(path); },
      [](const std::string& path) { ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0); },
      [](const std::string& path) { fs::create_symlink("/dev/null", path); },
  };
  for (const char* const name :
       {"trials.csv", "columns.csv", "run.json", "run.log", "parts/run.json",
        "parts/participant-1.csv", "parts/participant-9.csv", "parts"}) {
    for (std::size_t i = 0; i < takers.size(); ++i) {
      SCOPED_TRACE(name + std::string(", taker ") + std::to_string(i));
      if (i == 0 && name == std::string("parts")) continue;  // a folder is right
      const TemporaryFolder folder;
      const std::string path = folder.path("out/") + name;
      fs::create_directories(fs::path(path).parent_path());
      takers[i](path);
      const auto before = files_below(folder.path());
      const auto outcome = run_experiment(small_plan(), {folder.path("out"), {}, 1, false}, never);
      ASSERT_FALSE(outcome.ok());
      EXPECT_EQ(outcome.error().path, path);
      EXPECT_FALSE(outcome.error().hint.empty());
      EXPECT_EQ(files_below(folder.path()), before);
    }
  }
}

// Folders of an experiment with two shards, one of them changed.
struct MergeCase {
  TemporaryFolder folder;
  std::string a = folder.path("a");
  std::string b = folder.path("b");
  std::string out = folder.path("out");

  void run(const nlohmann::json& of_a, const nlohmann::json& of_b) const {
    run_into(a, plan_of(of_a), Shard{1, 2});
    run_into(b, plan_of(of_b), Shard{2, 2});
  }
  void expect_refused(const std::string& path, const std::string& element,
                      const std::string& problem) const {
    const auto merged = merge_experiment({a, b}, out);
    ASSERT_FALSE(merged.ok());
    const std::string line = merged.error().to_string();
    EXPECT_EQ(merged.error().path, path) << line;
    EXPECT_EQ(merged.error().element, element) << line;
    EXPECT_NE(merged.error().problem.find(problem), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(out));
  }
};

// A merge is done, or refused because the other process has the folder.
TEST(ExperimentMerge, LeavesWholeResultsWhileAnotherProcessMergesIntoTheSameFolder) {
  const TemporaryFolder folder;
  const std::string out = folder.path();
  run_into(out, small_plan());
  const auto merge_often = [&] {
    constexpr int kMerges = 100;
    for (int i = 0; i < kMerges; ++i) {
      const auto merged = merge_experiment({out}, out);
      const bool is_as_expected =
          merged.ok() || merged.error().problem.find("is in use") != std::string::npos;
      EXPECT_TRUE(is_as_expected) << merged.error().to_string();
      if (!is_as_expected) return false;
    }
    return true;
  };
  const pid_t child = ::fork();
  if (child == 0) ::_exit(merge_often() ? 0 : 1);
  EXPECT_TRUE(merge_often());
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(results_in(out), reference());
}

TEST(ExperimentMerge, KilledBetweenAnyTwoRenamesLeavesWholeFiles) {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  constexpr int kRenames = 2 * 3;  // of the previous results and the new ones
  for (int last = 1; last <= kRenames; ++last) {
    SCOPED_TRACE(last);
    run_into(out, small_plan());
    EXPECT_FALSE(run_in_child([&] {
      test::die_at_rename(last);
      return merge_experiment({out}, out).ok();
    }));
    expect_whole_files(out);
    ASSERT_TRUE(merge_experiment({out}, out).ok());
    EXPECT_EQ(results_in(out), reference());
    EXPECT_EQ(files_below(out), expected_files());
  }
}

TEST(ExperimentMerge, NamesMissingParticipants) {
  const MergeCase test;
  test.run(small_plan_json(), small_plan_json());
  fs::remove(part_of(test.a, 3));
  fs::remove(part_of(test.b, 8));
  test.expect_refused(test.a, "", "lacks participants 3 and 8 of 9");
}

TEST(ExperimentMerge, NamesAFolderWithoutParts) {
  const MergeCase test;
  run_into(test.a, small_plan(), Shard{1, 2});
  test.expect_refused(test.b, "", "has no parts/run.json");
}

TEST(ExperimentMerge, NamesWhatDiffersBetweenPlans) {
  for (const auto& [pointer, value, element] :
       std::vector<std::tuple<const char*, nlohmann::json, std::string>>{
           {"/seed", 8, "/plan/hash"},
           {"/operator", "people2005", "/operator/hash"},
           {"/objects/O2", "lock.glb", "/plan/hash"},
           {"/objects/O1", "lock.glb", "/scenes/O1/file_hash"}}) {
    SCOPED_TRACE(pointer);
    nlohmann::json other = small_plan_json();
    other[nlohmann::json::json_pointer(pointer)] = value;
    const MergeCase test;
    test.run(small_plan_json(), other);
    test.expect_refused(part_identity_path(test.b), element, "as in " + part_identity_path(test.a));
  }
}

TEST(ExperimentMerge, NamesAPartThatWasChanged) {
  const MergeCase test;
  test.run(small_plan_json(), small_plan_json());
  const std::string path = part_of(test.b, 2);
  std::string text = content(path);
  text[text.size() - 10] ^= 1;
  std::ofstream(path, std::ios::binary) << text;
  test.expect_refused(path, "line 1", "does not have the hash");
  std::ofstream(path, std::ios::binary) << "participant,block\n";
  test.expect_refused(path, "line 1", "expected \"palpate part 1, run ");
}

TEST(ExperimentMerge, IgnoresFilesWhoseNamesAreNotThoseOfParts) {
  const TemporaryFolder folder;
  run_into(folder.path("out"), small_plan());
  for (const char* const name : {"participant-01.csv", "participant-+1.csv", "participant-1.csv~",
                                 "participant-.csv", "participant-99999999999.csv"}) {
    folder.write(std::string("out/parts/") + name, "mine");
  }
  ASSERT_TRUE(merge_experiment({folder.path("out")}, folder.path("all")).ok());
  EXPECT_EQ(results_in(folder.path("all")), reference());
}

TEST(ExperimentMerge, NamesAnIdentityThatWasChanged) {
  const MergeCase test;
  test.run(small_plan_json(), small_plan_json());
  const std::string path = part_identity_path(test.b);
  std::string text = content(path);
  text.replace(text.find("\"seed\": 7"), 9, "\"seed\": 8");
  std::ofstream(path, std::ios::binary) << text;
  test.expect_refused(path, "/run", "the hash of the other entries");
}

TEST(ExperimentMerge, NamesRowsThatDiffer) {
  const MergeCase test;
  test.run(small_plan_json(), small_plan_json());
  // The same participant in both folders: once more is no fault, another result is one.
  fs::copy_file(part_of(test.b, 2), part_of(test.a, 2));
  ASSERT_TRUE(merge_experiment({test.a, test.b}, test.out).ok());
  EXPECT_EQ(results_in(test.out), reference());
  fs::remove_all(test.out);

  const std::uint64_t run = [&] {
    const std::string text = content(part_of(test.b, 2));
    return std::stoull(text.substr(text.find("run ") + 4, 16), nullptr, 16);
  }();
  const DealtUnits units{"participant", kParticipants, run, trials_columns()};
  std::string rows = *read_part(part_of(test.b, 2), units, 2);
  std::size_t at = 0;
  for (int line = 0; line < 3; ++line) at = rows.find('\n', at) + 1;
  for (int field = 0; field < 8; ++field) at = rows.find(',', at) + 1;
  const std::size_t end = rows.find(',', at);
  rows.replace(at, end - at, rows.substr(at, end - at) == "done" ? "fault" : "done");
  ASSERT_FALSE(write_part(part_of(test.b, 2), units, 2, rows).has_value());
  test.expect_refused(part_of(test.b, 2), "line 6, column status", "as in " + part_of(test.a, 2));
}

}  // namespace
}  // namespace palpate
