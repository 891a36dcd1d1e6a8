#pragma once

// Reads a recording that may be broken or hostile.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/recording/block_codec.h"
#include "engine/recording/event_log.h"
#include "engine/recording/recording_meta.h"
#include "geometry/base/result.h"

namespace palpate {

struct RecordedBlock {
  std::int64_t first_tick = 0;
  std::int64_t ticks = 0;
  std::vector<std::byte> columns;  // frames
  std::vector<std::byte> inputs;
};

struct RecordedEnding {
  std::int64_t ticks = 0;
  std::int64_t dropped = 0;
  std::string why;
};

// Whether the content of a file is that of a recording, whatever its name. False for a file that
// cannot be read.
bool is_recording(const std::string& path);

// A recording that is read. A log that a crash has left is used. Nothing on the disk is changed.
// All texts of errors are printable lines. One thread may use it.
class RecordingReader {
 public:
  // Returns an error if the file is no recording, is being recorded by a living process, or has
  // tables other than those of a recording.
  static Result<RecordingReader> open(const std::string& path);

  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  ~RecordingReader();

  // Reads the table meta.
  Result<RecordingMeta> meta() const;
  // As much of it as can be read.
  RecordingMeta readable_meta() const;
  // The ending; no value after a crash.
  Result<std::optional<RecordedEnding>> ending() const;
  // At most `most` events, in the order in which they were written.
  Result<std::vector<EventRow>> events(std::size_t most) const;

  // The first tick of the first block at or after `first_tick`; no value at the end.
  Result<std::optional<std::int64_t>> next_block(std::int64_t first_tick) const;
  // The first tick of the last block.
  Result<std::optional<std::int64_t>> last_block() const;
  // The number of ticks of the block that begins with this tick, as the file states it.
  Result<std::int64_t> block_ticks(std::int64_t first_tick) const;
  // The frames of a block that begins with this tick. Their length is checked before they are read.
  Result<RecordedBlock> block(std::int64_t first_tick) const;

  // The length of the file and of its log.
  std::uint64_t bytes() const;
  bool has_log() const;
  // The file expects a log, which is not beside it. A recording without ending has then lost its
  // newest ticks.
  bool lacks_log() const;
  const std::string& path() const;
  // Of the format: 1 to kRecordingVersion.
  int version() const;

 private:
  struct State;
  explicit RecordingReader(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace palpate
