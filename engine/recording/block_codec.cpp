#include "engine/recording/block_codec.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <zstd.h>

namespace palpate {
namespace {

// Higher levels shorten a block by a few per cent and take many times as long.
constexpr int kLevel = 3;
// A frame is at most kMostBlockInputBytes long, so that no window needs to be longer.
constexpr int kMostWindowLog = 22;
static_assert(std::size_t{1} << kMostWindowLog == kMostBlockInputBytes);

// Columns lie one after the other. In a column, the first bytes of all numbers come first, then
// their second bytes, and so on.
void gather(std::span<const RecordedTick> rows, std::byte* to) {
  const auto* from = reinterpret_cast<const std::byte*>(rows.data());
  for (const RecordColumn& column : recorded_columns()) {
    for (std::size_t b = 0; b < column.bytes; ++b) {
      const std::byte* byte = from + column.offset + b;
      for (std::size_t i = 0; i < rows.size(); ++i) *to++ = byte[i * sizeof(RecordedTick)];
    }
  }
}

void scatter(const std::byte* from, int version, std::span<RecordedTick> rows) {
  auto* to = reinterpret_cast<std::byte*>(rows.data());
  for (const RecordColumn& column : recorded_columns(version)) {
    for (std::size_t b = 0; b < column.bytes; ++b) {
      std::byte* byte = to + column.offset + b;
      for (std::size_t i = 0; i < rows.size(); ++i) byte[i * sizeof(RecordedTick)] = *from++;
    }
  }
}

Error bad_frame(const char* name, std::string problem) {
  return {ErrorCode::kInvalidContent, "", name, std::move(problem), ""};
}

// The bit of the frame's first byte after the magic number that announces a checksum.
constexpr std::byte kChecksumBit{0x04};
constexpr std::size_t kDescriptorAt = 4;

// Checks the length that a frame announces before memory is taken for it.
std::optional<Error> check_frame(const char* name, std::span<const std::byte> frame,
                                 std::size_t least, std::size_t most) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || frame.size() <= kDescriptorAt) {
    return bad_frame(name, "is no zstd frame");
  }
  if (size == ZSTD_CONTENTSIZE_UNKNOWN) return bad_frame(name, "is a frame without content size");
  if ((frame[kDescriptorAt] & kChecksumBit) == std::byte{0}) {
    return bad_frame(name, "is a frame without checksum");
  }
  if (size < least || size > most) {
    return bad_frame(
        name, "has the content size " + std::to_string(size) + "; expected " +
                  (least == most ? std::to_string(least) : "at most " + std::to_string(most)));
  }
  const std::size_t length = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(length) != 0 || length != frame.size()) {
    return bad_frame(name, "is not one whole zstd frame");
  }
  return std::nullopt;
}

// Splits the content of an inputs frame. Null, or what is wrong.
const char* split_inputs(std::size_t ticks, BlockContent& content) {
  std::span<const std::byte> left = content.input_bytes;
  std::uint32_t last_row = 0;
  while (!left.empty()) {
    InputHeader header;
    if (left.size() < sizeof header) return "ends within an input";
    std::memcpy(&header, left.data(), sizeof header);
    left = left.subspan(sizeof header);
    if (header.bytes > left.size()) return "ends within an input";
    if (header.row >= ticks || header.row < last_row) return "has an input of a tick out of order";
    if (header.kind >= kInputKinds.size()) return "has an input of an unknown kind";
    const InputKindFacts& facts = kInputKinds[header.kind];
    if (header.bytes < facts.least_bytes || header.bytes > facts.most_bytes) {
      return "has an input with a wrong number of bytes";
    }
    last_row = header.row;
    content.inputs.push_back(
        {header.row,
         {static_cast<InputKind>(header.kind), header.handle, left.first(header.bytes)}});
    left = left.subspan(header.bytes);
  }
  return nullptr;
}

}  // namespace

struct BlockEncoder::State {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  std::vector<std::byte> plain;
  std::vector<std::byte> columns;
  std::vector<std::byte> inputs;

  State() {
    if (!context) return;
    ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, kLevel);
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 1);
  }
  ~State() { ZSTD_freeCCtx(context); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::span<const std::byte> compressed(std::span<const std::byte> bytes,
                                        std::vector<std::byte>& frame) {
    if (!context) return {};
    frame.resize(ZSTD_compressBound(bytes.size()));
    const std::size_t length =
        ZSTD_compress2(context, frame.data(), frame.size(), bytes.data(), bytes.size());
    if (ZSTD_isError(length) != 0) return {};
    return std::span(frame).first(length);
  }
};

BlockEncoder::BlockEncoder() : state_(std::make_unique<State>()) {}
BlockEncoder::~BlockEncoder() = default;

std::span<const std::byte> BlockEncoder::columns(std::span<const RecordedTick> rows) {
  state_->plain.resize(rows.size_bytes());
  gather(rows, state_->plain.data());
  return state_->compressed(state_->plain, state_->columns);
}

std::span<const std::byte> BlockEncoder::inputs(std::span<const std::byte> bytes) {
  return state_->compressed(bytes, state_->inputs);
}

struct BlockDecoder::State {
  ZSTD_DCtx* context = ZSTD_createDCtx();

  State() {
    if (context) ZSTD_DCtx_setParameter(context, ZSTD_d_windowLogMax, kMostWindowLog);
  }
  ~State() { ZSTD_freeDCtx(context); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::optional<Error> decompress(const char* name, std::span<const std::byte> frame,
                                  std::size_t least, std::size_t most,
                                  std::vector<std::byte>& content) {
    if (auto error = check_frame(name, frame, least, most)) return error;
    content.resize(ZSTD_getFrameContentSize(frame.data(), frame.size()));
    if (!context) return Error{ErrorCode::kOutOfMemory, "", name, "needs memory to decompress", ""};
    const std::size_t length =
        ZSTD_decompressDCtx(context, content.data(), content.size(), frame.data(), frame.size());
    if (ZSTD_isError(length) != 0) {
      return bad_frame(name, std::string("cannot be decompressed: ") + ZSTD_getErrorName(length));
    }
    if (length != content.size()) return bad_frame(name, "is shorter than its content size");
    return std::nullopt;
  }
};

BlockDecoder::BlockDecoder() : state_(std::make_unique<State>()) {}
BlockDecoder::~BlockDecoder() = default;

std::size_t BlockDecoder::announced_input_bytes(std::span<const std::byte> inputs) {
  const unsigned long long size = ZSTD_getFrameContentSize(inputs.data(), inputs.size());
  return size <= kMostBlockInputBytes ? static_cast<std::size_t>(size) : 0;  // else: refused
}

Result<BlockContent> BlockDecoder::decode(std::int64_t first_tick, std::int64_t ticks,
                                          std::span<const std::byte> columns,
                                          std::span<const std::byte> inputs, int version) {
  if (first_tick < 0 || ticks < 1 || ticks > static_cast<std::int64_t>(kMostBlockTicks)) {
    return bad_frame("block", "has " + std::to_string(ticks) + " ticks from tick " +
                                  std::to_string(first_tick) + " on; expected 1 to " +
                                  std::to_string(kMostBlockTicks) + " from 0 or later on");
  }
  const auto count = static_cast<std::size_t>(ticks);
  const std::size_t bytes = count * recorded_row_bytes(version);
  std::vector<std::byte> plain;
  if (auto error = state_->decompress("columns", columns, bytes, bytes, plain)) return *error;
  BlockContent content;
  if (auto error =
          state_->decompress("inputs", inputs, 0, kMostBlockInputBytes, content.input_bytes)) {
    return *error;
  }
  content.rows.resize(count);
  scatter(plain.data(), version, content.rows);
  for (RecordedTick& row : content.rows) complete_row(version, row);
  for (std::size_t i = 0; i < count; ++i) {
    if (content.rows[i].record.tick != static_cast<std::uint64_t>(first_tick) + i) {
      return bad_frame("columns", "holds tick " + std::to_string(content.rows[i].record.tick) +
                                      " in place of tick " +
                                      std::to_string(static_cast<std::uint64_t>(first_tick) + i));
    }
  }
  if (const char* problem = split_inputs(count, content)) return bad_frame("inputs", problem);
  return content;
}

}  // namespace palpate
