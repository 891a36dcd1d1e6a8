#include "tests/engine/trials/old/old_sweep_rows.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <tuple>
#include <utility>

#include "engine/trials/csv_reader.h"
#include "geometry/base/quoted.h"

namespace palpate::old {
namespace {

constexpr std::array<std::string_view, 3> kHapticNames = {"NoH", "UaH", "H"};
constexpr std::array<std::string_view, 2> kRotationNames = {"NoR", "R"};
constexpr std::array<std::string_view, 3> kSweepBlockNames = {"base", "one_at_a_time", "hypercube"};

std::string joined_sweep_columns() {
  std::string text = "point,block,parameter";
  for (const SweepParameter& parameter : sweep_parameters()) {
    text.append(",").append(parameter.name);
  }
  text += ",participant,haptic,rotation,trials,done,timeouts,faults,limit_s";
  for (const Outcome outcome : kSweepOutcomes) {
    text.append(",").append(outcome_text(outcome).column);
  }
  return text;
}

// Adds the value of a parameter: a word, a number or an empty field.
void add_value(CsvLines& lines, std::size_t parameter, const std::optional<double>& value) {
  if (!value) {
    lines.skip(1);
  } else if (sweep_parameters()[parameter].words.empty()) {
    lines.add(*value);
  } else {
    lines.add(sweep_value_text(parameter, *value));
  }
}

// Reads the fields of one line from left to right.
class SweepLine {
 public:
  SweepLine(const std::vector<std::string>& fields, const std::vector<std::string>& columns,
            std::size_t line)
      : fields_(fields), columns_(columns), line_(line) {}

  void whole(int& value) {
    const auto number = parsed<int>("a whole number");
    if (number) value = *number;
  }
  void number(double& value) {
    const auto number = parsed<double>("a number");
    if (number) value = *number;
  }
  void number(std::optional<double>& value) {
    if (field().empty()) return next();
    value = parsed<double>("a number or an empty field");
  }
  // The index of one of these words; `none` if the field is empty.
  void word(std::span<const std::string_view> words, std::optional<std::size_t>& value) {
    const auto found = std::find(words.begin(), words.end(), field());
    if (found != words.end()) {
      value = static_cast<std::size_t>(found - words.begin());
    } else if (!field().empty()) {
      fail("a known word");
    }
    next();
  }
  const std::optional<Error>& error() const { return error_; }
  void require(bool is_there) {
    if (!is_there) fail_at(place_ - 1, "a known word");
  }

 private:
  const std::string& field() const { return fields_[place_]; }
  void next() { ++place_; }
  void fail(const std::string& expected) { fail_at(place_, expected); }
  void fail_at(std::size_t place, const std::string& expected) {
    if (error_) return;
    error_ = Error{ErrorCode::kInvalidContent, "",
                   "line " + std::to_string(line_) + ", column " + columns_[place],
                   "is " + in_quotes(fields_[place]) + "; expected " + expected, ""};
  }
  template <typename Number>
  std::optional<Number> parsed(const std::string& expected) {
    Number value{};
    const char* const end = field().data() + field().size();
    const auto [stop, failed] = std::from_chars(field().data(), end, value);
    const bool is_good = failed == std::errc() && stop == end;
    if (!is_good) fail(expected);
    next();
    return is_good ? std::optional<Number>(value) : std::nullopt;
  }

  const std::vector<std::string>& fields_;
  const std::vector<std::string>& columns_;
  std::size_t line_;
  std::size_t place_ = 0;
  std::optional<Error> error_;
};

std::array<std::string_view, kSweepParameterCount> parameter_names() {
  std::array<std::string_view, kSweepParameterCount> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = sweep_parameters()[i].name;
  return names;
}

void read_values(SweepLine& line, SweepValues& values) {
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) {
    const auto& words = sweep_parameters()[i].words;
    if (words.empty()) {
      line.number(values[i]);
      continue;
    }
    std::optional<std::size_t> word;
    line.word(words, word);
    if (word) values[i] = static_cast<double>(*word);
  }
}

Result<SweepRow> row_of(SweepLine line) {
  SweepRow row;
  line.whole(row.point);
  std::optional<std::size_t> word;
  const auto required = [&](std::span<const std::string_view> words, std::size_t& value) {
    word.reset();
    line.word(words, word);
    line.require(word.has_value());
    if (word) value = *word;
  };
  std::size_t block = 0;
  required(kSweepBlockNames, block);
  row.block = static_cast<SweepBlock>(block);
  line.word(parameter_names(), row.varied);
  read_values(line, row.values);
  line.whole(row.participant);
  required(kHapticNames, row.haptic);
  required(kRotationNames, row.rotation);
  for (int* const count : {&row.trials, &row.done, &row.timeouts, &row.faults}) line.whole(*count);
  line.number(row.limit_s);
  for (auto& mean : row.means) line.number(mean);
  if (line.error()) return *line.error();
  return row;
}

Result<std::vector<SweepRow>> parse_rows(std::string_view text) {
  CsvReader reader(text);
  std::vector<std::string> columns;
  [[maybe_unused]] const auto known = CsvReader(sweep_columns()).next(columns);
  std::vector<SweepRow> rows;
  std::vector<std::string> fields;
  while (true) {
    const auto is_read = reader.next(fields);
    if (!is_read) return is_read.error();
    if (!*is_read) return rows;
    const bool is_header = reader.line() == 1;
    if (is_header ? fields != columns : fields.size() != columns.size()) {
      return Error{ErrorCode::kInvalidContent, "", "line " + std::to_string(reader.line()),
                   "has other fields; expected the columns " + sweep_columns(), ""};
    }
    if (is_header) continue;
    auto row = row_of(SweepLine(fields, columns, reader.line()));
    if (!row) return row.error();
    rows.push_back(std::move(*row));
  }
}

}  // namespace

const std::string& sweep_columns() {
  static const std::string columns = joined_sweep_columns();
  return columns;
}

void add_sweep_row(CsvLines& lines, const SweepRow& row) {
  lines.add(row.point).add(kSweepBlockNames[static_cast<std::size_t>(row.block)]);
  lines.add(row.varied ? sweep_parameters()[*row.varied].name : std::string_view());
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) add_value(lines, i, row.values[i]);
  lines.add(row.participant).add(kHapticNames[row.haptic]).add(kRotationNames[row.rotation]);
  lines.add(row.trials).add(row.done).add(row.timeouts).add(row.faults);
  lines.add(row.limit_s);
  for (const auto& mean : row.means) {
    if (mean) {
      lines.add(*mean);
    } else {
      lines.skip(1);
    }
  }
  lines.end_line();
}

Result<std::vector<SweepRow>> parse_sweep_rows(std::string_view text, const std::string& path) {
  auto rows = parse_rows(text);
  if (rows) return rows;
  Error error = rows.error();
  error.path = path;
  return error;
}

}  // namespace palpate::old
