#include "io/trajectory_columns.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "geometry/base/quoted.h"
#include "io/column_names.h"

namespace palpate {
namespace {

constexpr std::string_view kAxes = "xyz";
constexpr std::string_view kTraceNames[] = {"device_x", "device_y", "device_z"};
constexpr const char* kColumnsHint =
    "name the columns t, x, y and z, with units such as \"x [mm]\"; columns of other names may "
    "stand "
    "among them";

HeaderReading refused(std::string problem, std::string hint = kColumnsHint) {
  return {std::nullopt, std::move(problem), std::move(hint), false};
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + in_quotes(names[i]);
  }
  return text;
}

// The trace of a run: exact names, without units.
HeaderReading read_trace_header(const std::vector<TextField>& fields, Separator separator) {
  TrajectoryColumns columns;
  columns.is_trace = true;
  columns.separator = separator;
  columns.count = fields.size();
  const auto place_of = [&](std::string_view name) -> std::optional<std::size_t> {
    const auto is_named = [name](const TextField& field) { return field.text == name; };
    const auto found = std::find_if(fields.begin(), fields.end(), is_named);
    if (found == fields.end() || std::count_if(found, fields.end(), is_named) > 1) {
      return std::nullopt;
    }
    return static_cast<std::size_t>(found - fields.begin());
  };
  for (std::size_t axis = 0; axis < columns.position.size(); ++axis) {
    const auto place = place_of(kTraceNames[axis]);
    if (!place) {
      return refused(
          "is the header of a trace; expected each of device_x, device_y and device_z once",
          "use a trace in the format of run or replay");
    }
    columns.position[axis] = *place;
  }
  columns.time = place_of("t");
  return {columns, "", "", true};
}

class HeaderReader {
 public:
  HeaderReader(std::vector<ColumnName> names, Separator separator) : names_(std::move(names)) {
    columns_.separator = separator;
    columns_.count = names_.size();
  }

  HeaderReading read() {
    for (const ColumnName& name : names_) meanings_.push_back(meaning_of(name));
    if (!find_positions()) return std::move(refusal_);
    if (!find_lengths() || !find_time()) {
      refusal_.names_positions = true;
      return std::move(refusal_);
    }
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const bool is_used = std::count(columns_.position.begin(), columns_.position.end(), i) > 0 ||
                           columns_.time == i;
      if (!is_used) columns_.unused.push_back(names_[i].text);
    }
    return {std::move(columns_), "", "", true};
  }

 private:
  bool refuse(std::string problem, std::string hint = kColumnsHint) {
    refusal_ = refused(std::move(problem), std::move(hint));
    return false;
  }

  std::string column_text(std::size_t i) const {
    return "column " + std::to_string(i + 1) + ", " + in_quotes(names_[i].text) + ",";
  }

  // Chooses the columns of one family that has x, y and z.
  bool find_positions() {
    std::map<std::string, std::array<std::vector<std::size_t>, 3>> families;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (meanings_[i].kind != ColumnKind::kPosition) continue;
      families[meanings_[i].family][static_cast<std::size_t>(meanings_[i].axis)].push_back(i);
    }
    std::vector<std::string> complete;
    for (auto& [family, axes] : families) {
      for (std::vector<std::size_t>& places : axes) prefer_lengths(places);
      const bool is_complete =
          std::all_of(axes.begin(), axes.end(), [](const auto& places) { return !places.empty(); });
      if (is_complete) complete.push_back(family);
    }
    if (complete.empty()) return refuse_missing_axis(families[""]);
    if (complete.size() > 1 && complete.front() != "") {
      return refuse("has several positions: " +
                        list_of({names_[families[complete[0]][0][0]].text,
                                 names_[families[complete[1]][0][0]].text}) +
                        "; expected one x, one y and one z",
                    "delete or rename the other columns");
    }
    const auto& axes = families[complete.front()];
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      if (axes[axis].size() > 1) {
        return refuse("has two columns " + std::string(1, kAxes[axis]) + ": " +
                          list_of({names_[axes[axis][0]].text, names_[axes[axis][1]].text}) +
                          "; expected one",
                      "delete or rename the other column");
      }
      columns_.position[axis] = axes[axis][0];
    }
    return true;
  }

  // Of several columns of one name, those in units of length are positions: "x [mm], x [mm/s]".
  void prefer_lengths(std::vector<std::size_t>& places) const {
    const auto is_length = [this](std::size_t i) {
      return find_length_unit(names_[i].unit).has_value();
    };
    if (places.size() < 2 || std::none_of(places.begin(), places.end(), is_length)) return;
    std::erase_if(places, [&](std::size_t i) { return !is_length(i); });
  }

  bool refuse_missing_axis(const std::array<std::vector<std::size_t>, 3>& axes) {
    std::vector<std::string> missing;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      if (axes[axis].empty()) missing.emplace_back(1, kAxes[axis]);
    }
    std::string problem = "names no column ";
    for (std::size_t i = 0; i < missing.size(); ++i) problem += (i > 0 ? ", " : "") + missing[i];
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (meanings_[i].kind == ColumnKind::kOther && begins_with_axis(names_[i])) {
        problem +=
            " (" + column_text(i) + " ends with no known unit: " + std::string(kLengthUnits) + ")";
        break;
      }
    }
    return refuse(problem + "; expected the columns x, y and z, or t, x, y and z");
  }

  bool find_lengths() {
    std::size_t stated = 0;
    for (std::size_t axis = 0; axis < columns_.position.size(); ++axis) {
      const std::size_t i = columns_.position[axis];
      const ColumnName& name = names_[i];
      if (name.unit.empty() && !name.has_unit_in_brackets) continue;
      const auto unit = find_length_unit(name.unit);
      if (!unit) {
        return refuse("has the unit " + in_quotes(name.unit) + " in " + column_text(i) +
                          " which is no known unit of length; expected " +
                          std::string(kLengthUnits),
                      "convert the positions to metres, or correct the unit");
      }
      columns_.length[axis] = *unit;
      ++stated;
    }
    columns_.states_length = stated == columns_.position.size();
    if (stated == 0 || columns_.states_length) return true;
    return refuse("states units for " + std::to_string(stated) +
                      " of the columns x, y and z; expected units for all of them or for none",
                  "write the unit of each column, such as \"x [mm]\"");
  }

  bool find_time() {
    std::vector<std::size_t> times;
    std::vector<std::size_t> plain;  // "t", "time [s]"
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (meanings_[i].kind != ColumnKind::kTime) continue;
      const std::vector<std::string>& words = names_[i].words;
      times.push_back(i);
      if (words.size() == 1 && (words[0] == "t" || words[0] == "time")) plain.push_back(i);
    }
    if (times.size() > 1 && !plain.empty()) times = plain;
    if (times.size() > 1) drop_counts(times);
    if (times.size() > 1) {
      return refuse(
          "has several times: " + list_of({names_[times[0]].text, names_[times[1]].text}) +
              "; expected one column of time",
          "delete or rename the other columns");
    }
    if (times.empty()) return true;
    columns_.time = times.front();
    return find_time_unit_of(names_[times.front()]);
  }

  // A time in seconds is better than a count of samples.
  void drop_counts(std::vector<std::size_t>& times) const {
    const auto is_count = [this](std::size_t i) { return is_count_unit(names_[i].unit); };
    if (std::all_of(times.begin(), times.end(), is_count)) return;
    std::erase_if(times, is_count);
  }

  bool find_time_unit_of(const ColumnName& name) {
    columns_.states_time_unit = true;
    if (is_count_unit(name.unit)) {
      columns_.counts_samples = true;
      return true;
    }
    if (!name.unit.empty() || name.has_unit_in_brackets) {
      const auto unit = find_time_unit(name.unit);
      if (unit) return columns_.time_unit = *unit, true;
      return refuse("has the unit " + in_quotes(name.unit) + " in " + column_text(*columns_.time) +
                        " which is no known unit of time; expected " + std::string(kTimeUnits),
                    "convert the times to seconds, or correct the unit");
    }
    // "seconds" and "ms" are a name and a unit.
    for (const std::string& word : name.words) {
      const auto unit = find_time_unit(word);
      if (unit) return columns_.time_unit = *unit, true;
    }
    columns_.states_time_unit = false;
    return true;
  }

  std::vector<ColumnName> names_;
  std::vector<ColumnMeaning> meanings_;
  TrajectoryColumns columns_;
  HeaderReading refusal_;
};

std::vector<std::string_view> comment_words(std::string_view comment) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBetween = " \t:=,;()[]{}<>|";
  while (true) {
    const std::size_t begin = comment.find_first_not_of(kBetween);
    if (begin == std::string_view::npos) return words;
    const std::size_t end = std::min(comment.find_first_of(kBetween, begin), comment.size());
    words.push_back(comment.substr(begin, end - begin));
    comment.remove_prefix(end);
  }
}

// "units: mm", "unit = s, mm", "Einheiten: [ms] [mm] [mm] [mm]".
CommentReading read_stated_units(const std::vector<std::string_view>& words) {
  static constexpr std::string_view kUnitWords[] = {
      "unit", "units", "einheit", "einheiten", "unit\u00e9", "unit\u00e9s", "unidad", "unidades"};
  CommentReading reading;
  const auto speaks = std::find_if(words.begin(), words.end(), [](std::string_view word) {
    return std::count(std::begin(kUnitWords), std::end(kUnitWords), folded_unit(word)) > 0;
  });
  // "ms, mm, mm, mm": a line of units below the names.
  const bool are_units =
      words.size() >= 3 && std::all_of(words.begin(), words.end(), [](std::string_view word) {
        return find_length_unit(word) || find_time_unit(word);
      });
  if (speaks == words.end() && !are_units) return reading;
  std::size_t unknown = 0;
  for (auto word = are_units ? words.begin() : speaks + 1; word != words.end(); ++word) {
    const auto length = find_length_unit(*word);
    const auto time = find_time_unit(*word);
    if (length && folded_unit(*word) == "in" && word + 1 != words.end()) continue;  // "in mm"
    if (length && reading.length && *reading.length != *length) {
      reading.problem =
          "states several units of length; expected a header with one for each column";
      return reading;
    }
    if (length) reading.length = length;
    if (time) reading.time = time;
    unknown += !length && !time;
  }
  const bool has_known = reading.length || reading.time;
  if (!are_units && !has_known && unknown == 1 && words.end() - speaks == 2) {
    reading.problem = "states the unit " + in_quotes(words.back()) +
                      ", which is no known unit of length; expected " + std::string(kLengthUnits);
  }
  return reading;
}

// Units of positions on a screen, of angles and of encoders.
bool is_foreign_unit(std::string_view word) {
  static constexpr std::string_view kForeign[] = {
      "px",      "pixel", "pixels", "vx",     "voxel",   "voxels", "deg",  "rad",
      "degrees", "count", "counts", "parsec", "parsecs", "au",     "steps"};
  return std::count(std::begin(kForeign), std::end(kForeign), folded_unit(word)) > 0;
}

// A word between a quantity and its unit.
bool links(std::string_view word) {
  static constexpr std::string_view kLinks[] = {"in", "are", "is", "as", "=", "sind"};
  return std::count(std::begin(kLinks), std::end(kLinks), folded_unit(word)) > 0;
}

// "all positions in mm", "xyz [mm]", "mm".
CommentReading read_unit_of_positions(std::string_view comment,
                                      const std::vector<std::string_view>& words) {
  static constexpr std::string_view kSubjects[] = {
      "position", "positions",   "xyz",        "x/y/z",      "x",       "y",
      "z",        "coordinates", "values",     "data",       "lengths", "distances",
      "columns",  "everything",  "positionen", "koordinaten"};
  CommentReading reading;
  if (words.size() == 1) {
    reading.length = find_length_unit(words[0]);
    return reading;
  }
  static constexpr std::string_view kTimeSubjects[] = {"t",         "time",       "times",
                                                       "timestamp", "timestamps", "zeit"};
  const auto is_one_of = [](const auto& subjects, const std::string& word) {
    return std::count(std::begin(subjects), std::end(subjects), word) > 0;
  };
  bool has_subject = false;
  bool has_time_subject = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const char before =
        i == 0 ? ' ' : comment[static_cast<std::size_t>(words[i].data() - comment.data()) - 1];
    const bool is_named = before == '[' || before == '(' || (i > 0 && links(words[i - 1]));
    if (has_time_subject && is_named && !reading.time) reading.time = find_time_unit(words[i]);
    if (has_subject && is_named && !reading.length) {
      reading.length = find_length_unit(words[i]);
      const bool is_foreign = before == '[' || is_foreign_unit(words[i]);
      if (is_foreign && !reading.length && !find_time_unit(words[i])) {
        reading.problem = "states the unit " + in_quotes(words[i]) +
                          ", which is no known unit of length; expected " +
                          std::string(kLengthUnits);
        return reading;
      }
    }
    const std::string word = folded_unit(words[i]);
    has_subject |= is_one_of(kSubjects, word);
    has_time_subject |= is_one_of(kTimeSubjects, word);
  }
  return reading;
}

}  // namespace

HeaderReading read_header(std::string_view line) {
  const Separator separator = separator_of_header(line);
  const std::vector<TextField> fields = split_fields(line, separator);
  for (const std::string_view name : kTraceNames) {
    const bool is_trace = std::any_of(fields.begin(), fields.end(),
                                      [&](const TextField& field) { return field.text == name; });
    if (is_trace) return read_trace_header(fields, separator);
  }
  HeaderReading reading = HeaderReader(read_column_names(line, separator), separator).read();
  if (!reading.columns)
    reading.problem = "is the header " + in_quotes(line) + ", which " + reading.problem;
  return reading;
}

TrajectoryColumns columns_without_header(bool has_time) {
  TrajectoryColumns columns;
  const std::size_t first = has_time ? 1 : 0;
  columns.count = first + 3;
  columns.position = {first, first + 1, first + 2};
  if (has_time) columns.time = 0;
  return columns;
}

std::optional<double> rate_of_comment(std::string_view comment) {
  static constexpr std::string_view kRateWords[] = {
      "rate", "sampled", "sampling", "samplerate", "sample_rate", "frequency", "fs", "abtastrate"};
  const std::vector<std::string_view> words = comment_words(comment);
  bool has_rate_word = false;
  bool has_hertz = false;  // also before the number: "rate (Hz): 500"
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string word = folded_unit(words[i]);
    while (word.starts_with('#')) word.erase(0, 1);
    has_rate_word |= std::count(std::begin(kRateWords), std::end(kRateWords), word) > 0;
    has_hertz |= word == "hz";
    std::string_view number = word;
    double factor = i + 1 < words.size() && folded_unit(words[i + 1]) == "khz" ? 1000.0 : 1.0;
    const bool is_joined = number.size() > 2 && number.ends_with("hz");
    if (is_joined) number.remove_suffix(2);
    if (is_joined && number.ends_with('k')) number.remove_suffix(1), factor = 1000.0;
    const bool is_hertz = is_joined || factor == 1000.0 || has_hertz || word == "fs" ||
                          (i + 1 < words.size() && folded_unit(words[i + 1]) == "hz") ||
                          (i > 0 && folded_unit(words[i - 1]) == "fs");
    const Number value = parse_number(number);
    if (!has_rate_word || !is_hertz || value.kind != NumberKind::kNumber) continue;
    if (std::isfinite(value.value) && value.value > 0.0) return factor * value.value;
  }
  return std::nullopt;
}

CommentReading read_comment(std::string_view comment) {
  const std::size_t begin = comment.find_first_not_of("#!%*- \t");
  // "#,x,y,z": the first name is the sign itself.
  const bool is_name = begin != std::string_view::npos && comment[begin] == ',';
  if (begin == std::string_view::npos) return {};
  if (!is_name) comment.remove_prefix(begin);
  const std::string ascii = in_ascii(trimmed(comment));
  const std::vector<std::string_view> words = comment_words(ascii);
  CommentReading reading = read_stated_units(words);
  if (reading.length || reading.time || !reading.problem.empty()) return reading;
  const Separator separator = separator_of_header(ascii);
  HeaderReading header = HeaderReader(read_column_names(ascii, separator), separator).read();
  if (!header.columns || !header.columns->states_length) {
    reading = read_unit_of_positions(ascii, words);
  }
  reading.columns = std::move(header.columns);
  return reading;
}

}  // namespace palpate
