#pragma once

// Keeps the record of every tick of a run in memory, and sums the records up.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/session/haptic_session.h"
#include "engine/session/run_summary.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"

namespace palpate {

// The records of a run, and what follows from them.
struct RunRecords {
  std::vector<TickRecord> records;  // step_ns of a tick: its shortest time in all passes
  RunSummary summary;
};

// Memory for each tick of a run: its record, and its time when the summary sorts the times.
inline constexpr std::uint64_t kBytesPerTick = sizeof(TickRecord) + sizeof(std::int64_t);

// The number of ticks of a run whose ticks are kept. Returns an error that names the setting
// `seconds` if it is not 1 to 4 million; one hour at 1 kHz is below this limit.
Result<std::uint64_t> kept_ticks(double seconds, double dt_s);

// Takes the memory of these ticks from the ledger. element: see MemoryLedger::begin().
std::optional<Error> take_tick_memory(std::uint64_t ticks, MemoryLedger& ledger,
                                      std::string element = {});

// The same for a run of a program that has a limit. max_bytes includes taken_bytes, which the
// caller already uses; 0: half of the free memory (memory_budget.h). advice: the hint if not even
// the taken bytes fit.
std::optional<Error> take_run_memory(std::uint64_t max_bytes, std::uint64_t taken_bytes,
                                     const char* advice, std::uint64_t ticks, MemoryLedger& ledger);

// Observes a session, or several that run the same ticks one after another: the first pass gives
// the records, and each later pass replaces the time of a tick if it was shorter.
//
// The haptic thread calls the functions of TickObserver; the owner calls the others while no
// session runs.
class RecordKeeper final : public TickObserver {
 public:
  // Allocates the memory of `ticks` records; later ticks only count in the summary.
  explicit RecordKeeper(std::uint64_t ticks) : records_(ticks) {}

  void on_tick(const TickRecord& record) noexcept override;
  void on_trip(const GovernorTrip& trip) noexcept override;

  // Ends a pass. loop: of its session. A pass that was interrupted must be the only one.
  void end_pass(const HapticLoop& loop);
  // Hands over what was kept. Call it once, after the last pass.
  RunRecords finish();

 private:
  std::vector<TickRecord> records_;
  std::size_t count_ = 0;
  SummaryAccumulator summary_;
  bool has_first_pass_ = false;
  RunSummary effects_;  // of the first pass; the step times come from all passes
};

}  // namespace palpate
