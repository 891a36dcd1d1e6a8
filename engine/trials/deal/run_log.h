#pragma once

// A log of times of day and of computing times. Results contain no times, so that repeated runs
// give the same results.

#include <cstdint>
#include <mutex>
#include <string>

namespace palpate {

// Appends lines with the time (UTC) to a file. Errors of writing are ignored, because no result
// depends on the log. Thread-safe.
class RunLog {
 public:
  explicit RunLog(std::string path) : path_(std::move(path)) {}
  void add(const std::string& line);

 private:
  std::string path_;
  std::mutex mutex_;
};

// "384 trials, 10368000 ticks in 17.6 s: 1.7 us a tick, 0.9 us of them in the haptic loop".
// loop_ns: the time in the haptic loop, with the clock reads that measure it.
std::string computing_text(std::uint64_t trials, std::uint64_t ticks, double seconds,
                           std::int64_t loop_ns);

}  // namespace palpate
