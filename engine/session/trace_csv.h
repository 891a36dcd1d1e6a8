#pragma once

// Writes the records of a haptic loop as a CSV table, one line per tick.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/report/csv.h"
#include "engine/report/whole_file.h"
#include "geometry/base/result.h"
#include "palpate/record.h"

namespace palpate {

// The header line of a trace: the column names, joined by commas. Each number of each field in
// kRecordFields has one column. The order of the columns differs from that of the fields: new
// columns are always added at the end. Angles are in degrees. Faults, rules of the governor and
// effects are written as names joined by "+"; the field is empty if there are none. The friction
// state is a name. A touch is "began", "ended" or empty. Body, material and the number of contacts
// are empty if they are unknown (kTouchUnknown).
const std::string& trace_columns();

// Writes a trace: trace_columns(), then one line per record (CsvLines). Equal records give equal
// bytes. The file appears when finish() succeeds (WholeFile). Not for the haptic thread, because it
// does I/O. Only one thread may use a writer.
class TraceWriter {
 public:
  // Returns an error if the file cannot be created.
  static Result<TraceWriter> create(const std::string& path);

  // finish() reports write errors. Records added after finish() are discarded.
  void add(const TickRecord& record);

  // Completes the file and returns the number of records. Call it once.
  Result<std::size_t> finish();

 private:
  explicit TraceWriter(WholeFile file) : file_(std::move(file)), lines_(trace_columns()) {}

  WholeFile file_;
  CsvLines lines_;
  std::size_t count_ = 0;
};

// Writes a complete trace of all records. progress: called now and then with the share that is
// done; may be empty.
std::optional<Error> write_trace(const std::string& path, const std::vector<TickRecord>& records,
                                 const std::function<void(double)>& progress = {});

// The names of the faults of a tick, or of the governor's rules that acted in it, joined by "+";
// empty if there are none. A bit without a name is "bit_" followed by its number.
std::string fault_names(std::uint32_t faults);
std::string rule_names(std::uint32_t rules);

// "none", "sticks" or "slides".
std::string_view friction_name(FrictionState friction);

}  // namespace palpate
