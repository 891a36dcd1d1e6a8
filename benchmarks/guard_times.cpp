// Measures the time from a fault of an engine until the board has read a command of zero force,
// with the engine and the guard as real processes and a fake board on a pseudo-terminal, beside a
// load.
//
// usage: guard_times [--repeats=N] [--load=N] [--seed=N] [--csv=FILE]
//
// Each fault is measured twice: through a pseudo-terminal and through a pair of sockets. Bytes for
// a pseudo-terminal wait for a worker of the kernel, which has ordinary priority, so that the load
// delays them; the driver of a USB port has no such worker.
//
// load: processes of ordinary priority that compute without end. The board reads with a priority
// above the guard's, since a board is not slowed down by the host's load. A sample during which the
// force was zero already when the fault happened counts as tripped: the load had delayed the
// engine.

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

#include "tests/engine/devices/board_terminal.h"
#include "tests/engine/devices/engine_process.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

struct Options {
  int repeats = 100;
  int load = 7;
  unsigned seed = 1;
  std::string csv;
};

struct Fault {
  const char* name;
  int signal;
  double aim_ms;
};
constexpr Fault kFaults[] = {{"gone (SIGKILL)", SIGKILL, 10.0},
                             {"crashed (SIGSEGV)", SIGSEGV, 35.0},
                             {"frozen (SIGSTOP)", SIGSTOP, 35.0}};

// One row of the table. Times in ms.
struct Row {
  const char* scheduling;
  const char* port;
  const char* fault;
  std::vector<double> times_ms;  // sorted
  int tripped = 0;
  int missing = 0;  // no zero within 2 s

  double at(double share) const {  // nearest rank
    if (times_ms.empty()) return 0.0;
    const auto rank =
        static_cast<std::size_t>(share * static_cast<double>(times_ms.size()) + 0.999);
    return times_ms[std::clamp<std::size_t>(rank, 1, times_ms.size()) - 1];
  }
};

// The priority of the board, and of the thread that causes the fault: above the guard's.
constexpr int kPriority = kGuardPriority + 5;

// Causes the fault and returns when, without being preempted by the load in between.
std::int64_t cause(const Fault& fault, const WatchedProcess& engine) {
  const sched_param above{kPriority};
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &above);
  const std::int64_t now_ns = monotonic_ns();
  engine.send(fault.signal);
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  return now_ns;
}

// Records how late a thread of the highest priority wakes.
class Probe {
 public:
  Probe() : thread_([this] { run(); }) {
    const sched_param highest{sched_get_priority_max(SCHED_FIFO)};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &highest);
  }
  ~Probe() {
    ends_.store(true);
    thread_.join();
  }
  Probe(const Probe&) = delete;
  Probe& operator=(const Probe&) = delete;

  // The largest lateness since the last call, ms.
  double worst_ms() { return 1e-6 * static_cast<double>(worst_ns_.exchange(0)); }

 private:
  void run() {
    while (!ends_.load()) {
      const std::int64_t start_ns = monotonic_ns();
      ::usleep(1000);
      const std::int64_t late_ns = monotonic_ns() - start_ns - 1'000'000;
      if (late_ns > worst_ns_.load()) worst_ns_.store(late_ns);
    }
  }

  std::atomic<bool> ends_{false};
  std::atomic<std::int64_t> worst_ns_{0};
  std::thread thread_;
};

// Adds one sample to the row. Returns false if the engine does not start.
bool measure_once(const Fault& fault, const char* behaviour, FakeBoardTerminal::Kind kind,
                  int delay_ms, Probe& probe, Row& row) {
  FakeBoardTerminal board(kind);
  board.set_priority(kPriority);
  const EngineProcess process(PALPATE_GUARDED_ENGINE, board.port(), behaviour);
  if (!process.has_started() || !wait_for([&] { return !board.is_zero(); }, 5.0)) return false;
  std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
  const bool was_zero = board.is_zero();
  probe.worst_ms();
  const auto before = board.log();
  const std::int64_t fault_ns = cause(fault, process.engine());
  if (was_zero) {
    ++row.tripped;
    return true;
  }
  std::int64_t zero_ns = 0;
  const bool came = wait_for([&] {
    for (const auto& entry : board.log()) {
      if (entry.is_zero && entry.first_ns >= fault_ns) zero_ns = entry.first_ns;
    }
    return zero_ns != 0;
  });
  if (came) {
    const double time_ms = 1e-6 * static_cast<double>(zero_ns - fault_ns);
    row.times_ms.push_back(time_ms);
    if (time_ms > fault.aim_ms) {
      const double age_ms = 1e-6 * static_cast<double>(fault_ns - before.back().last_ns);
      std::printf(
          "%s, %s, %s: %.2f ms; probe late by %.2f ms; last command %.2f ms before the fault\n",
          row.scheduling, row.port, fault.name, time_ms, probe.worst_ms(), age_ms);
    }
  } else {
    ++row.missing;
  }
  return true;
}

void print(const std::vector<Row>& rows, const Options& options) {
  std::printf(
      "seed %u, load %d, %d faults a row; ms from the fault to the zero read by the board\n",
      options.seed, options.load, options.repeats);
  std::printf("%-10s %-9s %-18s %8s %8s %8s %8s %8s %8s\n", "guard", "port", "fault", "samples",
              "median", "99 %", "worst", "tripped", "missing");
  for (const Row& row : rows) {
    std::printf("%-10s %-9s %-18s %8zu %8.2f %8.2f %8.2f %8d %8d\n", row.scheduling, row.port,
                row.fault, row.times_ms.size(), row.at(0.5), row.at(0.99), row.at(1.0), row.tripped,
                row.missing);
  }
}

bool write_csv(const std::vector<Row>& rows, const Options& options) {
  std::ofstream file(options.csv);
  file << "seed,load,guard,port,fault,samples,median_ms,p99_ms,worst_ms,tripped,missing\n";
  for (const Row& row : rows) {
    file << options.seed << ',' << options.load << ',' << row.scheduling << ',' << row.port << ','
         << row.fault << ',' << row.times_ms.size() << ',' << row.at(0.5) << ',' << row.at(0.99)
         << ',' << row.at(1.0) << ',' << row.tripped << ',' << row.missing << '\n';
  }
  return static_cast<bool>(file.flush());
}

int measure(const Options& options) {
  if (const std::string lack = test::lack_of_terminals(); !lack.empty()) {
    std::printf("%s\n", lack.c_str());
    return 77;
  }
  const BusyProcesses load(options.load);
  Probe probe;
  std::mt19937 random(options.seed);
  std::vector<Row> rows;
  using Kind = FakeBoardTerminal::Kind;
  for (const bool has_fifo : {true, false}) {
    for (const Kind kind : {Kind::kTerminal, Kind::kSockets}) {
      for (const Fault& fault : kFaults) {
        Row row{has_fifo ? "FIFO" : "ordinary",
                kind == Kind::kTerminal ? "terminal" : "sockets",
                fault.name,
                {}};
        for (int i = 0; i < options.repeats; ++i) {
          const int delay_ms = 20 + static_cast<int>(random() % 50);
          if (!measure_once(fault, has_fifo ? "run" : "no-fifo", kind, delay_ms, probe, row)) {
            std::fprintf(stderr, "guard_times: the engine did not start\n");
            return 1;
          }
        }
        std::sort(row.times_ms.begin(), row.times_ms.end());
        rows.push_back(row);
      }
    }
  }
  print(rows, options);
  if (!options.csv.empty() && !write_csv(rows, options)) {
    std::fprintf(stderr, "guard_times: %s: cannot be written\n", options.csv.c_str());
    return 1;
  }
  int missing = 0;
  for (const Row& row : rows) missing += row.missing;
  return missing == 0 ? 0 : 1;
}

// Returns whether all arguments are known.
bool parse(int count, char** arguments, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string word = arguments[i];
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    if (value.empty()) return false;
    if (name == "--csv") {
      options.csv = value;
      continue;
    }
    const int number = std::atoi(value.c_str());
    if (name == "--repeats" && number > 0) {
      options.repeats = number;
    } else if (name == "--load" && number >= 0) {
      options.load = number;
    } else if (name == "--seed" && number >= 0) {
      options.seed = static_cast<unsigned>(number);
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  palpate::Options options;
  if (!palpate::parse(count, arguments, options)) {
    std::fprintf(stderr, "usage: guard_times [--repeats=N] [--load=N] [--seed=N] [--csv=FILE]\n");
    return 2;
  }
  return palpate::measure(options);
}
