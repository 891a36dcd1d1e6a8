#pragma once

// One row of a recording, and the table of its columns.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "engine/recording/recording_meta.h"
#include "engine/recording/recording_schema.h"
#include "engine/session/tick_sink.h"
#include "palpate/record.h"

namespace palpate {

// Plain numbers without padding.
struct RecordedTick {
  TickRecord record;
  TickReading reading;
};
static_assert(std::is_trivially_copyable_v<RecordedTick>);
static_assert(sizeof(RecordedTick) == sizeof(TickRecord) + sizeof(TickReading));

// Where the numbers of a column come from.
enum class ColumnSource : std::uint8_t {
  kComputed,  // replay computes the same bits again
  kMeasured,  // by a clock; not compared
  kRead       // from outside; an input of the replay
};

// One column of a block: one number of each row.
struct RecordColumn {
  std::string name;  // "goal_scene_m_x"
  std::string_view unit;
  std::string_view frame;
  FieldType type;
  std::size_t offset;  // in RecordedTick, in bytes
  std::size_t bytes;   // of one number
  ColumnSource source;
  int first_version;  // of the format: older recordings do not have the column
};

// The columns of a version of the format, in the order in which a block holds them, which is that
// of their offsets. Those of kRecordingVersion cover every byte of a row exactly once. version: 1
// to kRecordingVersion.
std::span<const RecordColumn> recorded_columns(int version = kRecordingVersion);
// The bytes of a row in a block.
std::size_t recorded_row_bytes(int version = kRecordingVersion);

// Completes a row of an older version: the rules of the governor move from the upper 16 bits of the
// faults, where version 1 has them, to their own member; what is touched is unknown.
void complete_row(int version, RecordedTick& row);

// Whether a recording of this version states the number of a column, in the column or elsewhere.
bool is_recorded(const RecordColumn& column, int version);

// The table of columns as a recording holds it: a JSON array of objects with the keys name, type
// (as NumPy names it, such as "<f8"), unit, frame and source.
const std::string& recorded_columns_json(int version = kRecordingVersion);
// The version of the format that has the table of columns which a meta holds; kRecordingVersion if
// none has it.
int version_of_columns(const RecordingMeta& meta);

// The value of a column in a row, as text: decimal digits that identify it, and the bits of a NaN.
std::string column_text(const RecordColumn& column, const RecordedTick& row);

}  // namespace palpate
