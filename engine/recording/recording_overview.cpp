#include "engine/recording/recording_overview.h"

#include <limits>

#include "engine/recording/block_codec.h"

namespace palpate {
namespace {

std::optional<double> last_time_of(const RecordingReader& reader, std::int64_t first_tick) {
  const auto block = reader.block(first_tick);
  if (!block) return std::nullopt;
  BlockDecoder decoder;
  const auto content =
      decoder.decode(first_tick, block->ticks, block->columns, block->inputs, reader.version());
  if (!content || content->rows.empty()) return std::nullopt;
  return content->rows.back().record.time_s;
}

}  // namespace

RecordingOverview overview_of(const RecordingReader& reader) {
  RecordingOverview found;
  std::int64_t end = 0;
  std::optional<std::int64_t> last_block;
  for (;;) {
    const auto first = reader.next_block(end);
    if (!first) found.is_broken = true;
    if (!first || !*first) break;
    const auto ticks = reader.block_ticks(**first);
    const bool is_block = ticks && *ticks > 0 &&
                          *ticks <= static_cast<std::int64_t>(kMostBlockTicks) &&
                          **first <= std::numeric_limits<std::int64_t>::max() - *ticks;
    if (!is_block) {
      found.is_broken = true;
      break;
    }
    last_block = **first;
    if (*last_block > end) ++found.gaps;
    found.missing += static_cast<std::uint64_t>(*last_block - end);
    found.ticks += static_cast<std::uint64_t>(*ticks);
    end = *last_block + *ticks;
  }
  found.end_tick = static_cast<std::uint64_t>(end);
  if (last_block) found.last_time_s = last_time_of(reader, *last_block);
  return found;
}

}  // namespace palpate
