#pragma once

// What a haptic loop did, tick by tick, written as a table.

#include <cstddef>
#include <cstdint>
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

// The columns of a trace, joined by commas: one for each number of the fields of kRecordFields, in
// an order of their own, in which new ones come last. Angles are in degrees; faults, effects and
// friction are names, joined by "+" and empty for none.
const std::string& trace_columns();

// Writes a trace: trace_columns(), then a line for each record (CsvLines). The same records give
// the same bytes. The file is there when finish() has succeeded (WholeFile). Not for the haptic
// thread: it does I/O. One thread owns a writer.
class TraceWriter {
 public:
  // Fails where the file could not be created.
  static Result<TraceWriter> create(const std::string& path);

  // A failure to write shows in finish(). Records after finish() are dropped.
  void add(const TickRecord& record);

  // Returns the number of records. To be called once.
  Result<std::size_t> finish();

 private:
  explicit TraceWriter(WholeFile file) : file_(std::move(file)), lines_(trace_columns()) {}

  WholeFile file_;
  CsvLines lines_;
  std::size_t count_ = 0;
};

// All of them, as a whole file.
std::optional<Error> write_trace(const std::string& path, const std::vector<TickRecord>& records);

// The names of the faults of a tick, joined by "+"; empty for none. Those of a governor are
// "governor_" and the number of the bit.
std::string fault_names(std::uint32_t faults);

// "none", "sticks" or "slides".
std::string_view friction_name(FrictionState friction);

}  // namespace palpate
