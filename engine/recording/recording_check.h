#pragma once

// What is in a recording, whether it is whole, and copies of its parts.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/recording/recording_reader.h"
#include "geometry/base/result.h"

namespace palpate {

// Ticks first to first + count - 1.
struct TickRange {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

struct RecordingCheck {
  std::uint64_t blocks = 0;  // whose checksums hold
  std::uint64_t ticks = 0;   // in these blocks
  std::uint64_t inputs = 0;
  std::vector<TickRange> gaps;        // at most kMostListed
  std::uint64_t missing = 0;          // ticks in all gaps
  std::vector<std::string> problems;  // one line each, at most kMostListed
  std::uint64_t problem_count = 0;
  std::optional<RecordedEnding> ending;  // no value after a crash

  static constexpr std::size_t kMostListed = 100;

  // Nothing is missing and all checksums hold; a crash is allowed to have cut the end.
  bool is_whole() const { return missing == 0 && problem_count == 0; }
};

// Called now and then with the share of the recording that is done; may be empty.
using RecordingProgress = std::function<void(double)>;

// Proves every checksum.
Result<RecordingCheck> check_recording(const RecordingReader& reader,
                                       const RecordingProgress& progress = {});

// Copies each block that can be read and whose checksums hold into a new file, and as much of the
// settings and events as can be read. Returns the check of the original. An error if the new file
// exists or cannot be written.
Result<RecordingCheck> repair_recording(const RecordingReader& reader, const std::string& to,
                                        const RecordingProgress& progress = {});

// Writes the trace that `run` would have written (TraceWriter). The ticks of broken blocks are
// missing. Returns the check.
Result<RecordingCheck> export_recording(const RecordingReader& reader, const std::string& to,
                                        const RecordingProgress& progress = {});

}  // namespace palpate
