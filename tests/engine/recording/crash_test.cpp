// Recordings of processes that were killed at random times.

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/recording/block_walk.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;
using test::TemporaryFolder;

RecordedTick noisy_row(std::uint64_t tick) {
  RecordedTick row;
  row.record.tick = tick;
  row.record.time_s = 1e-3 * static_cast<double>(tick);
  // Numbers without a pattern, so that blocks are as long as those of a real session.
  std::uint64_t state = tick + 1;
  for (double& number : row.record.goal_scene_m) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    number = static_cast<double>(state >> 11);
  }
  return row;
}

constexpr std::uint64_t kMostTicks = 4'000'000;

// When each tick was handed over, in memory that the killed process shares with the test.
struct Handed {
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::int64_t> at_ns[1 << 22];
};
static_assert(kMostTicks < 1 << 22);

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

[[noreturn]] void record_until_killed(const std::string& path, bool virtual_time, Handed& handed) {
  auto recorder = Recorder::create(path, {}, {.virtual_time = virtual_time});
  if (!recorder) ::_exit(1);
  auto due = Clock::now();
  for (std::uint64_t tick = 0; tick < kMostTicks; ++tick) {
    const RecordedTick row = noisy_row(tick);
    (*recorder)->on_input({InputKind::kA4, static_cast<std::uint32_t>(tick)});
    (*recorder)->on_tick(row.record, row.reading);
    handed.at_ns[tick].store(now_ns(), std::memory_order_relaxed);
    handed.ticks.store(tick + 1, std::memory_order_release);
    if (!virtual_time) std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
  }
  while (true) ::pause();
}

// Expects that what was recorded is a whole beginning of what was handed over, and that `check`
// says so. Everything is there that was handed over more than 500 ms before the end, not counting
// the time that the recorder waited for a core or a disk.
void expect_all_but_half_a_second(const std::string& path, const Handed& handed,
                                  std::int64_t killed_ns, std::int64_t waited_ns) {
  std::uint64_t promised = 0;
  const std::uint64_t ticks = handed.ticks.load(std::memory_order_acquire);
  const std::int64_t until_ns = killed_ns - 500'000'000 - waited_ns;
  while (promised < ticks && handed.at_ns[promised] < until_ns) ++promised;
  const auto reader = RecordingReader::open(path);
  if (!reader && promised == 0) return;  // killed before the tables were made
  ASSERT_TRUE(reader) << reader.error().to_string();
  BlockWalk walk(*reader);
  std::uint64_t next = 0;
  for (WalkStep step = walk.next(); step.kind != WalkStep::Kind::kEnd; step = walk.next()) {
    ASSERT_EQ(step.kind, WalkStep::Kind::kBlock) << step.error->to_string();
    ASSERT_EQ(step.missing, 0);
    EXPECT_EQ(step.content.inputs.size(), step.content.rows.size());
    for (const RecordedTick& row : step.content.rows) {
      const RecordedTick expected = noisy_row(next++);
      ASSERT_EQ(std::memcmp(&row, &expected, sizeof row), 0);
    }
  }
  EXPECT_GE(next, promised) << "of " << ticks << "; the recorder waited " << waited_ns << " ns";
  const auto check = check_recording(*reader);
  ASSERT_TRUE(check);
  EXPECT_TRUE(check->is_whole());
  EXPECT_EQ(check->ticks, next);
  EXPECT_FALSE(check->ending);
}

// Calls visit(folder of the thread in /proc) for each thread of a process but its first one.
template <typename Visit>
void for_each_other_thread(pid_t process, Visit visit) {
  std::error_code ignored;
  const std::string first = std::to_string(process);
  for (const auto& thread :
       std::filesystem::directory_iterator("/proc/" + first + "/task", ignored)) {
    if (thread.path().filename() != first) visit(thread.path());
  }
}

// How long the recorder of a process was ready and had no core: the second number of schedstat. 0
// if the system does not count it.
std::int64_t waited_for_a_core_ns(pid_t process) {
  std::int64_t waited_ns = 0;
  for_each_other_thread(process, [&](const std::filesystem::path& thread) {
    std::int64_t ran_ns = 0;
    std::int64_t thread_waited_ns = 0;
    std::ifstream schedstat(thread / "schedstat");
    if (schedstat >> ran_ns >> thread_waited_ns) waited_ns += thread_waited_ns;
  });
  return waited_ns;
}

// Whether the recorder of a process waits for a disk: the state D, behind the name in stat.
bool waits_for_a_disk(pid_t process) {
  bool waits = false;
  for_each_other_thread(process, [&](const std::filesystem::path& thread) {
    std::string line;
    std::ifstream stat(thread / "stat");
    if (!std::getline(stat, line)) return;
    const std::size_t name_end = line.rfind(") ");
    waits |= name_end != std::string::npos && line.compare(name_end + 2, 1, "D") == 0;
  });
  return waits;
}

// Waits, and returns for how long the recorder of a process waited for a disk meanwhile. A part
// between two looks counts if either finds the recorder waiting.
std::int64_t watch_disk_ns(pid_t process, Clock::duration time) {
  const auto end = Clock::now() + time;
  Clock::duration waited{};
  bool waited_before = false;
  for (auto last = Clock::now(); last < end;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const bool waits = waits_for_a_disk(process);
    const auto now = Clock::now();
    if (waits || waited_before) waited += now - last;
    waited_before = waits;
    last = now;
  }
  return std::chrono::duration_cast<std::chrono::nanoseconds>(waited).count();
}

void kill_at_random(bool virtual_time) {
  const TemporaryFolder folder;
  test::Random random(virtual_time ? 21 : 22);
  const int times = test::in_soak_or_else(100, 10);
  for (int n = 0; n < times; ++n) {
    void* memory = ::mmap(nullptr, sizeof(Handed), PROT_READ | PROT_WRITE,
                          MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    auto& handed = *static_cast<Handed*>(memory);  // zeros are its initial values
    const std::string path = folder.path(std::to_string(n) + ".palpate");
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_until_killed(path, virtual_time, handed);
    const std::int64_t disk_ns =
        watch_disk_ns(child, std::chrono::microseconds(static_cast<int>(random.uniform(0, 2e6))));
    const std::int64_t waited_ns = disk_ns + waited_for_a_core_ns(child);
    const std::int64_t killed_ns = now_ns();
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    expect_all_but_half_a_second(path, handed, killed_ns, waited_ns);
    ::munmap(memory, sizeof(Handed));
    ::unlink(path.c_str());
    ::unlink((path + "-wal").c_str());
  }
}

TEST(Crash, LosesLessThanHalfASecondInRealTime) {
  kill_at_random(false);
}

TEST(Crash, LosesLessThanHalfASecondInVirtualTime) {
  kill_at_random(true);
}

// A recording that another process writes is refused, and readable after that process has died.
TEST(Crash, ARecordingIsRefusedWhileItsProcessLives) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.palpate");
  void* memory = ::mmap(nullptr, sizeof(Handed), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto& handed = *static_cast<Handed*>(memory);
  const pid_t child = ::fork();
  if (child == 0) record_until_killed(path, false, handed);
  while (handed.ticks < 800) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto reader = RecordingReader::open(path);
  EXPECT_FALSE(reader);
  if (!reader) {
    EXPECT_NE(reader.error().to_string().find("is being recorded"), std::string::npos)
        << reader.error().to_string();
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const auto after = RecordingReader::open(path);
  ASSERT_TRUE(after) << after.error().to_string();
  EXPECT_TRUE(after->has_log());
  ::munmap(memory, sizeof(Handed));
}

}  // namespace
}  // namespace palpate
