#include "engine/session/trace_csv.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

#include "haptics/effects/effect_program.h"

namespace palpate {
namespace {

// The order of the columns. It is part of the format: add new fields at the end.
constexpr std::array<std::string_view, kRecordFields.size()> kOrder = {
    "tick",         "time_s",         "device_m",     "goal_scene_m", "proxy_scene_m",
    "normal_scene", "force_device_N", "contact",      "alpha_rad",    "q_before_wxyz",
    "o_before_m",   "friction",       "faults",       "step_ns",      "full_force_device_N",
    "q_after_wxyz", "o_after_m",      "rotation_rad", "effects",      "iterations",
    "late_ns",      "rules",          "body",         "material",     "contacts",
    "touch"};

// How a field is written.
enum class Form : std::uint8_t {
  kNumbers,
  kDegrees,
  kFaults,
  kEffects,
  kFriction,
  kRules,
  kTouched,
  kTouch
};

struct Column {
  RecordField field;
  Form form;
};

constexpr Form form_of(const RecordField& field) {
  if (field.unit == "rad") return Form::kDegrees;
  if (field.name == "faults") return Form::kFaults;
  if (field.name == "effects") return Form::kEffects;
  if (field.name == "friction") return Form::kFriction;
  if (field.name == "rules") return Form::kRules;
  if (field.name == "body" || field.name == "material" || field.name == "contacts") {
    return Form::kTouched;
  }
  if (field.name == "touch") return Form::kTouch;
  return Form::kNumbers;
}

// Does not compile if a name in kOrder is not a field or occurs twice.
consteval std::array<Column, kOrder.size()> columns_in_order() {
  std::array<Column, kOrder.size()> columns{};
  std::array<bool, kRecordFields.size()> is_taken{};
  for (std::size_t i = 0; i < kOrder.size(); ++i) {
    std::size_t f = 0;
    while (kRecordFields[f].name != kOrder[i] || is_taken[f]) ++f;
    is_taken[f] = true;
    columns[i] = {kRecordFields[f], form_of(kRecordFields[f])};
  }
  return columns;
}
constexpr auto kColumns = columns_in_order();

std::string joined_columns() {
  std::string text;
  for (const Column& column : kColumns) {
    const std::string_view axes = column.field.count == 4 ? "wxyz" : "xyz";
    for (std::size_t k = 0; k < column.field.count; ++k) {
      if (!text.empty()) text += ',';
      text += column.field.column;
      if (column.field.count > 1) text += {'_', axes[k]};
    }
  }
  return text;
}

template <typename Number>
void put_numbers(const char* bytes, std::size_t count, CsvLines& lines) {
  for (std::size_t k = 0; k < count; ++k) {
    Number value;
    std::memcpy(&value, bytes + k * sizeof(Number), sizeof(Number));
    lines.add(value);
  }
}

void put_numbers(const RecordField& field, const char* bytes, CsvLines& lines) {
  switch (field.type) {
    case FieldType::kUint64:
      return put_numbers<std::uint64_t>(bytes, field.count, lines);
    case FieldType::kInt64:
      return put_numbers<std::int64_t>(bytes, field.count, lines);
    case FieldType::kDouble:
      return put_numbers<double>(bytes, field.count, lines);
    case FieldType::kUint32:
      return put_numbers<std::uint32_t>(bytes, field.count, lines);
    case FieldType::kUint16:
      return put_numbers<std::uint16_t>(bytes, field.count, lines);
    case FieldType::kInt32:
      return put_numbers<std::int32_t>(bytes, field.count, lines);
  }
}

double in_degrees(const char* bytes) {
  double angle_rad = 0.0;
  std::memcpy(&angle_rad, bytes, sizeof angle_rad);
  return angle_rad * 180.0 / std::numbers::pi;
}

void join(std::string& names, std::string_view name) {
  if (!names.empty()) names += '+';
  names += name;
}

// A bit without a name is written as its number.
std::string bit_names(std::uint32_t bits, std::span<const std::string_view> names) {
  std::string text;
  for (std::size_t bit = 0; bits != 0; ++bit, bits >>= 1) {
    if ((bits & 1u) == 0) continue;
    join(text, bit < names.size() ? std::string(names[bit]) : "bit_" + std::to_string(bit));
  }
  return text;
}

std::string effect_names(std::uint32_t effects) {
  std::string names;
  for (std::size_t i = 0; i < compiled_effects().size(); ++i) {
    if ((effects >> i & 1u) != 0) join(names, compiled_effects()[i].name);
  }
  return names;
}

std::string_view touch_name(std::uint16_t touch) {
  if ((touch & kTouchBegan) != 0) return "began";
  return (touch & kTouchEnded) != 0 ? "ended" : "";
}

void put(const Column& column, const TickRecord& record, CsvLines& lines) {
  const char* bytes = reinterpret_cast<const char*>(&record) + column.field.offset;
  switch (column.form) {
    case Form::kNumbers:
      return put_numbers(column.field, bytes, lines);
    case Form::kDegrees:
      lines.add(in_degrees(bytes));
      return;
    case Form::kFaults:
      lines.add(fault_names(record.faults));
      return;
    case Form::kEffects:
      lines.add(effect_names(record.effects));
      return;
    case Form::kFriction:
      lines.add(friction_name(record.friction));
      return;
    case Form::kRules:
      lines.add(rule_names(record.rules));
      return;
    case Form::kTouched:
      if (record.body != kTouchUnknown) return put_numbers(column.field, bytes, lines);
      lines.add("");
      return;
    case Form::kTouch:
      lines.add(touch_name(record.touch));
      return;
  }
}

}  // namespace

const std::string& trace_columns() {
  static const std::string columns = joined_columns();
  return columns;
}

Result<TraceWriter> TraceWriter::create(const std::string& path) {
  auto file = WholeFile::create(path);
  if (!file) return file.error();
  return TraceWriter(std::move(*file));
}

void TraceWriter::add(const TickRecord& record) {
  for (const Column& column : kColumns) put(column, record, lines_);
  lines_.end_line();
  ++count_;
  constexpr std::size_t kBlockBytes = 1u << 16;
  if (lines_.text().size() < kBlockBytes) return;
  file_.add(lines_.text());
  lines_.clear();
}

Result<std::size_t> TraceWriter::finish() {
  file_.add(lines_.text());
  lines_.clear();
  if (auto error = file_.finish()) return *error;
  return count_;
}

std::optional<Error> write_trace(const std::string& path, const std::vector<TickRecord>& records,
                                 const std::function<void(double)>& progress) {
  constexpr std::size_t kRecordsBetweenProgress = 1024;
  Result<TraceWriter> writer = TraceWriter::create(path);
  if (!writer) return writer.error();
  for (std::size_t n = 0; n < records.size(); ++n) {
    if (progress && n % kRecordsBetweenProgress == 0) {
      progress(static_cast<double>(n) / static_cast<double>(records.size()));
    }
    writer->add(records[n]);
  }
  const Result<std::size_t> written = writer->finish();
  if (!written) return written.error();
  return std::nullopt;
}

std::string fault_names(std::uint32_t faults) {
  return bit_names(faults, kFaultNames);
}

std::string rule_names(std::uint32_t rules) {
  return bit_names(rules, kGovernorRuleNames);
}

std::string_view friction_name(FrictionState friction) {
  switch (friction) {
    case FrictionState::kSticks:
      return "sticks";
    case FrictionState::kSlides:
      return "slides";
    case FrictionState::kNone:
      break;
  }
  return "none";
}

}  // namespace palpate
