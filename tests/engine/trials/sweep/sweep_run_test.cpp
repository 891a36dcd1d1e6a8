// Sweeps: points, shards, jobs, interruptions and merging, with a stand-in for the trial.

#include "engine/trials/sweep/sweep_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/deal/experiment_run.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/sweep/sweep_merge.h"
#include "engine/trials/sweep/sweep_points.h"
#include "engine/trials/sweep/sweep_rows.h"
#include "engine/trials/trial.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/random.h"
#include "tests/engine/trials/sweep/small_sweep.h"
#include "tests/helpers/child_process.h"
#include "tests/helpers/deadly_rename.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::quick_sweep_json;
using test::run_in_child;
using test::small_sweep;
using test::small_sweep_json;
using test::sweep_of;
using test::sweep_stand_in;
using test::TemporaryFolder;

constexpr int kSmallSweepPoints = 1 + 18 + 6;  // of small_sweep_json(): base, levels, hypercube
constexpr int kPoints = 1 + 4 + 6;             // of quick_sweep_json()

std::string text_in(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Sweep quick_sweep() {
  return sweep_of(quick_sweep_json());
}

// The measured results: sweep.csv, columns.csv and run.json.
constexpr std::array kMeasured = {kSweepFile, kColumnsFile, kRunFile};

// The bytes of all of them.
std::string sweep_results_in(const std::string& folder) {
  std::string all;
  for (const char* const name : kMeasured) {
    const std::string text = text_in((fs::path(folder) / name).string());
    EXPECT_FALSE(text.empty()) << folder << " " << name;
    all += text;
  }
  return all;
}

struct WholeSweep : SweepOutcome {
  std::optional<SweepCounts> merged;  // no value: a shard, or stopped
};

// A merge whose results are moved into place, as the program does it, but without a page.
Result<SweepCounts> merge_into_place(const std::vector<std::string>& folders,
                                     const std::string& out_folder) {
  auto merged = merge_sweep(folders, out_folder);
  if (!merged) return merged.error();
  if (auto error = merged->files.move_into_place()) return *error;
  return static_cast<SweepCounts>(*merged);
}

// As `experiment sweep` does it: a run that is complete is merged.
WholeSweep run_whole(const Sweep& sweep, const DealtSettings& settings,
                     const TrialFunctions& functions, const StopFlag* stop = nullptr) {
  auto outcome = run_sweep(sweep, settings, functions, {}, stop);
  EXPECT_TRUE(outcome.ok()) << outcome.error().to_string();
  if (!outcome) return {};
  WholeSweep whole{std::move(*outcome), std::nullopt};
  if (settings.shard || !whole.not_done.empty()) return whole;
  auto merged = merge_into_place({settings.out_folder}, settings.out_folder);
  EXPECT_TRUE(merged.ok()) << merged.error().to_string();
  if (merged) whole.merged = *merged;
  return whole;
}

WholeSweep sweep_into(const std::string& folder, std::optional<Shard> shard = {}, int jobs = 1,
                      const Sweep& sweep = quick_sweep()) {
  return run_whole(sweep, {folder, shard, jobs}, sweep_stand_in());
}

// The results of an undisturbed run with one job.
const std::string& sweep_reference() {
  static const std::string results = [] {
    const TemporaryFolder folder;
    sweep_into(folder.path());
    return sweep_results_in(folder.path());
  }();
  return results;
}

TEST(SweepRun, EveryTrialHasTheValuesOfItsPoint) {
  const Sweep sweep = small_sweep();
  const auto points = sweep_points(sweep);
  std::map<double, double> extent_m;  // of the scene, by scale
  for (const double scale : {0.5, 1.0}) {
    extent_m[scale] =
        Scene::load(PALPATE_MODELS_DIR "/star.glb", {.scale = scale})->statistics().extent_m.x();
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const SweepValues& values = points[i].values;
    TrialFunctions functions = sweep_stand_in();
    int trials = 0;
    functions.run = [&, run = functions.run](
                        const Scene& scene, const TrialWay& way, const RunSetup& setup,
                        const TrialSettings& settings, const OperatorParameters& person,
                        const TrialConditions& conditions, const TrialSink& sink) {
      ++trials;
      for (std::size_t p = 0; p < kSweepParameterCount; ++p) {
        const auto field = sweep_parameters()[p].drawn;
        if (field && values[p]) {
          EXPECT_EQ(person.*field, *values[p]);
        }
      }
      EXPECT_EQ(person.comfortable_depth_m, *values[kComfortableDepth]);
      EXPECT_EQ(setup.haptics.coupling.stiffness_N_per_m, *values[kDeviceStiffness]);
      EXPECT_EQ(static_cast<double>(setup.haptics.a4.align), *values[kAlign]);
      EXPECT_EQ(static_cast<double>(conditions.following), *values[kSweptFollowing]);
      EXPECT_EQ(scene.statistics().extent_m.x(), extent_m[*values[kScale]]);
      const Vec3 turned = setup.haptics.initial_pose.rotation * Vec3::UnitX();
      const double turn_rad = *values[kStartOrientation] * std::numbers::pi / 180.0;
      EXPECT_NEAR(std::atan2(turned.y(), turned.x()), turn_rad, 1e-15);  // a few roundings of 1
      return run(scene, way, setup, settings, person, conditions, sink);
    };
    const TemporaryFolder folder;
    const Shard shard{static_cast<int>(i) + 1, kSmallSweepPoints};
    ASSERT_TRUE(run_sweep(sweep, {folder.path(), shard, 1}, functions).ok());
    EXPECT_EQ(trials, 6 * points[i].participants);
  }
}

// Real trials without force: the noise takes the hand beyond its press depth. More noise would let
// it lose the contour, which takes longer than what the pace takes.
TEST(SweepRun, TheComfortableDepthSlowsTheHand) {
  constexpr std::uint64_t kSeeds = 8;
  nlohmann::json json = small_sweep_json();
  json["plan"]["scale"] = {0.3};
  const Sweep sweep = sweep_of(json);
  const auto scenes = load_experiment_scenes(sweep.plan, {find_trial_way, run_trial});
  ASSERT_TRUE(scenes.ok()) << scenes.error().to_string();
  const ExperimentScene& scene = scenes->front();
  std::vector<double> sums_s;
  for (const double depth_m : {5e-2, 5e-3, 5e-4}) {
    OperatorParameters person;
    person.comfortable_depth_m = depth_m;
    person.intention_noise_m = 3e-3;
    sums_s.push_back(0.0);
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const auto outcome = run_trial(scene.scene, scene.way, scene.setup, sweep.plan.trial, person,
                                     {.force = ForceMode::kNone, .noise_seed = seed});
      ASSERT_TRUE(outcome.ok());
      ASSERT_EQ(outcome->status, TrialStatus::kDone);
      sums_s.back() += *outcome->measures[kTotalTime];
    }
  }
  std::cout << "seeds 1 to " << kSeeds << ": " << sums_s[0] << ", " << sums_s[1] << " and "
            << sums_s[2] << " s\n";
  EXPECT_LT(sums_s[0], sums_s[1]);
  EXPECT_LT(sums_s[1], sums_s[2]);
}

// The first point runs the trials of the base plan itself.
TEST(SweepRun, TheBasePointHasTheMeansOfAnExperimentWithTheBasePlan) {
  nlohmann::json json = quick_sweep_json();
  json["plan"]["blocks"] = 3;
  json["plan"]["objects"]["O2"] = "lock.glb";
  const Sweep sweep = sweep_of(json);
  const TemporaryFolder folder;
  sweep_into(folder.path("sweep"), {}, 2, sweep);
  ASSERT_TRUE(
      run_experiment(sweep.plan, {folder.path("run"), {}, 1, false}, sweep_stand_in()).ok());
  const auto trials = read_trials(folder.path("run/trials.csv"));
  const auto rows = parse_sweep_rows(text_in(folder.path("sweep/sweep.csv")), "sweep.csv");
  ASSERT_TRUE(trials.ok() && rows.ok());
  const std::array<std::size_t, 4> measures = {kTotalTime, kLosses, kPenetrationDm, kContactAngle};
  int compared = 0;
  for (const SweepRow& row : *rows) {
    if (row.point != 1) continue;
    std::array<double, 4> sums{};
    std::array<int, 4> counts{};
    int all = 0, done = 0, timeouts = 0;
    for (const TrialRow& trial : *trials) {
      if (trial.participant != std::to_string(row.participant) ||
          trial.haptic != kHapticNames[row.haptic] ||
          trial.rotation != kRotationNames[row.rotation]) {
        continue;
      }
      ++all;
      timeouts += trial.status == TrialStatus::kTimeout ? 1 : 0;
      if (trial.status != TrialStatus::kDone) continue;
      ++done;
      for (std::size_t i = 0; i < 4; ++i) {
        if (!trial.measures[measures[i]]) continue;
        sums[i] += *trial.measures[measures[i]];
        ++counts[i];
      }
    }
    EXPECT_EQ(row.trials, 6);
    EXPECT_EQ(all, 6);
    EXPECT_EQ(row.done, done);
    EXPECT_EQ(row.timeouts, timeouts);
    EXPECT_EQ(row.faults, all - done - timeouts);
    EXPECT_EQ(row.limit_s, 120.0);
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_EQ(row.means[i].has_value(), counts[i] > 0);
      if (counts[i] > 0) {
        EXPECT_EQ(*row.means[i], sums[i] / counts[i]);
      }
    }
    ++compared;
  }
  EXPECT_EQ(compared, 2 * 6);
}

TEST(SweepRun, GivesTheSameBytesWithAnyNumberOfJobs) {
  for (const int jobs : {1, 2, 5}) {
    const TemporaryFolder folder;
    const WholeSweep outcome = sweep_into(folder.path(), {}, jobs);
    ASSERT_TRUE(outcome.merged.has_value());
    EXPECT_EQ(outcome.merged->points, kPoints);
    EXPECT_EQ(outcome.merged->trials, 5u * 12 + 6u * 6);
    EXPECT_EQ(sweep_results_in(folder.path()), sweep_reference()) << jobs << " jobs";
  }
}

TEST(SweepRun, ShardsInAnyOrderGiveTheSameBytes) {
  constexpr std::uint64_t kSeed = 18;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  for (int count = 1; count <= 7; ++count) {
    SCOPED_TRACE(std::to_string(count) + " shards");
    const TemporaryFolder folder;
    std::vector<int> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), 1);
    for (std::size_t left = numbers.size(); left > 1; --left) {
      std::swap(numbers[left - 1], numbers[random.index(left)]);
    }
    std::vector<std::string> folders;
    for (const int number : numbers) {
      folders.push_back(folder.path(std::to_string(number)));
      EXPECT_FALSE(sweep_into(folders.back(), Shard{number, count}).merged.has_value());
      EXPECT_FALSE(fs::exists(fs::path(folders.back()) / kSweepFile));
    }
    const auto merged = merge_into_place(folders, folder.path("out"));
    ASSERT_TRUE(merged.ok()) << merged.error().to_string();
    EXPECT_EQ(sweep_results_in(folder.path("out")), sweep_reference());
  }
}

// Trials of which the last one kills the process.
TrialFunctions deadly_sweep_trials(std::size_t trials) {
  TrialFunctions functions = sweep_stand_in();
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

TEST(SweepRun, ShardsThatAreKilledAndStartedAgainGiveTheSameBytes) {
  constexpr std::uint64_t kSeed = 5;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  const Sweep sweep = quick_sweep();
  for (const int count : {1, 3, 7}) {
    const TemporaryFolder folder;
    std::vector<std::string> folders;
    int kills = 0;
    for (int number = 1; number <= count; ++number) {
      folders.push_back(folder.path(std::to_string(number)));
      const Shard shard{number, count};
      // Without a merge, a start is over when its trials suffice for what is left.
      const auto dies = [&] {
        const std::size_t trials = 1 + random.index(40);
        return !run_in_child([&] {
          return run_sweep(sweep, {folders.back(), shard, 1}, deadly_sweep_trials(trials)).ok();
        });
      };
      while (dies()) ++kills;
      EXPECT_EQ(sweep_into(folders.back(), shard).kept.size(), units_of(shard, kPoints).size());
    }
    std::cout << kills << " kills\n";
    EXPECT_GT(kills, 0);
    const auto merged = merge_into_place(folders, folder.path("out"));
    ASSERT_TRUE(merged.ok()) << merged.error().to_string();
    EXPECT_EQ(sweep_results_in(folder.path("out")), sweep_reference());
  }
}

TEST(SweepRun, AKilledRunKeepsEachFinishedTrial) {
  const TemporaryFolder folder;
  // In the second point, whose first participant has ended.
  constexpr std::size_t kFinished = 12 + 7;
  EXPECT_FALSE(run_in_child([&] {
    return run_sweep(quick_sweep(), {folder.path(), {}, 1}, deadly_sweep_trials(kFinished + 1))
        .ok();
  }));
  const WholeSweep again = sweep_into(folder.path());
  EXPECT_EQ(again.kept, (std::vector<int>{1}));
  EXPECT_EQ(again.kept_trials, 7u);
  EXPECT_EQ(sweep_results_in(folder.path()), sweep_reference());
}

TEST(SweepRun, KilledBetweenAnyTwoRenamesOfResultsIsCompletedByAnotherMerge) {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  sweep_into(out);
  for (int last = 1; last <= 2 * static_cast<int>(kMeasured.size()); ++last) {
    SCOPED_TRACE(last);
    EXPECT_FALSE(run_in_child([&] {
      test::die_at_rename(last);
      return merge_into_place({out}, out).ok();
    }));
    // run.json is there only beside all others.
    if (fs::exists(fs::path(out) / kRunFile)) {
      EXPECT_EQ(sweep_results_in(out), sweep_reference());
    }
    ASSERT_TRUE(merge_into_place({out}, out).ok());
    EXPECT_EQ(sweep_results_in(out), sweep_reference());
  }
}

TEST(SweepRun, AStopLeavesCompletePointsOnly) {
  const TemporaryFolder folder;
  StopFlag stop;
  TrialFunctions functions = sweep_stand_in();
  int trials = 0;
  functions.run = [&, run = functions.run](auto&&... arguments) {
    if (++trials == 2 * 12 + 5) stop.request();  // in the third point
    return run(arguments...);
  };
  const WholeSweep outcome = run_whole(quick_sweep(), {folder.path(), {}, 1}, functions, &stop);
  EXPECT_EQ(outcome.computed, (std::vector<int>{1, 2}));
  EXPECT_EQ(outcome.not_done.size(), static_cast<std::size_t>(kPoints) - 2);
  EXPECT_FALSE(outcome.merged.has_value());
  EXPECT_EQ(sweep_into(folder.path()).kept, (std::vector<int>{1, 2}));
  EXPECT_EQ(sweep_results_in(folder.path()), sweep_reference());
}

// A point counts in the progress with its trials.
TEST(SweepRun, ReportsProgress) {
  const TemporaryFolder folder;
  std::vector<RunProgress> shown;
  const auto outcome =
      run_sweep(quick_sweep(), {folder.path(), {}, 1}, sweep_stand_in(std::chrono::milliseconds(2)),
                [&](const RunProgress& progress) { shown.push_back(progress); });
  ASSERT_TRUE(outcome.ok());
  ASSERT_FALSE(shown.empty());
  for (const RunProgress& progress : shown) {
    EXPECT_EQ(progress.found, 0.0);
    EXPECT_LE(progress.share, 1.0);
  }
  EXPECT_GT(shown.back().share, 0.5);
}

TEST(SweepRun, AnotherSweepOrAnExperimentInTheFolderIsReplaced) {
  const TemporaryFolder folder;
  nlohmann::json other = quick_sweep_json();
  other["hypercube"]["seed"] = 4;
  sweep_into(folder.path(), {}, 1, sweep_of(other));
  for (const std::string& name : page_names(RunKind::kSweep)) {
    std::ofstream(folder.path(name)) << "of the page";
  }
  ASSERT_TRUE(
      run_experiment(quick_sweep().plan, {folder.path(), {}, 1, false}, sweep_stand_in()).ok());
  EXPECT_TRUE(units_with_parts(folder.path(), "point").empty());
  for (const std::string& name : result_names(RunKind::kSweep)) {
    EXPECT_EQ(fs::exists(folder.path(name)), name == kColumnsFile || name == kRunFile) << name;
  }
  EXPECT_EQ(sweep_into(folder.path()).computed.size(), static_cast<std::size_t>(kPoints));
  EXPECT_TRUE(units_with_parts(folder.path(), "participant").empty());
  EXPECT_FALSE(fs::exists(folder.path(kTrialsFile)));
  EXPECT_EQ(text_in(folder.path(kColumnsFile)), sweep_columns_csv());
  EXPECT_EQ(sweep_results_in(folder.path()), sweep_reference());
}

TEST(SweepRun, CountsTrialsThatWereNotDone) {
  TrialFunctions functions = sweep_stand_in();
  functions.run = [run = functions.run](auto&&... arguments) {
    auto outcome = run(arguments...);
    outcome->status = TrialStatus::kTimeout;
    return outcome;
  };
  const TemporaryFolder folder;
  const WholeSweep outcome = run_whole(quick_sweep(), {folder.path(), {}, 1}, functions);
  ASSERT_TRUE(outcome.merged.has_value());
  EXPECT_EQ(outcome.merged->done, 0u);
  EXPECT_EQ(outcome.merged->faults, 0u);
  EXPECT_EQ(outcome.merged->timeouts, outcome.merged->trials);
}

// The page of former results does not stay beside new ones, and appears only with them.
TEST(SweepMerge, ReplacesNothingBeforeItIsMovedIntoPlace) {
  const TemporaryFolder folder;
  sweep_into(folder.path());
  std::vector<std::string> names = page_names(RunKind::kSweep);
  names.insert(names.end(), kMeasured.begin(), kMeasured.end());
  for (const std::string& name : names) std::ofstream(folder.path(name)) << "former";
  {
    const auto given_up = merge_sweep({folder.path()}, folder.path());
    ASSERT_TRUE(given_up.ok());
    std::ofstream(given_up->files.path(kSweepPage)) << "page";
  }
  for (const std::string& name : names) EXPECT_EQ(text_in(folder.path(name)), "former") << name;
  auto merged = merge_sweep({folder.path()}, folder.path());
  ASSERT_TRUE(merged.ok());
  std::ofstream(merged->files.path(kSweepPage)) << "page";
  ASSERT_FALSE(merged->files.move_into_place().has_value());
  EXPECT_EQ(text_in(folder.path(kSweepPage)), "page");
  EXPECT_EQ(sweep_results_in(folder.path()), sweep_reference());
  for (const std::string& name : page_names(RunKind::kSweep)) {
    EXPECT_EQ(fs::exists(folder.path(name)), name == kSweepPage) << name;
  }
}

TEST(SweepRun, AnotherLevelOperatorOrSceneMakesAnotherRun) {
  const auto identity = [](const nlohmann::json& json) {
    const TemporaryFolder folder;
    sweep_into(folder.path(), Shard{1, 1000}, 1, sweep_of(json));
    return text_in(part_identity_path(folder.path()));
  };
  std::set<std::string> identities{identity(quick_sweep_json())};
  EXPECT_EQ(identity(quick_sweep_json()), *identities.begin());
  std::size_t expected = 1;
  for (const auto& [pointer, value] : std::vector<std::pair<const char*, nlohmann::json>>{
           {"/parameters/sight_delay_s", {0.1, 0.25}},
           {"/parameters/scale", {0.5, 0.75}},
           {"/hypercube/participants", 2},
           {"/plan/seed", 8},
           {"/plan/operator", "literature"},
           {"/plan/objects/O1", "lock.glb"},
           {"/name", "other"}}) {
    nlohmann::json json = quick_sweep_json();
    json[nlohmann::json::json_pointer(pointer)] = value;
    identities.insert(identity(json));
    EXPECT_EQ(identities.size(), ++expected) << pointer;
  }
}

TEST(SweepMerge, NamesMissingPointsAndOtherRuns) {
  const TemporaryFolder folder;
  const std::string a = folder.path("a"), b = folder.path("b"), out = folder.path("out");
  sweep_into(a, Shard{1, 2});
  const auto expect_refused = [&](const std::vector<std::string>& folders, const std::string& path,
                                  const std::string& problem) {
    const auto merged = merge_sweep(folders, out);
    ASSERT_FALSE(merged.ok());
    EXPECT_EQ(merged.error().path, path);
    EXPECT_NE(merged.error().to_string().find(problem), std::string::npos)
        << merged.error().to_string();
    EXPECT_FALSE(fs::exists(out));
  };
  expect_refused({a}, a, "lacks points 2, 4, 6, 8 and 10 of 11");
  nlohmann::json other = quick_sweep_json();
  other["hypercube"]["seed"] = 4;
  sweep_into(b, Shard{2, 2}, 1, sweep_of(other));
  expect_refused({a, b}, part_identity_path(b), "/plan/hash");
  fs::remove_all(b);  // trials that are in no results keep another run out
  ASSERT_TRUE(run_experiment(quick_sweep().plan, {b, {}, 1, false}, sweep_stand_in()).ok());
  expect_refused({b}, part_identity_path(b), "is of an experiment; expected a sweep");
  EXPECT_EQ(*kind_of_run_in(a), RunKind::kSweep);
  EXPECT_EQ(*kind_of_run_in(b), RunKind::kExperiment);
}

TEST(SweepMerge, NamesRowsThatDiffer) {
  const TemporaryFolder folder;
  const std::string a = folder.path("a"), b = folder.path("b");
  sweep_into(a);
  sweep_into(b, Shard{2, 2});
  const std::string path = part_path(b, "point", 2);
  const std::string first_line = text_in(path).substr(0, text_in(path).find('\n'));
  const DealtUnits units{
      "point", kPoints,
      std::stoull(first_line.substr(first_line.find("run ") + 4, 16), nullptr, 16),
      sweep_columns()};
  std::string rows = *read_part(path, units, 2);
  const std::size_t at = rows.find(",NoH,");
  rows.replace(at, 5, ",UaH,");
  ASSERT_FALSE(write_part(path, units, 2, rows).has_value());
  const auto merged = merge_sweep({a, b}, folder.path("out"));
  ASSERT_FALSE(merged.ok());
  EXPECT_EQ(merged.error().path, path);
  EXPECT_EQ(merged.error().element, "line 3, column haptic");
  EXPECT_NE(merged.error().hint.find("run this point on both again"), std::string::npos);
}

TEST(SweepRows, AreReadBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  sweep_into(folder.path());
  const std::string text = text_in(folder.path(kSweepFile));
  const auto rows = parse_sweep_rows(text, "sweep.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->size(), 5u * 2 * 6 + 6u * 6);
  CsvLines lines(sweep_columns());
  for (const SweepRow& row : *rows) add_sweep_row(lines, row);
  EXPECT_EQ(lines.text(), text);
}

// Python checks sweep.csv by its own copy of columns.csv.
TEST(SweepRows, HaveTheColumnsThatPythonReads) {
  EXPECT_EQ(text_in(PALPATE_MODELS_DIR "/../engine/python/palpate/analysis/sweep/columns.csv"),
            sweep_columns_csv());
}

TEST(SweepRows, NameALineThatIsBroken) {
  const TemporaryFolder folder;
  sweep_into(folder.path(), Shard{1, kPoints});
  const std::string part = text_in(part_path(folder.path(), "point", 1));
  const std::string text = part.substr(part.find('\n') + 1);
  ASSERT_TRUE(parse_sweep_rows(text, "sweep.csv").ok());
  const auto expect_error = [&](const std::string& from, const std::string& to,
                                const std::string& element) {
    std::string broken = text;
    const std::size_t at = broken.find(from, broken.find('\n'));
    ASSERT_NE(at, std::string::npos) << from;
    broken.replace(at, from.size(), to);
    const auto rows = parse_sweep_rows(broken, "sweep.csv");
    ASSERT_FALSE(rows.ok()) << to;
    EXPECT_EQ(rows.error().path, "sweep.csv");
    EXPECT_EQ(rows.error().element, element);
  };
  expect_error("\n1,base", "\none,base", "line 2, column point");
  expect_error(",base,", ",bass,", "line 2, column block");
  expect_error(",base,,", ",base,tau,", "line 2, column parameter");
  expect_error(",delayed,", ",delay,", "line 2, column following");
  expect_error(",1000,", ",1e,", "line 2, column stiffness_N_per_m");
  expect_error(",NoH,", ",,", "line 2, column haptic");
  expect_error(",NoH,NoR,1,", ",NoH,NoR,1.5,", "line 2, column trials");
  expect_error("\n1,base,", "\n1,base,,", "line 2");
}

}  // namespace
}  // namespace palpate
