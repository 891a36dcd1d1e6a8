#pragma once

// The blocks of a transaction that is not committed, which a full disk may make smaller.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/recording/recording_file.h"
#include "geometry/base/result.h"

namespace palpate {

struct PendingBlock {
  std::uint64_t first_tick = 0;
  std::size_t ticks = 0;
  std::vector<std::byte> columns;  // frames
  std::vector<std::byte> inputs;
};

// Keeps the blocks until they are committed, and counts the ticks that are. A block that begins
// with the tick of the block before it replaces that block. One thread owns an object.
class PendingBlocks {
 public:
  void add(PendingBlock block);
  // Adds the newest block to the open transaction of the file.
  std::optional<Error> write_last(RecordingFile& file) const;
  std::size_t bytes() const { return bytes_; }
  // The transaction was committed.
  void set_committed();
  // Commits the blocks one by one, after a rollback, until one does not fit, and then as many ticks
  // of that block as fit.
  void write_what_fits(RecordingFile& file);
  std::uint64_t committed_ticks() const { return closed_ticks_ + last_ticks_; }
  // After the last committed tick.
  std::uint64_t end_tick() const { return last_first_tick_ + last_ticks_; }

 private:
  bool commit(RecordingFile& file, const PendingBlock& block);
  void commit_part(RecordingFile& file, const PendingBlock& block);
  void count(const PendingBlock& block);

  std::vector<PendingBlock> blocks_;
  std::size_t bytes_ = 0;
  // Of committed blocks: the last one may still be replaced.
  std::uint64_t closed_ticks_ = 0;
  std::uint64_t last_first_tick_ = 0;
  std::uint64_t last_ticks_ = 0;
};

}  // namespace palpate
