#include "engine/recording/recorded_tick.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

// The fields of a reading, as kRecordFields states those of a record.
#define PALPATE_READING(name, ...) \
  record_table::field<decltype(TickReading::name)>(#name, __VA_ARGS__)
#define PALPATE_AT(name) offsetof(TickReading, name), #name
constexpr std::array kReadingFields = {
    PALPATE_READING(sample_m, "m", "device", PALPATE_AT(sample_m)),
    PALPATE_READING(sequence, "1", "", PALPATE_AT(sequence)),
    PALPATE_READING(sample_ns, "ns", "", PALPATE_AT(sample_ns)),
    PALPATE_READING(dt_s, "s", "", PALPATE_AT(dt_s)),
    PALPATE_READING(due_ns, "ns", "", PALPATE_AT(due_ns)),
    PALPATE_READING(measured_dt_ns, "ns", "", PALPATE_AT(measured_dt_ns)),
    PALPATE_READING(sample_age_ns, "ns", "", PALPATE_AT(sample_age_ns)),
    PALPATE_READING(session_tick, "1", "", PALPATE_AT(session_tick)),
    PALPATE_READING(buttons, "1", "", PALPATE_AT(buttons)),
    PALPATE_READING(is_valid, "1", "", PALPATE_AT(is_valid)),
};
#undef PALPATE_READING
#undef PALPATE_AT

constexpr bool covers_reading() {
  std::size_t next = 0;
  for (const RecordField& field : kReadingFields) {
    if (field.offset != next) return false;
    next += field.bytes;
  }
  return next == sizeof(TickReading);
}
static_assert(covers_reading());

constexpr std::array<std::string_view, 3> kComputedReadings = {"measured_dt_ns", "sample_age_ns",
                                                               "session_tick"};

ColumnSource source_of_reading(std::string_view name) {
  for (const std::string_view computed : kComputedReadings) {
    if (name == computed) return ColumnSource::kComputed;
  }
  return ColumnSource::kRead;
}

std::string number_name(const RecordField& field, std::size_t k) {
  if (field.count == 1) return std::string(field.name);
  // A quaternion's name ends with the names of its numbers, a vector's with its unit.
  std::string name(field.name);
  const std::string_view axes = field.count == 4 ? "wxyz" : "xyz";
  if (field.count == 4 && name.ends_with("_wxyz")) name.resize(name.size() - 5);
  return name + '_' + axes[k];
}

// The members that version 2 added to the record.
constexpr std::array<std::string_view, 5> kMembersOfVersion2 = {"rules", "body", "material",
                                                                "contacts", "touch"};
constexpr int kFirstRuleBitOfVersion1 = 16;  // in the faults
constexpr std::string_view kRules = "rules";

int first_version(std::string_view member) {
  const auto end = kMembersOfVersion2.end();
  return std::find(kMembersOfVersion2.begin(), end, member) == end ? 1 : 2;
}

void add_columns(const RecordField& field, std::size_t begin, ColumnSource source,
                 std::vector<RecordColumn>& columns) {
  const std::size_t bytes = field.bytes / field.count;
  for (std::size_t k = 0; k < field.count; ++k) {
    columns.push_back({number_name(field, k), field.unit, field.frame, field.type,
                       begin + field.offset + k * bytes, bytes, source, first_version(field.name)});
  }
}

std::vector<RecordColumn> all_columns(int version) {
  std::vector<RecordColumn> columns;
  for (const RecordField& field : kRecordFields) {
    add_columns(field, offsetof(RecordedTick, record),
                field.is_of_session ? ColumnSource::kMeasured : ColumnSource::kComputed, columns);
  }
  for (const RecordField& field : kReadingFields) {
    add_columns(field, offsetof(RecordedTick, reading), source_of_reading(field.name), columns);
  }
  std::erase_if(columns, [&](const RecordColumn& c) { return c.first_version > version; });
  return columns;
}

// A value of each version of the format, made once.
template <typename Value, typename Make>
const Value& of_version(int version, const Make& make) {
  static const std::array<Value, kRecordingVersion> values = [&] {
    std::array<Value, kRecordingVersion> made;
    for (int v = 1; v <= kRecordingVersion; ++v) made[static_cast<std::size_t>(v - 1)] = make(v);
    return made;
  }();
  return values[static_cast<std::size_t>(version - 1)];
}

const char* numpy_type(FieldType type) {
  switch (type) {
    case FieldType::kUint64:
      return "<u8";
    case FieldType::kInt64:
      return "<i8";
    case FieldType::kDouble:
      return "<f8";
    case FieldType::kUint32:
      return "<u4";
    case FieldType::kUint16:
      return "<u2";
    case FieldType::kInt32:
      return "<i4";
  }
  return "";
}

const char* source_name(ColumnSource source) {
  switch (source) {
    case ColumnSource::kComputed:
      return "computed";
    case ColumnSource::kMeasured:
      return "measured";
    case ColumnSource::kRead:
      return "read";
  }
  return "";
}

std::string columns_text(int version) {
  nlohmann::ordered_json table = nlohmann::ordered_json::array();
  for (const RecordColumn& column : recorded_columns(version)) {
    table.push_back({{"name", column.name},
                     {"type", numpy_type(column.type)},
                     {"unit", column.unit},
                     {"frame", column.frame},
                     {"source", source_name(column.source)}});
  }
  return table.dump();
}

template <typename Number>
Number number_at(const RecordColumn& column, const RecordedTick& row) {
  Number number;
  std::memcpy(&number, reinterpret_cast<const char*>(&row) + column.offset, sizeof number);
  return number;
}

std::string double_text(double number) {
  std::array<char, 32> text{};
  if (std::isnan(number)) {
    const auto end = std::to_chars(text.data(), text.data() + text.size(),
                                   std::bit_cast<std::uint64_t>(number), 16);
    return "NaN 0x" + std::string(text.data(), end.ptr);
  }
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number);
  return std::string(text.data(), end.ptr);
}

}  // namespace

std::span<const RecordColumn> recorded_columns(int version) {
  return of_version<std::vector<RecordColumn>>(version, all_columns);
}

std::size_t recorded_row_bytes(int version) {
  std::size_t bytes = 0;
  for (const RecordColumn& column : recorded_columns(version)) bytes += column.bytes;
  return bytes;
}

void complete_row(int version, RecordedTick& row) {
  if (version >= 2) return;
  TickRecord& record = row.record;
  record.rules = record.faults >> kFirstRuleBitOfVersion1;
  record.faults &= (1u << kFirstRuleBitOfVersion1) - 1u;
  record.body = record.material = kTouchUnknown;
}

bool is_recorded(const RecordColumn& column, int version) {
  return column.first_version <= version || column.name == kRules;
}

const std::string& recorded_columns_json(int version) {
  return of_version<std::string>(version, columns_text);
}

int version_of_columns(const RecordingMeta& meta) {
  const auto found = meta.find("columns");
  const auto* const text = found == meta.end() ? nullptr : std::get_if<std::string>(&found->second);
  int version = kRecordingVersion;
  while (text && version > 1 && *text != recorded_columns_json(version)) --version;
  const bool is_known = text && *text == recorded_columns_json(version);
  return is_known ? version : kRecordingVersion;
}

std::string column_text(const RecordColumn& column, const RecordedTick& row) {
  switch (column.type) {
    case FieldType::kUint64:
      return std::to_string(number_at<std::uint64_t>(column, row));
    case FieldType::kInt64:
      return std::to_string(number_at<std::int64_t>(column, row));
    case FieldType::kDouble:
      return double_text(number_at<double>(column, row));
    case FieldType::kUint32:
      return std::to_string(number_at<std::uint32_t>(column, row));
    case FieldType::kUint16:
      return std::to_string(number_at<std::uint16_t>(column, row));
    case FieldType::kInt32:
      return std::to_string(number_at<std::int32_t>(column, row));
  }
  return "";
}

}  // namespace palpate
