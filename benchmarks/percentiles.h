#pragma once

// Times every sample of a path and reports percentiles over the samples.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/caches.h"
#include "engine/session/run_summary.h"

namespace palpate::bench {

// Number of passes over a path. The shortest time of each sample counts, because interruptions
// rarely hit the same sample in every pass. Unless the caches are evicted, they stay warm from
// sample to sample; on a device, with a millisecond between ticks, they may not.
inline constexpr std::size_t kRepeats = 6;

// The time since `start` by std::chrono::steady_clock, which is read before and after every sample.
// On Linux this clock reads the same time stamp counter as rdtscp, and either reading takes 20 ns,
// so rdtscp would gain nothing. The counter may advance in coarser steps than a nanosecond (10 ns
// on AMD processors).
inline std::int64_t nanoseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count();
}

// The time that reading the clock takes: the median time of empty samples. Like the time of every
// sample, the time of an empty sample is the shortest of kRepeats times. The median is subtracted
// from every time and reported as clock_ns.
inline std::int64_t clock_overhead_ns() {
  static const std::int64_t median = [] {
    std::vector<std::int64_t> empty(10001, std::numeric_limits<std::int64_t>::max());
    for (std::size_t repeat = 0; repeat < kRepeats; ++repeat) {
      for (std::int64_t& time_ns : empty) {
        time_ns = std::min(time_ns, nanoseconds_since(std::chrono::steady_clock::now()));
      }
    }
    return StepTimes::of(empty).p50_ns;
  }();
  return median;
}

inline void report_percentiles(benchmark::State& state, const std::vector<std::int64_t>& times_ns) {
  const StepTimes steps = StepTimes::of(times_ns);
  state.counters["p50_ns"] = static_cast<double>(steps.p50_ns);
  state.counters["p99_ns"] = static_cast<double>(steps.p99_ns);
  state.counters["p999_ns"] = static_cast<double>(steps.p999_ns);
  state.counters["max_ns"] = static_cast<double>(steps.max_ns);
  state.counters["clock_ns"] = static_cast<double>(clock_overhead_ns());
}

using SampleError = const char*;  // null: no error

struct Samples {
  std::size_t count;
  Caches caches;  // state of the caches before every sample
};

// Runs the path kRepeats times, one sample per iteration. Only sample(n) is timed. begin_pass()
// runs before each pass. before_sample(n) brings the sample's input back into the caches. A
// SampleError returned by after_sample(n) ends the benchmark. Google Benchmark's own time is the
// mean over all passes. The benchmark must be registered with UseManualTime() and
// Iterations(kRepeats * count).
template <typename BeginPass, typename BeforeSample, typename Sample, typename AfterSample>
void time_path(benchmark::State& state, const Samples& samples, BeginPass begin_pass,
               BeforeSample before_sample, Sample sample, AfterSample after_sample) {
  const std::int64_t clock_ns = clock_overhead_ns();
  std::vector<std::int64_t> shortest_ns(samples.count, std::numeric_limits<std::int64_t>::max());
  std::size_t n = 0;
  for ([[maybe_unused]] auto iteration : state) {
    if (n == 0) begin_pass();
    if (samples.caches == Caches::kEvicted) evict_l1_and_l2();
    before_sample(n);
    const auto start = std::chrono::steady_clock::now();
    sample(n);
    const std::int64_t time_ns = std::max<std::int64_t>(0, nanoseconds_since(start) - clock_ns);
    if (const SampleError error = after_sample(n)) {
      state.SkipWithError(error);
      return;
    }
    shortest_ns[n] = std::min(shortest_ns[n], time_ns);
    state.SetIterationTime(static_cast<double>(time_ns) * 1e-9);
    n = n + 1 == samples.count ? 0 : n + 1;
  }
  report_percentiles(state, shortest_ns);
}

}  // namespace palpate::bench
