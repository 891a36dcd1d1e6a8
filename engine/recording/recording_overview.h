#pragma once

// The length of a recording and its gaps, found without decompressing all of it.

#include <cstdint>
#include <optional>

#include "engine/recording/recording_reader.h"

namespace palpate {

struct RecordingOverview {
  std::uint64_t ticks = 0;     // in all blocks, as the file states their lengths
  std::uint64_t gaps = 0;      // places where ticks are missing
  std::uint64_t missing = 0;   // ticks in these gaps
  std::uint64_t end_tick = 0;  // after the last block
  // Of the last tick: the sum of the time steps before it, s. No value without a block that can be
  // read.
  std::optional<double> last_time_s;
  // A block cannot be read, or its numbers are wrong; the numbers above are those before it.
  // check_recording() says more.
  bool is_broken = false;
};

// The work is limited by the number of blocks in the file.
RecordingOverview overview_of(const RecordingReader& reader);

}  // namespace palpate
