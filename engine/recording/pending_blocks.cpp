#include "engine/recording/pending_blocks.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "engine/recording/block_codec.h"

namespace palpate {
namespace {

std::optional<Error> write(RecordingFile& file, const PendingBlock& block) {
  return file.add_block(static_cast<std::int64_t>(block.first_tick),
                        static_cast<std::int64_t>(block.ticks), block.columns, block.inputs);
}

// The bytes of the inputs of the first `ticks` rows, with their headers. Inputs are in the order of
// their rows.
std::span<const std::byte> inputs_of(const BlockContent& content, std::size_t ticks) {
  std::size_t at = 0;
  const std::span<const std::byte> bytes = content.input_bytes;
  while (at < bytes.size()) {
    InputHeader header;
    std::memcpy(&header, bytes.data() + at, sizeof header);
    if (header.row >= ticks) break;
    at += sizeof header + header.bytes;
  }
  return bytes.first(at);
}

}  // namespace

void PendingBlocks::add(PendingBlock block) {
  bytes_ += block.columns.size() + block.inputs.size();
  blocks_.push_back(std::move(block));
}

std::optional<Error> PendingBlocks::write_last(RecordingFile& file) const {
  return write(file, blocks_.back());
}

void PendingBlocks::count(const PendingBlock& block) {
  if (block.first_tick != last_first_tick_) closed_ticks_ += last_ticks_;
  last_first_tick_ = block.first_tick;
  last_ticks_ = block.ticks;
}

void PendingBlocks::set_committed() {
  for (const PendingBlock& block : blocks_) count(block);
  blocks_.clear();
  bytes_ = 0;
}

bool PendingBlocks::commit(RecordingFile& file, const PendingBlock& block) {
  if (!file.begin() && !write(file, block) && !file.commit()) {
    count(block);
    return true;
  }
  file.rollback();
  return false;
}

void PendingBlocks::write_what_fits(RecordingFile& file) {
  for (const PendingBlock& block : blocks_) {
    if (commit(file, block)) continue;
    if (file.is_full()) commit_part(file, block);
    break;
  }
  blocks_.clear();
  bytes_ = 0;
}

// The number of ticks is found by halving.
void PendingBlocks::commit_part(RecordingFile& file, const PendingBlock& block) {
  BlockDecoder decoder;
  const auto content =
      decoder.decode(static_cast<std::int64_t>(block.first_tick),
                     static_cast<std::int64_t>(block.ticks), block.columns, block.inputs);
  if (!content) return;
  BlockEncoder encoder;
  const auto part_of = [&](std::size_t ticks) {
    const auto columns = encoder.columns(std::span(content->rows).first(ticks));
    const auto inputs = encoder.inputs(inputs_of(*content, ticks));
    return PendingBlock{
        block.first_tick, ticks, {columns.begin(), columns.end()}, {inputs.begin(), inputs.end()}};
  };
  // Of a block that is committed already, only a longer one is better.
  const std::size_t committed = block.first_tick == last_first_tick_ ? last_ticks_ : 0;
  std::size_t fits = committed;
  std::size_t too_many = block.ticks;
  while (too_many - fits > 1) {
    const std::size_t ticks = fits + (too_many - fits) / 2;
    const PendingBlock part = part_of(ticks);
    if (part.columns.empty() || part.inputs.empty()) return;  // no memory to compress
    const bool is_small_enough = !file.begin() && !write(file, part) && file.fits();
    file.rollback();
    (is_small_enough ? fits : too_many) = ticks;
  }
  if (fits > committed) commit(file, part_of(fits));
}

}  // namespace palpate
