#pragma once

// The two frames of a block: columns and inputs (FORMAT.md).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/recording/recorded_tick.h"
#include "engine/session/tick_sink.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr std::size_t kMostBlockTicks = 1024;
// Of all inputs of one block, as bytes before compression; a recorder closes a block before. The
// smallest inputs take three times as much memory once they are unpacked.
inline constexpr std::size_t kMostBlockInputBytes = std::size_t{4} << 20;

// Before the bytes of each input in the frame.
struct InputHeader {
  std::uint32_t row;   // in the block
  std::uint16_t kind;  // InputKind
  std::uint16_t bytes;
  std::uint32_t handle;
};
static_assert(sizeof(InputHeader) == 12);

// An input of a block. Its bytes lie in BlockContent::input_bytes.
struct BlockInput {
  std::uint32_t row;
  TickInput input;
};

struct BlockContent {
  std::vector<RecordedTick> rows;
  std::vector<std::byte> input_bytes;
  std::vector<BlockInput> inputs;  // in the order in which they acted
};

// Compresses blocks. Not thread-safe.
class BlockEncoder {
 public:
  BlockEncoder();
  ~BlockEncoder();
  // A zstd frame with content size and checksum; valid until the next call of the same function.
  // rows: 1 to kMostBlockTicks. Empty if the compressor has no memory.
  std::span<const std::byte> columns(std::span<const RecordedTick> rows);
  // bytes: InputHeaders and bytes of all inputs, one after the other.
  std::span<const std::byte> inputs(std::span<const std::byte> bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Decompresses blocks of a file that may be hostile. Takes memory only after the content size of a
// frame was found right. Not thread-safe.
class BlockDecoder {
 public:
  BlockDecoder();
  ~BlockDecoder();
  // The content size that an inputs frame announces, at most kMostBlockInputBytes; 0 if it has
  // none.
  static std::size_t announced_input_bytes(std::span<const std::byte> inputs);
  // ticks: as the file states it. version: of the format. Error::element is "columns" or "inputs".
  Result<BlockContent> decode(std::int64_t first_tick, std::int64_t ticks,
                              std::span<const std::byte> columns, std::span<const std::byte> inputs,
                              int version = kRecordingVersion);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
