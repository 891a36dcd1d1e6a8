#pragma once

// One row of a recording, and the table of its columns.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

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
};

// In the order in which a block holds them, which is that of their offsets. They cover every byte
// of a row exactly once.
std::span<const RecordColumn> recorded_columns();

// The table of columns as a recording holds it: a JSON array of objects with the keys name, type
// (as NumPy names it, such as "<f8"), unit, frame and source.
const std::string& recorded_columns_json();

// The value of a column in a row, as text: decimal digits that identify it, and the bits of a NaN.
std::string column_text(const RecordColumn& column, const RecordedTick& row);

}  // namespace palpate
