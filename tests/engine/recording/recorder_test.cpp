// What a recorder writes, and what it does when its disk or its rings fail.

#include "engine/recording/recorder.h"

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/recording/block_walk.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_replay.h"
#include "engine/session/haptic_thread.h"
#include "engine/session/trace_csv.h"
#include "tests/engine/recording/fault_layer.h"
#include "tests/engine/recording/scenario.h"
#include "tests/engine/session/still_device.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;
using test::FaultLayer;
using test::Scenario;
using test::TemporaryFolder;
using test::TickKeeper;

struct ReadBack {
  std::vector<RecordedTick> rows;
  std::array<std::uint64_t, kInputKinds.size()> inputs{};
  std::vector<std::int64_t> block_ticks;
};

// All blocks of a recording that must be whole but for gaps.
ReadBack read_back(const std::string& path) {
  ReadBack back;
  const auto reader = RecordingReader::open(path);
  EXPECT_TRUE(reader) << reader.error().to_string();
  BlockWalk walk(*reader);
  for (WalkStep step = walk.next(); step.kind != WalkStep::Kind::kEnd; step = walk.next()) {
    EXPECT_EQ(step.kind, WalkStep::Kind::kBlock) << step.error->to_string();
    if (step.kind != WalkStep::Kind::kBlock) break;
    back.block_ticks.push_back(step.frames.ticks);
    back.rows.insert(back.rows.end(), step.content.rows.begin(), step.content.rows.end());
    for (const BlockInput& input : step.content.inputs) {
      ++back.inputs[static_cast<std::size_t>(input.input.kind)];
    }
  }
  return back;
}

bool is_prefix(const std::vector<RecordedTick>& part, const std::vector<RecordedTick>& whole) {
  return part.size() <= whole.size() &&
         (part.empty() ||
          std::memcmp(part.data(), whole.data(), part.size() * sizeof part[0]) == 0);
}

RecordedTick plain_row(std::uint64_t tick) {
  RecordedTick row;
  row.record.tick = tick;
  row.record.time_s = 1e-3 * static_cast<double>(tick);
  row.record.device_m[0] = std::sin(0.1 * static_cast<double>(tick));
  row.reading.session_tick = tick;
  return row;
}

// A recorder without a session.
std::unique_ptr<Recorder> made(const std::string& path, const RecorderSettings& settings) {
  auto recorder = Recorder::create(path, {{"engine", std::string("test")}}, settings);
  EXPECT_TRUE(recorder) << recorder.error().to_string();
  return std::move(*recorder);
}

TEST(Recorder, WritesEachRowAndEachInputThatItIsGiven) {
  const TemporaryFolder folder;
  Scenario scenario(3, {.ticks = 5'000});
  const std::string file = folder.write("scenario.glb", "bytes");
  const TickKeeper given = test::recorded_scenario(scenario, file, folder.path("a.palpate"));
  const ReadBack back = read_back(folder.path("a.palpate"));
  ASSERT_EQ(back.rows.size(), given.rows.size());
  EXPECT_TRUE(is_prefix(back.rows, given.rows));
  EXPECT_EQ(back.inputs, given.inputs);
  EXPECT_EQ(back.block_ticks, (std::vector<std::int64_t>{1024, 1024, 1024, 1024, 904}));
  // A closed recording is one plain file, and the same session gives the same bytes of blocks.
  EXPECT_FALSE(std::filesystem::exists(folder.path("a.palpate-wal")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("a.palpate-shm")));
  Scenario again(3, {.ticks = 5'000});
  test::recorded_scenario(again, file, folder.path("b.palpate"));
  const auto a = RecordingReader::open(folder.path("a.palpate"));
  const auto b = RecordingReader::open(folder.path("b.palpate"));
  ASSERT_TRUE(a && b);
  for (const std::int64_t first : {0, 1024, 4096}) {
    // step_ns is measured.
    EXPECT_EQ(a->block(first)->inputs, b->block(first)->inputs) << first;
  }
}

TEST(Recorder, ListsTripsAsEvents) {
  const TemporaryFolder folder;
  Scenario scenario(4, {.ticks = 20'000});
  const TickKeeper given = test::recorded_scenario(scenario, folder.write("scenario.glb", "bytes"),
                                                   folder.path("a.palpate"));
  const auto reader = RecordingReader::open(folder.path("a.palpate"));
  ASSERT_TRUE(reader);
  const auto events = reader->events(1'000);
  ASSERT_TRUE(events);
  ASSERT_GT(given.trips, 2u);
  std::uint64_t trips = 0;
  for (const EventRow& event : *events) trips += event.kind == "trip" ? 1 : 0;
  EXPECT_EQ(trips, given.trips);
}

TEST(Recorder, WritesAtMostAHundredEventsASecondAndCountsTheRest) {
  EventLog log;
  RecordedEvent event;
  event.kind = EventKind::kLate;
  for (std::uint64_t tick = 0; tick < 2'500; ++tick) {
    event.tick = tick;
    event.time_s = 1e-3 * static_cast<double>(tick);
    log.add(event);
  }
  log.add_lost(7);
  log.finish();
  std::map<int, std::size_t> rows;
  std::uint64_t counted = 0;
  for (const EventRow& row : log.take_rows()) {
    ++rows[static_cast<int>(row.time_s)];
    counted += row.kind == "more" ? std::stoull(row.detail) : 1;
  }
  for (const auto& [second, count] : rows) EXPECT_LE(count, 100u) << second;
  EXPECT_EQ(counted, 2'507u);
}

TEST(Recorder, RefusesAFileThatExists) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a.palpate", "precious");
  const auto recorder = Recorder::create(path, {}, {});
  ASSERT_FALSE(recorder);
  EXPECT_NE(recorder.error().to_string().find("exists"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(path), 8u);
  const auto nowhere = Recorder::create(folder.path("no/such/folder/a"), {}, {});
  EXPECT_FALSE(nowhere);
}

// Where the disk stands still for longer than the rings last, whole ticks are dropped, with their
// inputs, and counted exactly.
TEST(Recorder, CountsTheTicksThatItDrops) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.palpate");
  FaultLayer::heal();
  auto recorder = made(path, {.rate_Hz = 1000.0, .file_system = FaultLayer::kName, .seconds = 0.2});
  FaultLayer::stand_still(900ms);
  constexpr std::uint64_t kTicks = 1'500;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    const RecordedTick row = plain_row(tick);
    recorder->on_input({InputKind::kA4, static_cast<std::uint32_t>(tick % 2)});
    recorder->on_tick(row.record, row.reading);
    std::this_thread::sleep_for(1ms);
  }
  const RecordingResult result = recorder->finish("end");
  FaultLayer::heal();
  ASSERT_FALSE(result.error) << result.error->to_string();
  EXPECT_GT(result.dropped, 0u);
  const ReadBack back = read_back(path);
  EXPECT_EQ(back.rows.size() + result.dropped, kTicks);
  EXPECT_EQ(back.inputs[static_cast<std::size_t>(InputKind::kA4)], back.rows.size());
  for (const RecordedTick& row : back.rows) {
    const RecordedTick expected = plain_row(row.record.tick);
    EXPECT_EQ(std::memcmp(&row, &expected, sizeof row), 0) << row.record.tick;
  }
  const auto reader = RecordingReader::open(path);
  ASSERT_TRUE(reader);
  const auto check = check_recording(*reader);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->missing, result.dropped);
  ASSERT_TRUE(check->ending);
  EXPECT_EQ(check->ending->dropped, static_cast<std::int64_t>(result.dropped));
}

// The rings last for 8 s.
TEST(Recorder, DropsNothingAt1kHzWhileTheDiskStandsStill) {
  const TemporaryFolder folder;
  FaultLayer::heal();
  auto recorder = made(folder.path("a.palpate"), {.file_system = FaultLayer::kName});
  const auto still = test::in_soak_or_else(5000ms, 1500ms);
  const auto ticks = static_cast<std::uint64_t>(still.count()) + 500;
  FaultLayer::stand_still(still);
  auto due = std::chrono::steady_clock::now();
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const RecordedTick row = plain_row(tick);
    recorder->on_tick(row.record, row.reading);
    std::this_thread::sleep_until(due += 1ms);
  }
  const RecordingResult result = recorder->finish("end");
  FaultLayer::heal();
  EXPECT_FALSE(result.error);
  EXPECT_EQ(result.dropped, 0u);
  EXPECT_EQ(read_back(folder.path("a.palpate")).rows.size(), ticks);
}

// The disk fails at its n-th operation: the session goes on, and all that was committed before is
// readable.
TEST(Recorder, EndsAtAFailureOfTheDiskAndKeepsWhatWasCommitted) {
  const TemporaryFolder folder;
  FaultLayer::heal();
  constexpr std::uint64_t kTicks = 6'000;
  int failed = 0;
  int files = 0;
  const std::uint64_t step = test::in_soak_or_else<std::uint64_t>(1, 7);
  for (const auto fault :
       {FaultLayer::Fault::kFull, FaultLayer::Fault::kIoError, FaultLayer::Fault::kGone}) {
    for (std::uint64_t n = 1; n < 200; n += step) {
      const std::string path = folder.path(std::to_string(files++) + ".palpate");
      auto recorder = made(path, {.virtual_time = true, .file_system = FaultLayer::kName});
      FaultLayer::fail_at(n, fault);
      std::vector<RecordedTick> given;
      for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
        given.push_back(plain_row(tick));
        recorder->on_tick(given.back().record, given.back().reading);
      }
      const RecordingResult result = recorder->finish("end");
      recorder.reset();
      FaultLayer::heal();
      if (!result.error) break;  // all operations were before the n-th
      ++failed;
      EXPECT_FALSE(result.error->problem.empty());
      const auto rows = read_back(path).rows;
      EXPECT_TRUE(is_prefix(rows, given)) << n;
      EXPECT_GE(rows.size(), result.ticks) << n;
    }
  }
  EXPECT_GT(failed, 10);
}

// What was committed before the disk fails is there afterwards.
TEST(Recorder, KeepsTheTransactionsBeforeAFailureOfTheDisk) {
  const TemporaryFolder folder;
  FaultLayer::heal();
  constexpr std::uint64_t kBefore = 3'000, kAfter = 3'000;
  for (const auto fault :
       {FaultLayer::Fault::kFull, FaultLayer::Fault::kIoError, FaultLayer::Fault::kGone}) {
    const std::string path = folder.path(std::to_string(static_cast<int>(fault)) + ".palpate");
    auto recorder = made(path, {.file_system = FaultLayer::kName});
    std::vector<RecordedTick> given;
    const auto add = [&](std::uint64_t count) {
      for (std::uint64_t n = 0; n < count; ++n) {
        given.push_back(plain_row(given.size()));
        recorder->on_tick(given.back().record, given.back().reading);
      }
    };
    add(kBefore);
    std::this_thread::sleep_for(1s);  // several transactions
    FaultLayer::fail_at(1, fault);
    add(kAfter);
    const RecordingResult result = recorder->finish("end");
    recorder.reset();
    FaultLayer::heal();
    EXPECT_TRUE(result.error);
    const auto rows = read_back(path).rows;
    EXPECT_TRUE(is_prefix(rows, given));
    EXPECT_GE(rows.size(), kBefore);
    EXPECT_GE(rows.size(), result.ticks);
  }
}

TEST(Recorder, EndsIfItsFileIsRemoved) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.palpate");
  auto recorder = made(path, {});
  std::filesystem::remove(path);
  std::uint64_t tick = 0;
  for (; tick < 3'000 && !recorder->has_failed(); ++tick) {
    const RecordedTick row = plain_row(tick);
    recorder->on_tick(row.record, row.reading);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_TRUE(recorder->has_failed());
  const RecordingResult result = recorder->finish("end");
  ASSERT_TRUE(result.error);
  EXPECT_NE(result.error->problem.find("removed"), std::string::npos);
}

// The limit of the size of files, as on a full disk, in a process of its own.
TEST(Recorder, EndsAtTheLimitOfTheProcess) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.palpate");
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{400'000, 400'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto recorder = made(path, {.virtual_time = true});
    test::Random random(3);
    for (std::uint64_t tick = 0; tick < 20'000; ++tick) {
      RecordedTick row = plain_row(tick);
      for (double& number : row.record.goal_scene_m) number = random.uniform(0, 1);
      recorder->on_tick(row.record, row.reading);
      if (tick == 1'500) std::this_thread::sleep_for(1s);  // several transactions
    }
    ::_exit(recorder->finish("end").error ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const auto rows = read_back(path).rows;
  EXPECT_GE(rows.size(), 1'024u);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].record.tick, i);
}

// The ticks of a session on disks of several sizes, in real and in simulated time: what fits is
// kept, the ending says that the disk was full, and its numbers are true.
TEST(Recorder, AFullDiskKeepsWhatFitsAndHasAnEnding) {
  const TemporaryFolder folder;
  constexpr std::uint64_t kTicks = 12'000;
  for (const bool virtual_time : {true, false}) {
    for (rlim_t bytes = 250'000; bytes < 900'000; bytes += 163'000) {
      const std::string path =
          folder.path(std::to_string(bytes) + (virtual_time ? "v" : "r") + ".palpate");
      const pid_t child = ::fork();
      if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{bytes, bytes};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        auto recorder = made(path, {.virtual_time = virtual_time});
        test::Random random(3);
        for (std::uint64_t tick = 0; tick < kTicks && !recorder->has_failed(); ++tick) {
          RecordedTick row = plain_row(tick);
          for (auto* vector : {&row.record.goal_scene_m, &row.record.proxy_scene_m,
                               &row.record.device_m, &row.record.force_device_N}) {
            for (double& number : *vector) number = random.uniform(0, 1);
          }
          recorder->on_tick(row.record, row.reading);
          if (!virtual_time) std::this_thread::sleep_for(100us);
        }
        ::_exit(recorder->finish("end").error ? 0 : 1);
      }
      int status = 0;
      ASSERT_EQ(::waitpid(child, &status, 0), child);
      ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
      EXPECT_EQ(WEXITSTATUS(status), 0) << bytes;
      const auto rows = read_back(path).rows;
      EXPECT_GT(rows.size(), 200u) << bytes;
      for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i].record.tick, i);
      const auto reader = RecordingReader::open(path);
      ASSERT_TRUE(reader);
      const auto ending = reader->ending();
      ASSERT_TRUE(ending);
      ASSERT_TRUE(*ending) << bytes << (virtual_time ? " simulated" : " real");
      EXPECT_EQ((*ending)->why, kDiskFull);
      EXPECT_EQ((*ending)->ticks, static_cast<std::int64_t>(rows.size()));
      EXPECT_EQ((*ending)->dropped, 0);
    }
  }
}

// A session under real time, whose late ticks and measured times are whatever they are.
TEST(Recorder, RecordsARealTimeSessionThatReplays) {
  const TemporaryFolder folder;
  const Scene scene = test::compiled(test::scenario_description());
  RecordedSetup setup;
  setup.scene_path = folder.write("scenario.glb", "bytes");
  setup.haptics.a4.enabled = true;
  const auto meta = meta_of(scene, setup);
  ASSERT_TRUE(meta);
  auto recorder = Recorder::create(folder.path("a.palpate"), *meta, {});
  ASSERT_TRUE(recorder);
  TickKeeper keeper(recorder->get());
  test::FaultyDevice device(5, 1.0 / 200);
  test::Switches switches(6, 1.0 / 50);
  auto loop = test::made(HapticLoop::create(scene.world(), setup.actuation, setup.haptics));
  HapticSession session(loop, device, {.changes = {&switches}, .sink = &keeper});
  const auto ticks = test::in_soak_or_else<std::uint64_t>(60'000, 3'000);
  keeper.rows.reserve(ticks);
  std::atomic<bool> is_over{false};
  std::thread load([&] {  // another thread that wants the processor
    volatile double x = 0.0;
    while (!is_over) x = x + 1.0;
  });
  HapticThread thread(session, {1000.0, ticks});
  thread.start();
  while (thread.running()) {
    std::this_thread::sleep_for(37ms);
    session.rearm();
    session.set_paused(true);
    std::this_thread::sleep_for(3ms);
    session.set_paused(false);
  }
  thread.join();
  is_over = true;
  load.join();
  const RecordingResult result = (*recorder)->finish("end");
  ASSERT_FALSE(result.error);
  EXPECT_EQ(result.dropped, 0u);
  const auto reader = RecordingReader::open(folder.path("a.palpate"));
  ASSERT_TRUE(reader);
  const auto outcome = replay_recording(*reader, test::session_in(*reader), scene);
  ASSERT_TRUE(outcome) << outcome.error().to_string();
  EXPECT_FALSE(outcome->difference)
      << outcome->difference->tick << " " << outcome->difference->column << " "
      << outcome->difference->recorded << " " << outcome->difference->computed;
  EXPECT_EQ(outcome->proved, keeper.rows.size());
  EXPECT_GT(outcome->proved, ticks / 2);
}

// The trace of a recording is that of its records.
TEST(Recorder, ExportsTheTraceThatRunWouldHaveWritten) {
  const TemporaryFolder folder;
  Scenario scenario(8, {.ticks = 2'000});
  const TickKeeper given = test::recorded_scenario(scenario, folder.write("scenario.glb", "bytes"),
                                                   folder.path("a.palpate"));
  std::vector<TickRecord> records;
  for (const RecordedTick& row : given.rows) records.push_back(row.record);
  ASSERT_FALSE(write_trace(folder.path("run.csv"), records));
  const auto reader = RecordingReader::open(folder.path("a.palpate"));
  ASSERT_TRUE(reader);
  ASSERT_TRUE(export_recording(*reader, folder.path("export.csv")));
  const auto content = [&](const char* name) {
    std::ifstream file(folder.path(name), std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  EXPECT_FALSE(content("run.csv").empty());
  EXPECT_EQ(content("run.csv"), content("export.csv"));
}

}  // namespace
}  // namespace palpate
