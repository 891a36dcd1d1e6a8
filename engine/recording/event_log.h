#pragma once

// The rows of the table of events: at most 100 a second, the rest is counted.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/recording/recorder_rings.h"

namespace palpate {

struct EventRow {
  std::uint64_t tick = 0;
  double time_s = 0.0;
  std::string kind;  // "trip", "late", "drop", "more" or "inside"
  std::string detail;
};

// Makes rows of events. One thread owns it.
class EventLog {
 public:
  static constexpr std::size_t kMostRowsPerSecond = 100;

  void add(const RecordedEvent& event);
  // `count` ticks from `tick` on are missing.
  void add_drop(std::uint64_t tick, double time_s, std::uint64_t count);
  // Events that found no space on their way here.
  void add_lost(std::uint64_t count) { uncounted_ += count; }

  // The rows since the last call. Behind the rows of a second in which events were left out, a row
  // "more" has their number.
  std::vector<EventRow> take_rows();
  // Ends the last second. Call it once, before the last take_rows().
  void finish() { end_second(); }

 private:
  void add_row(EventRow row);
  void end_second();

  std::vector<EventRow> rows_;
  double second_ = -1.0;  // the one that rows_in_second_ belongs to
  std::size_t rows_in_second_ = 0;
  std::uint64_t uncounted_ = 0;
  std::uint64_t last_tick_ = 0;
  double last_time_s_ = 0.0;
};

}  // namespace palpate
