#include "engine/recording/event_log.h"

#include <cmath>
#include <sstream>
#include <utility>

namespace palpate {

void EventLog::add(const RecordedEvent& event) {
  std::ostringstream detail;
  if (event.kind == EventKind::kTrip) {
    detail << kTripReasonNames[static_cast<std::size_t>(event.trip.reason)];
    if (event.trip.limit > 0.0) {
      detail << ": " << event.trip.value << ", limit " << event.trip.limit;
    }
    return add_row({event.tick, event.time_s, "trip", detail.str()});
  }
  detail << kLateCauseNames[static_cast<std::size_t>(event.cause)] << ": ended " << event.late_ns
         << " ns after its due time";
  add_row({event.tick, event.time_s, "late", detail.str()});
}

void EventLog::add_drop(std::uint64_t tick, double time_s, std::uint64_t count) {
  add_row({tick, time_s, "drop", std::to_string(count)});
}

void EventLog::add_row(EventRow row) {
  const double second = std::floor(row.time_s);
  if (second != second_) {
    end_second();
    second_ = second;
    rows_in_second_ = 0;
  }
  last_tick_ = row.tick;
  last_time_s_ = row.time_s;
  // One row of each second is left for "more".
  if (++rows_in_second_ >= kMostRowsPerSecond) {
    ++uncounted_;
    return;
  }
  rows_.push_back(std::move(row));
}

void EventLog::end_second() {
  if (uncounted_ == 0) return;
  rows_.push_back({last_tick_, last_time_s_, "more", std::to_string(uncounted_)});
  uncounted_ = 0;
}

std::vector<EventRow> EventLog::take_rows() {
  return std::exchange(rows_, {});
}

}  // namespace palpate
