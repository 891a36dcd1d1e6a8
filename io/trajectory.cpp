#include "io/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "geometry/base/file_roles.h"
#include "geometry/base/quoted.h"
#include "io/decimal_time.h"
#include "io/measuring_units.h"
#include "io/text_fields.h"
#include "io/text_lines.h"
#include "io/trajectory_columns.h"
#include "io/trajectory_comments.h"
#include "io/trajectory_notes.h"

namespace palpate {
namespace {

constexpr const char* kLineHint =
    "write \"x y z\" or \"t x y z\" on each line, with decimal points, or name the columns in a "
    "header";
constexpr const char* kCommaHint =
    "if its commas are decimal commas, separate the columns with semicolons";
constexpr const char* kTimeUnitHint =
    "correct the times, or state their unit in a header, such as \"t [ns]\"";
constexpr const char* kTraceHint = "complete the line with a newline, or delete it";
constexpr const char* kExpectedFile = "use a text file of device positions";

// A line whose fields all begin like words. "1mm" and "--3" begin like numbers with a typing error.
bool is_text(const std::vector<TextField>& fields) {
  constexpr std::string_view kBeginsNumber = "+-.,0123456789";
  return std::all_of(fields.begin(), fields.end(), [&](const TextField& field) {
    return !field.text.empty() &&
           kBeginsNumber.find(field.text.front()) == std::string_view::npos &&
           parse_number(field.text).kind == NumberKind::kNone;
  });
}

// Where the comment of a line begins: at #, or at % or // at its beginning.
std::size_t comment_mark(std::string_view line) {
  const std::string_view text = trimmed(line);
  if (text.starts_with('%') || text.starts_with("//")) return 0;
  return line.find('#');
}

class TrajectoryReader {
 public:
  TrajectoryReader(const std::string& path, std::optional<double> rate_Hz)
      : path_(path), rate_Hz_(rate_Hz) {}

  // is_whole: the line ended with a newline.
  std::optional<Error> read_line(std::string_view line, std::size_t number, bool is_whole) {
    line_number_ = number;
    const std::size_t mark = comment_mark(line);
    if (mark != std::string_view::npos && trajectory_.positions_m.empty()) {
      if (auto error = take_comment(line.substr(mark))) return error;
    }
    line = trimmed(line.substr(0, mark));
    if (line.empty()) return std::nullopt;
    if (line.find_first_not_of('\0') == std::string_view::npos) {
      return error_here("has only bytes of value 0; expected text",
                        "delete the end of a file that was not written completely");
    }
    if (!columns_) {
      const auto separator = separator_of_header(line);
      if (is_header(line, separator)) return take_header(line);
      if (auto error = begin_without_header(line)) return error;
    } else if (trajectory_.positions_m.empty() && !std::exchange(has_units_line_, true)) {
      if (take_units(line)) return std::nullopt;
    }
    if (trajectory_.positions_m.empty()) {
      if (auto error = error_of(comments_.apply_units(*columns_, column_line_))) return error;
    }
    return read_row(line, is_whole);
  }

  Result<Trajectory> finish() {
    if (trajectory_.positions_m.empty()) {
      return Error{ErrorCode::kInvalidContent, path_, "", "contains no sample", kLineHint};
    }
    const TrajectoryFacts facts{*columns_, comments_.naming_line(), comments_.unit_line(),
                                decimal_comma_line_, rate_Hz_};
    trajectory_.notes = trajectory_notes(facts);
    trajectory_.warnings = comments_.warnings(*columns_);
    trajectory_.stated_rate_Hz = comments_.rate_Hz();
    trajectory_.stated_rate_line = comments_.rate_line();
    trajectory_.has_summed_times = columns_->is_trace;
    return std::move(trajectory_);
  }

 private:
  Error error_here(std::string problem, std::string hint = kLineHint) const {
    return {ErrorCode::kInvalidContent, path_, "line " + std::to_string(line_number_),
            std::move(problem), std::move(hint)};
  }

  std::optional<Error> error_of(std::optional<LineProblem> problem) const {
    if (!problem) return std::nullopt;
    return Error{ErrorCode::kInvalidContent, path_, "line " + std::to_string(problem->line),
                 std::move(problem->problem), std::move(problem->hint)};
  }

  // ---- header and comments ----

  static bool is_header(std::string_view line, Separator separator) {
    std::vector<TextField> fields = split_fields(line, separator);
    // Columns without a name, as of a row number or after a last separator.
    const bool has_name = std::any_of(fields.begin(), fields.end(),
                                      [](const TextField& field) { return !field.text.empty(); });
    if (separator != Separator::kBlankOrComma && has_name) {
      std::erase_if(fields, [](const TextField& field) { return field.text.empty(); });
    }
    return is_text(fields);
  }

  std::optional<Error> take_header(std::string_view line) {
    HeaderReading reading = read_header(line);
    if (!reading.columns) {
      return error_here(std::move(reading.problem),
                        reading.names_positions ? std::move(reading.hint)
                                                : reading.hint + "; a comment begins with #");
    }
    columns_ = std::move(reading.columns);
    column_line_ = line_number_;
    return std::nullopt;
  }

  // A line of units below the names: "s,mm,mm,mm".
  bool take_units(std::string_view line) {
    if (columns_->is_trace || columns_->states_length) return false;
    const auto fields = split_fields(line, separator_of_row(line, columns_->separator));
    if (fields.size() != columns_->count) return false;
    std::array<LengthUnit, 3> length;
    const auto unit_text = [&](std::size_t i) {
      std::string_view text = fields[i].text;
      while (!text.empty() && (text.front() == '[' || text.front() == '(')) text.remove_prefix(1);
      while (!text.empty() && (text.back() == ']' || text.back() == ')')) text.remove_suffix(1);
      return text;
    };
    for (std::size_t axis = 0; axis < length.size(); ++axis) {
      const auto unit = find_length_unit(unit_text(columns_->position[axis]));
      if (!unit) return false;
      length[axis] = *unit;
    }
    if (columns_->time) {
      const auto unit = find_time_unit(unit_text(*columns_->time));
      columns_->counts_samples = is_count_unit(unit_text(*columns_->time));
      if (!unit && !columns_->counts_samples) return false;
      if (unit) columns_->time_unit = *unit;
    }
    columns_->length = length;
    columns_->states_length = true;
    columns_->states_time_unit = columns_->time.has_value();
    return true;
  }

  std::optional<Error> take_comment(std::string_view comment) {
    // Enough for any heading; limits the work on a file of comments.
    constexpr std::size_t kMostCommentBytes = TextLines::kMostBytes;
    comment_bytes_ += comment.size();
    if (comment_bytes_ > kMostCommentBytes) return std::nullopt;
    return error_of(comments_.add(comment, line_number_));
  }

  // The first row decides: x y z, t x y z, or the columns that a comment names.
  std::optional<Error> begin_without_header(std::string_view line) {
    const Separator separator = separator_of_row(line, Separator::kBlankOrComma);
    if (separator == Separator::kBlankOrComma && has_ambiguous_comma(line)) return comma_error();
    const std::size_t count = split_fields(line, separator).size();
    column_line_ = line_number_;
    if (auto error = error_of(comments_.choose_columns(count, line_number_, columns_))) {
      return error;
    }
    if (columns_) {
      columns_->separator = separator;
      column_line_ = comments_.naming_line();
      return std::nullopt;
    }
    if (count != 3 && count != 4) {
      return error_here("has " + std::to_string(count) +
                            (count == 1 ? " column; expected 3 or 4" : " columns; expected 3 or 4"),
                        line.find(',') == std::string_view::npos ? kLineHint : kCommaHint);
    }
    columns_ = columns_without_header(count == 4);
    columns_->separator = separator;
    return std::nullopt;
  }

  // ---- rows ----

  std::optional<Error> read_row(std::string_view line, bool is_whole) {
    const Separator separator = separator_of_row(line, columns_->separator);
    if (separator == Separator::kBlankOrComma && has_ambiguous_comma(line)) return comma_error();
    const std::vector<TextField> fields = split_fields(line, separator);
    if (auto error = check_row(fields.size(), line, is_whole)) return error;
    allows_decimal_comma_ = separator == Separator::kSemicolon || separator == Separator::kTab;
    Vec3 position_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t place = columns_->position[axis];
      const LengthUnit& unit = columns_->length[axis];
      const auto number = read_number(
          fields, place, [&](std::string_view text) { return parse_number(text, unit.power); });
      if (!number) return number.error();
      position_m[static_cast<Eigen::Index>(axis)] = *number * unit.factor;
    }
    if (columns_->time) {
      if (auto error = read_time_of(fields)) return error;
    }
    trajectory_.positions_m.push_back(position_m);
    return std::nullopt;
  }

  std::optional<Error> check_row(std::size_t count, std::string_view line, bool is_whole) const {
    if (columns_->is_trace && (!is_whole || count != columns_->count)) {
      const std::string found =
          is_whole ? "has " + std::to_string(count) + " columns" : "is cut off";
      return error_here(found + "; expected " + std::to_string(columns_->count) +
                            " columns as in line " + std::to_string(column_line_) +
                            ", and a newline",
                        kTraceHint);
    }
    if (count == columns_->count) return std::nullopt;
    return error_here("has " + std::to_string(count) +
                          (count == 1 ? " column; expected " : " columns; expected ") +
                          std::to_string(columns_->count) + " columns as in line " +
                          std::to_string(column_line_),
                      line.find(',') == std::string_view::npos ? kLineHint : kCommaHint);
  }

  // The text of a number with a decimal point. Notes decimal commas: one file has points or commas.
  Result<std::string> number_text(const TextField& field) {
    const std::string_view text = field.text;
    std::string with_point;
    if ((allows_decimal_comma_ || field.is_quoted) && text.find(',') != std::string_view::npos) {
      with_point = with_decimal_point(text);
    }
    if (!with_point.empty()) {
      if (decimal_comma_line_ == 0) decimal_comma_line_ = line_number_;
    } else if (decimal_point_line_ == 0 && text.find('.') != std::string_view::npos) {
      decimal_point_line_ = line_number_;
    }
    if (decimal_comma_line_ > 0 && decimal_point_line_ > 0) {
      const bool has_comma = decimal_comma_line_ >= decimal_point_line_;
      return error_here(std::string("has a decimal ") + (has_comma ? "comma" : "point") + " in " +
                            in_quotes(text) + ", and line " +
                            std::to_string(has_comma ? decimal_point_line_ : decimal_comma_line_) +
                            " has a decimal " + (has_comma ? "point" : "comma") +
                            "; expected one of them",
                        "write decimal points in the whole file");
    }
    return with_point.empty() ? std::string(text) : with_point;
  }

  template <typename Parse>
  Result<double> read_number(const std::vector<TextField>& fields, std::size_t place,
                             const Parse& parse) {
    const auto text = number_text(fields[place]);
    if (!text) return text.error();
    const Number number = parse(*text);
    if (number.kind != NumberKind::kNumber) return field_error(place, fields[place], number.kind);
    return number.value;
  }

  std::optional<Error> read_time_of(const std::vector<TextField>& fields) {
    const std::size_t place = *columns_->time;
    const auto text = number_text(fields[place]);
    if (!text) return text.error();
    const TimeText time = read_time(*text, columns_->time_unit.scale);
    switch (time.kind) {
      case TimeTextKind::kTime:
        break;
      case TimeTextKind::kNotFinite:
        return error_here("time is " + in_quotes(*text) + "; expected a finite number");
      case TimeTextKind::kOutOfRange:
        return error_here("time is " + in_quotes(*text) + "; expected less than 1e12 s",
                          kTimeUnitHint);
      case TimeTextKind::kNone:
        return field_error(place, fields[place], NumberKind::kNone);
    }
    if (!columns_->counts_samples) return take_time(time.fs, *text);
    if (!rate_Hz_) {
      return error_here("column " + std::to_string(place + 1) +
                            " counts samples, which is no time; expected a time or a rate",
                        "give the rate of the samples with --rate, or write times in seconds");
    }
    // The seconds of as many samples, from a number that was read as seconds.
    const auto samples_e15 = static_cast<long double>(time.fs);
    return take_time(static_cast<Int128>(std::round(samples_e15 / *rate_Hz_)), *text);
  }

  std::optional<Error> take_time(Int128 time_fs, const std::string& text) {
    std::vector<std::int64_t>& times_ns = trajectory_.times_ns;
    const bool is_first = times_ns.empty();
    const Int128 before_fs = std::exchange(last_fs_, time_fs);
    const std::int64_t length_ns =
        is_first || time_fs < before_fs ? 0 : nanoseconds_between(before_fs, time_fs);
    if (!is_first && length_ns <= 0) {
      return error_here("time " + in_quotes(text) + " does not increase" +
                            (time_fs < before_fs ? "" : " by a nanosecond"),
                        columns_->is_trace ? "sort the lines by the column t"
                                           : "sort the lines by their time, and delete repeated "
                                             "ones");
    }
    if (!is_first && length_ns >= std::numeric_limits<std::int64_t>::max() - times_ns.back()) {
      return error_here("time " + in_quotes(text) +
                            " is more than 292 years after the first one; expected a shorter path",
                        kTimeUnitHint);
    }
    times_ns.push_back(is_first ? 0 : times_ns.back() + length_ns);
    trajectory_.lines.push_back(line_number_);
    return std::nullopt;
  }

  // ---- errors ----

  Error comma_error() const {
    return error_here(
        "has commas between digits beside blanks, so that a comma may separate columns or "
        "decimals; "
        "expected decimal points",
        "write decimal points, or separate the columns with semicolons");
  }

  Error field_error(std::size_t place, const TextField& field, NumberKind kind) const {
    const std::string column = "column " + std::to_string(place + 1) + " ";
    if (field.text.empty()) return error_here(column + "is empty; expected a number");
    const std::string problem =
        column + "is " + in_quotes(field.text) + "; expected a number" +
        (kind == NumberKind::kOutOfRange ? " within the range of a double" : "");
    const bool has_comma = field.text.find(',') != std::string_view::npos;
    return error_here(
        problem, has_comma ? "write decimal points, without signs between thousands" : kLineHint);
  }

  std::string path_;
  std::optional<double> rate_Hz_;
  std::size_t line_number_ = 0;
  std::optional<TrajectoryColumns> columns_;
  std::size_t column_line_ = 0;  // the line that determined them
  bool has_units_line_ = false;  // the line after the header was read
  TrajectoryComments comments_;  // before the first row
  std::size_t comment_bytes_ = 0;
  bool allows_decimal_comma_ = false;   // in this line
  std::size_t decimal_comma_line_ = 0;  // 0: none
  std::size_t decimal_point_line_ = 0;
  Int128 last_fs_ = 0;  // the time of the last row
  Trajectory trajectory_;
};

}  // namespace

Result<Trajectory> read_trajectory(const std::string& path, std::optional<double> rate_Hz) {
  auto lines = TextLines::open(path, kExpectedFile);
  if (!lines) return lines.error();
  if (auto error = add_input(path)) return *error;
  TrajectoryReader reader(path, rate_Hz);
  while (lines->next()) {
    if (auto error = reader.read_line(lines->line(), lines->number(), lines->is_whole())) {
      return *error;
    }
  }
  if (lines->error()) return *lines->error();
  return reader.finish();
}

}  // namespace palpate
