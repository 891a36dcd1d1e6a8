#include "io/trajectory_columns.h"

#include <algorithm>
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

// A trace of Palpate has a column t. Other programs name columns device_x, too.
bool is_trace(const std::vector<TextField>& fields) {
  const auto has = [&](std::string_view name) {
    return std::any_of(fields.begin(), fields.end(),
                       [name](const TextField& field) { return field.text == name; });
  };
  return has("t") && std::any_of(std::begin(kTraceNames), std::end(kTraceNames), has);
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

}  // namespace

HeaderReading read_named_columns(std::string_view line) {
  const Separator separator = separator_of_header(line);
  return HeaderReader(read_column_names(line, separator), separator).read();
}

HeaderReading read_header(std::string_view line) {
  const Separator separator = separator_of_header(line);
  const std::vector<TextField> fields = split_fields(line, separator);
  if (is_trace(fields)) return read_trace_header(fields, separator);
  HeaderReading reading = read_named_columns(line);
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

}  // namespace palpate
