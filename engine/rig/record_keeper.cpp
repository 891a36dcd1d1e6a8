#include "engine/rig/record_keeper.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "engine/scene/memory_budget.h"

namespace palpate {
namespace {

constexpr double kMostTicks = 4e6;

}  // namespace

// Comparisons are false for NaN.
Result<std::uint64_t> kept_ticks(double seconds, double dt_s) {
  const double ticks = seconds / dt_s;
  if (ticks >= 1.0 && ticks <= kMostTicks) return static_cast<std::uint64_t>(std::llround(ticks));
  std::ostringstream text;
  text << "multiplied by `RunSettings::rate_Hz` gives " << ticks << " ticks; expected 1 to "
       << kMostTicks;
  return invalid_argument("seconds", text.str(), "choose a shorter run or another rate");
}

std::optional<Error> take_tick_memory(std::uint64_t ticks, MemoryLedger& ledger,
                                      std::string element) {
  ledger.begin("recording the ticks", std::move(element));
  return ledger.take(ticks * kBytesPerTick);
}

std::optional<Error> take_run_memory(std::uint64_t max_bytes, std::uint64_t taken_bytes,
                                     const char* advice, std::uint64_t ticks,
                                     MemoryLedger& ledger) {
  ledger = MemoryLedger(memory_limit(max_bytes));
  ledger.advise(advice);
  ledger.begin("preparing the run");
  if (auto error = ledger.take(taken_bytes)) return error;
  ledger.advise("choose a shorter run");
  return take_tick_memory(ticks, ledger, "seconds");
}

void RecordKeeper::on_tick(const TickRecord& record) noexcept {
  if (has_first_pass_) {
    if (record.tick >= records_.size()) return;
    std::int64_t& kept_ns = records_[record.tick].step_ns;
    kept_ns = std::min(kept_ns, record.step_ns);
    return;
  }
  if (count_ < records_.size()) records_[count_++] = record;
  summary_.add(record);
}

void RecordKeeper::on_trip(const GovernorTrip& trip) noexcept {
  if (!has_first_pass_) summary_.add(trip);
}

void RecordKeeper::end_pass(const HapticLoop& loop) {
  if (has_first_pass_) return;
  has_first_pass_ = true;
  records_.resize(count_);
  take_effects(loop, loop.settings().measures_effects, steps_of(records_), effects_);
}

RunRecords RecordKeeper::finish() {
  RunRecords run;
  run.summary = summary_.finish(steps_of(records_));
  run.summary.effect_ticks = effects_.effect_ticks;
  run.summary.effect_time_shares = effects_.effect_time_shares;
  run.records = std::move(records_);
  return run;
}

}  // namespace palpate
