#pragma once

// Visits the blocks of a recording in the order of their ticks.

#include <cstdint>
#include <limits>
#include <optional>

#include "engine/recording/block_codec.h"
#include "engine/recording/recording_reader.h"
#include "geometry/base/result.h"

namespace palpate {

// What a step of a walk found.
struct WalkStep {
  enum class Kind : std::uint8_t {
    kBlock,        // a block whose checksums hold
    kBroken,       // a block that cannot be read, or whose checksums or content are wrong
    kUnreachable,  // SQLite does not reach the blocks from here on to the next step
    kEnd
  };
  Kind kind = Kind::kEnd;
  std::int64_t first_tick = 0;
  std::int64_t missing = 0;  // of kBlock: ticks between the end of the last good block and this one
  RecordedBlock frames;      // of kBlock
  BlockContent content;      // of kBlock
  std::optional<Error> error = {};  // of kBroken and kUnreachable
};

// A walk over a file that may be hostile: the work is limited by the length of the file. The reader
// must outlive the walk.
class BlockWalk {
 public:
  explicit BlockWalk(const RecordingReader& reader);

  WalkStep next();
  // After the last good block.
  std::int64_t next_tick() const { return next_tick_; }
  // The share of the recording before the place of the last step, 0 to 1.
  double share() const;

 private:
  WalkStep broken(std::int64_t first_tick, Error error) const;
  std::optional<std::int64_t> find_reachable(std::int64_t from) const;
  bool is_too_much(const RecordedBlock& frames);

  const RecordingReader& reader_;
  BlockDecoder decoder_;
  std::int64_t search_from_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t next_tick_ = 0;
  std::int64_t last_block_ = 0;  // its first tick; 0 if it is unknown
  std::uint64_t frame_bytes_ = 0;
  std::uint64_t input_bytes_ = 0;
  bool has_ended_ = false;
};

}  // namespace palpate
