#include "engine/recording/block_walk.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace palpate {
namespace {

// Behind a place that SQLite cannot read, this many ticks are tried one by one, which covers a page
// of the database, then every kWideStep-th of kMostProbes more.
constexpr int kFineProbes = 4096;
constexpr std::int64_t kWideStep = 256;
constexpr int kMostProbes = 1 << 15;

// Inputs that repeat are compressed this much at most; more is the work of an attacker.
constexpr std::uint64_t kMostInflation = 400;
constexpr std::uint64_t kFreeInputBytes = std::uint64_t{64} << 20;

}  // namespace

BlockWalk::BlockWalk(const RecordingReader& reader) : reader_(reader) {
  const auto last = reader.last_block();
  if (last && *last) last_block_ = **last;
}

double BlockWalk::share() const {
  if (last_block_ <= 0) return 0.0;
  return std::clamp(static_cast<double>(search_from_) / static_cast<double>(last_block_), 0.0, 1.0);
}

WalkStep BlockWalk::broken(std::int64_t first_tick, Error error) const {
  error.path = reader_.path();
  error.element = "block at tick " + std::to_string(first_tick) +
                  (error.element.empty() ? "" : ", " + error.element);
  WalkStep step;
  step.kind = WalkStep::Kind::kBroken;
  step.first_tick = first_tick;
  step.error = std::move(error);
  return step;
}

// The first tick from which on SQLite finds blocks again; no value if there is none.
std::optional<std::int64_t> BlockWalk::find_reachable(std::int64_t from) const {
  const auto last = reader_.last_block();
  if (last && (!*last || **last < from)) return std::nullopt;
  std::int64_t bad = std::max<std::int64_t>(from, -1);
  for (int probe = 0; probe < kFineProbes + kMostProbes; ++probe) {
    const std::int64_t step = probe < kFineProbes ? 1 : kWideStep;
    if (bad > std::numeric_limits<std::int64_t>::max() - step) return std::nullopt;
    std::int64_t good = bad + step;
    if (!reader_.next_block(good)) {
      bad = good;
      continue;
    }
    while (good - bad > 1) {
      const std::int64_t middle = bad + (good - bad) / 2;
      (reader_.next_block(middle) ? good : bad) = middle;
    }
    return good;
  }
  return std::nullopt;
}

// Sums up what is read, before it is decompressed. An honest file holds all its frames.
bool BlockWalk::is_too_much(const RecordedBlock& frames) {
  frame_bytes_ += frames.columns.size() + frames.inputs.size();
  input_bytes_ += BlockDecoder::announced_input_bytes(frames.inputs);
  return frame_bytes_ > reader_.bytes() ||
         input_bytes_ > kFreeInputBytes + kMostInflation * reader_.bytes();
}

WalkStep BlockWalk::next() {
  if (has_ended_) return {};
  const auto found = reader_.next_block(search_from_);
  if (!found) {
    WalkStep step = broken(search_from_, found.error());
    step.kind = WalkStep::Kind::kUnreachable;
    const auto reachable = find_reachable(search_from_);
    has_ended_ = !reachable;
    if (reachable) search_from_ = *reachable;
    return step;
  }
  if (!*found) {
    has_ended_ = true;
    return {};
  }
  const std::int64_t first_tick = **found;
  if (first_tick == std::numeric_limits<std::int64_t>::max()) has_ended_ = true;
  if (!has_ended_) search_from_ = first_tick + 1;
  auto frames = reader_.block(first_tick);
  if (!frames) return broken(first_tick, frames.error());
  if (is_too_much(*frames)) {
    has_ended_ = true;
    return broken(first_tick, {ErrorCode::kLimitExceeded, "", "",
                               "holds, with those before it, more than the file can", ""});
  }
  auto content = decoder_.decode(first_tick, frames->ticks, frames->columns, frames->inputs,
                                 reader_.version());
  if (!content) return broken(first_tick, content.error());
  if (first_tick < next_tick_) {
    return broken(first_tick,
                  {ErrorCode::kInvalidContent, "", "", "repeats ticks of the block before it", ""});
  }
  WalkStep step;
  step.kind = WalkStep::Kind::kBlock;
  step.first_tick = first_tick;
  step.missing = first_tick - next_tick_;
  next_tick_ = first_tick + frames->ticks;
  step.frames = std::move(*frames);
  step.content = std::move(*content);
  return step;
}

}  // namespace palpate
