#include "io/trajectory.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "geometry/base/file_roles.h"
#include "io/open_error.h"

namespace palpate {
namespace {

// Longer than any line of four numbers and a comment; prevents reading a binary file as a whole.
constexpr std::size_t kMaxLineBytes = 1u << 16;
constexpr std::size_t kMaxColumns = 4;

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr const char* kLineHint =
    "write \"x y z\" or \"t x y z\" on each line, with decimal points";
constexpr const char* kTraceHint = "complete the line with a newline, or delete it";

// The device columns of a trace, in the order x, y, z.
constexpr std::array<std::string_view, 3> kDeviceColumns = {"device_x", "device_y", "device_z"};

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Text from the file, quoted and limited to one line of a message.
std::string quoted(std::string_view text) {
  constexpr std::size_t kMaxLength = 40;
  std::string shown(text.substr(0, kMaxLength));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return "\"" + shown + (text.size() > kMaxLength ? "...\"" : "\"");
}

// The fields of a line without its comment. Fields are separated by a comma, with or without blanks
// around it, or by blanks alone. A field between two commas may be empty.
std::vector<std::string_view> split_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  line = trimmed(line);
  for (bool more = !line.empty(); more;) {
    const std::size_t end = std::min(line.find_first_of(" \t\r,"), line.size());
    fields.push_back(line.substr(0, end));
    const std::string_view rest = trimmed(line.substr(end));
    const bool comma = rest.starts_with(',');
    line = comma ? trimmed(rest.substr(1)) : rest;
    more = comma || !line.empty();
  }
  return fields;
}

enum class NumberKind { kNumber, kOutOfRange, kNone };

struct Number {
  NumberKind kind;
  double value;
};

Number parse_number(std::string_view field) {
  // from_chars() does not accept a plus sign.
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double value = 0.0;
  const char* end = field.data() + field.size();
  const auto [stop, code] = std::from_chars(field.data(), end, value);
  if (stop != end || code == std::errc::invalid_argument) return {NumberKind::kNone, 0.0};
  if (code == std::errc::result_out_of_range) return {NumberKind::kOutOfRange, 0.0};
  return {NumberKind::kNumber, value};
}

// The fields of a line separated by commas; fields may contain blanks or be empty. Without a comma,
// as split_fields().
std::vector<std::string_view> split_columns(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return split_fields(line);
  std::vector<std::string_view> columns;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    columns.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return columns;
}

// "t", "x", "y", "z" for "Time [s]", "x_m", "Y", "z (m)"; empty for an unknown name.
std::string_view known_name(std::string_view column) {
  std::string word;
  for (const char c : column) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (lower < 'a' || lower > 'z') break;
    word += lower;
  }
  if (word == "time") return "t";
  for (const std::string_view name : {"t", "x", "y", "z"}) {
    if (word == name) return name;
  }
  return {};
}

// The positions of the columns of a trace that are read.
struct TraceColumns {
  std::size_t count = 0;
  std::array<std::size_t, 3> device{};  // x, y, z
  std::optional<std::size_t> time;
};

class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::string& path) : path_(path) {}

  // is_whole: the line ended with a newline.
  std::optional<Error> read_line(std::string_view line, bool is_whole) {
    ++line_number_;
    if (line_number_ == 1 && line.starts_with(kByteOrderMark)) {
      line.remove_prefix(kByteOrderMark.size());
    }
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) return std::nullopt;
    const std::vector<std::string_view> fields = split_fields(line);
    const bool may_be_header = std::exchange(at_start_, false);
    if (may_be_header && is_header(fields)) return read_header(line);
    if (trace_) return read_trace_row(line, is_whole);
    return read_sample(fields);
  }

  Result<std::vector<Vec3>> finish() {
    if (positions_m_.empty()) {
      return Error{ErrorCode::kInvalidContent, path_, "", "contains no sample", kLineHint};
    }
    return std::move(positions_m_);
  }

  Error error_here(std::string problem, std::string hint = kLineHint) const {
    return {ErrorCode::kInvalidContent, path_, "line " + std::to_string(line_number_),
            std::move(problem), std::move(hint)};
  }

  void count_line() { ++line_number_; }

 private:
  // A line with at least one number is a sample, possibly with a typing error that must be
  // reported.
  static bool is_header(const std::vector<std::string_view>& fields) {
    for (const std::string_view field : fields) {
      if (field.empty() || parse_number(field).kind != NumberKind::kNone) return false;
    }
    return true;
  }

  std::optional<Error> read_header(std::string_view line) {
    // A column name may contain blanks ("x (m)") if commas separate the names.
    const std::vector<std::string_view> columns = split_columns(line);
    for (const std::string_view name : kDeviceColumns) {
      if (std::find(columns.begin(), columns.end(), name) != columns.end()) {
        return read_trace_header(columns);
      }
    }
    bool speaks = false;
    for (const std::string_view column : columns) speaks |= !known_name(column).empty();
    if (!speaks) return std::nullopt;
    static constexpr std::array<std::string_view, kMaxColumns> kOrder = {"t", "x", "y", "z"};
    const std::size_t skipped = columns.size() == 3 ? 1 : 0;
    bool in_order = columns.size() + skipped == kMaxColumns;
    for (std::size_t i = 0; in_order && i < columns.size(); ++i) {
      const std::string_view name = known_name(columns[i]);
      in_order = name.empty() || name == kOrder[i + skipped];
    }
    if (!in_order) {
      return error_here("is the header " + quoted(line) + "; expected the columns x y z or t x y z",
                        "reorder or delete columns of the file");
    }
    column_count_ = columns.size();
    column_line_ = line_number_;
    return std::nullopt;
  }

  std::optional<Error> read_trace_header(const std::vector<std::string_view>& columns) {
    TraceColumns trace;
    trace.count = columns.size();
    const auto place_of = [&](std::string_view name) -> std::optional<std::size_t> {
      const auto found = std::find(columns.begin(), columns.end(), name);
      const bool is_only =
          found != columns.end() && std::find(found + 1, columns.end(), name) == columns.end();
      if (!is_only) return std::nullopt;
      return static_cast<std::size_t>(found - columns.begin());
    };
    for (std::size_t axis = 0; axis < kDeviceColumns.size(); ++axis) {
      const auto place = place_of(kDeviceColumns[axis]);
      if (!place) {
        return error_here(
            "is the header of a trace; expected each of device_x, device_y and device_z once",
            "use a trace in the format of run or replay");
      }
      trace.device[axis] = *place;
    }
    trace.time = place_of("t");
    trace_ = trace;
    column_line_ = line_number_;
    return std::nullopt;
  }

  std::optional<Error> read_trace_row(std::string_view line, bool is_whole) {
    const std::vector<std::string_view> fields = split_columns(line);
    if (!is_whole || fields.size() != trace_->count) {
      const std::string found =
          is_whole ? "has " + std::to_string(fields.size()) + " columns" : "is cut off";
      return error_here(found + "; expected " + std::to_string(trace_->count) +
                            " columns as in line " + std::to_string(column_line_) +
                            ", and a newline",
                        kTraceHint);
    }
    Vec3 position_m;
    for (std::size_t axis = 0; axis < trace_->device.size(); ++axis) {
      const std::size_t place = trace_->device[axis];
      const Number number = parse_number(fields[place]);
      if (number.kind != NumberKind::kNumber) return field_error(place, fields[place], number.kind);
      position_m[static_cast<Eigen::Index>(axis)] = number.value;
    }
    if (trace_->time) {
      const std::string_view field = fields[*trace_->time];
      const Number time = parse_number(field);
      if (time.kind != NumberKind::kNumber) return field_error(*trace_->time, field, time.kind);
      if (auto error = check_time(time.value, field)) return error;
    }
    positions_m_.push_back(position_m);
    return std::nullopt;
  }

  std::optional<Error> read_sample(const std::vector<std::string_view>& fields) {
    if (auto error = check_column_count(fields.size())) return error;
    std::array<double, kMaxColumns> values{};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const Number number = parse_number(fields[i]);
      if (number.kind != NumberKind::kNumber) return field_error(i, fields[i], number.kind);
      values[i] = number.value;
    }
    const std::size_t first = fields.size() - 3;
    if (first == 1) {
      if (auto error = check_time(values[0], fields[0])) return error;
    }
    positions_m_.emplace_back(values[first], values[first + 1], values[first + 2]);
    return std::nullopt;
  }

  std::optional<Error> check_column_count(std::size_t count) {
    if (column_count_ == 0 && (count == 3 || count == kMaxColumns)) {
      column_count_ = count;
      column_line_ = line_number_;
    }
    if (count == column_count_) return std::nullopt;
    std::string expected = "3 or 4";
    if (column_count_ != 0) {
      expected =
          std::to_string(column_count_) + " columns as in line " + std::to_string(column_line_);
    }
    return error_here("has " + std::to_string(count) +
                      (count == 1 ? " column; expected " : " columns; expected ") + expected);
  }

  Error field_error(std::size_t i, std::string_view field, NumberKind kind) const {
    const std::string column = "column " + std::to_string(i + 1) + " ";
    if (field.empty()) return error_here(column + "is empty; expected a number");
    return error_here(column + "is " + quoted(field) + "; expected a number" +
                      (kind == NumberKind::kOutOfRange ? " within the range of a double" : ""));
  }

  std::optional<Error> check_time(double time, std::string_view field) {
    if (!std::isfinite(time)) {
      return error_here("time is " + quoted(field) + "; expected a finite number");
    }
    if (!(time > last_time_)) {
      return error_here("time " + quoted(field) + " does not increase",
                        trace_ ? "sort the lines by the column t"
                               : "sort the lines by the first of the 4 columns, the time");
    }
    last_time_ = time;
    return std::nullopt;
  }

  std::string path_;
  std::size_t line_number_ = 0;
  bool at_start_ = true;          // only empty lines and comments so far
  std::size_t column_count_ = 0;  // 0: unknown
  std::size_t column_line_ = 0;   // the line that determined it
  std::optional<TraceColumns> trace_;
  double last_time_ = -std::numeric_limits<double>::infinity();
  std::vector<Vec3> positions_m_;
};

constexpr const char* kExpectedFile = "use a text file of device positions";

}  // namespace

Result<std::vector<Vec3>> read_trajectory(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return open_error(path, EISDIR, kExpectedFile);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return open_error(path, errno != 0 ? errno : EIO, kExpectedFile);
  if (auto error = add_input(path)) return *error;
  TrajectoryReader reader(path);
  std::vector<char> line(kMaxLineBytes);
  while (file.getline(line.data(), static_cast<std::streamsize>(line.size()))) {
    // gcount() includes the newline; only the last line may lack one.
    const auto read = static_cast<std::size_t>(file.gcount()) - (file.eof() ? 0 : 1);
    if (auto error = reader.read_line({line.data(), read}, !file.eof())) return *error;
  }
  if (file.bad()) {
    return Error{ErrorCode::kFileUnreadable, path, "", "cannot be read to the end", ""};
  }
  if (!file.eof()) {
    reader.count_line();
    return reader.error_here("is longer than " + std::to_string(kMaxLineBytes) + " bytes");
  }
  return reader.finish();
}

}  // namespace palpate
