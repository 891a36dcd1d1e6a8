#include "io/trajectory_comments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "geometry/base/quoted.h"
#include "io/column_names.h"
#include "io/text_fields.h"

namespace palpate {
namespace {

using Words = std::vector<std::string_view>;

template <typename Names>
bool is_among(const Names& names, std::string_view word) {
  return std::find(std::begin(names), std::end(names), folded_unit(word)) != std::end(names);
}

// The words of a text between the given characters; each of `alone` is a word of its own.
Words words_between(std::string_view text, std::string_view between, std::string_view alone = "") {
  Words words;
  for (std::size_t i = 0; i < text.size();) {
    const auto is_in = [&](std::string_view set) { return set.find(text[i]) < set.size(); };
    const std::size_t begin = i;
    if (is_in(between)) {
      ++i;
    } else if (is_in(alone)) {
      words.push_back(text.substr(i++, 1));
    } else {
      while (i < text.size() && !is_in(between) && !is_in(alone)) ++i;
      words.push_back(text.substr(begin, i - begin));
    }
  }
  return words;
}

// Without the signs that begin a comment. "#,x,y,z": the first name is the sign itself.
std::string comment_text(std::string_view comment) {
  const std::size_t begin = comment.find_first_not_of("#!%/*- \t");
  if (begin == std::string_view::npos) return "";
  if (comment[begin] != ',') comment.remove_prefix(begin);
  return in_ascii(trimmed(comment));
}

std::string conflict(const char* what, std::size_t line) {
  return std::string("states other ") + what + " than line " + std::to_string(line) +
         "; expected the same";
}

LineProblem conflict_of(const char* what, std::size_t a, std::size_t b) {
  return {std::max(a, b), conflict(what, std::min(a, b)), "correct or delete one of the two lines"};
}

// ---- lists of columns ----

// Removes "columns:", "data format =" and the like.
bool take_label(std::string_view& text) {
  static constexpr std::string_view kLabels[] = {"column", "columns", "cols",  "field", "fields",
                                                 "format", "header",  "names", "data"};
  const std::size_t end = text.find_first_of(":=");
  if (end == std::string_view::npos) return false;
  const Words words = words_between(text.substr(0, end), " \t_");
  constexpr std::size_t kMostWords = 2;
  if (words.empty() || words.size() > kMostWords) return false;
  const auto is_label = [](std::string_view word) { return is_among(kLabels, word); };
  if (!std::all_of(words.begin(), words.end(), is_label)) return false;
  text = trimmed(text.substr(end + 1));
  return true;
}

// Removes brackets around the whole text: "(x, y, z)".
void take_brackets_around(std::string_view& text) {
  if (text.size() < 2 || !((text.front() == '(' && text.back() == ')') ||
                           (text.front() == '[' && text.back() == ']'))) {
    return;
  }
  int depth = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == text.front()) ++depth;
    if (text[i] == text.back() && --depth == 0) return;
  }
  text = trimmed(text.substr(1, text.size() - 2));
}

// Removes a remark in brackets at the end, the only brackets: "x y z (see below)".
void take_remark(std::string_view& text) {
  const std::size_t begin = text.find_first_of("([");
  if (begin == std::string_view::npos || begin == 0 ||
      text.find_first_of("([", begin + 1) < text.size())
    return;
  if (text.find_first_of(")]", begin) + 1 != text.size()) return;
  const std::string_view inside = text.substr(begin + 1, text.size() - begin - 2);
  if (!find_length_unit(inside) && !find_time_unit(inside) && !is_count_unit(inside)) {
    text = trimmed(text.substr(0, begin));
  }
}

// Whether columns that are neither positions nor times have names, and no parts of a sentence.
bool have_names(const std::vector<ColumnName>& names, bool is_labelled, Separator separator) {
  return std::all_of(names.begin(), names.end(), [&](const ColumnName& name) {
    constexpr std::size_t kMostWords = 3;
    const bool is_other = meaning_of(name).kind == ColumnKind::kOther;
    if (!is_other || is_labelled) return true;
    return separator != Separator::kBlankOrComma && name.words.size() <= kMostWords;
  });
}

bool agree(const TrajectoryColumns& a, const TrajectoryColumns& b) {
  return a.count == b.count && a.position == b.position && a.time == b.time;
}

// ---- units in a text ----

// Units that Palpate does not convert, and parts of a unit.
constexpr std::string_view kOtherUnits[] = {"px",      "pixel",   "pixels",     "voxel",
                                            "voxels",  "furlong", "furlongs",   "parsec",
                                            "parsecs", "tenths",  "hundredths", "thousandths"};

// Names of units that are words of other meanings, too.
constexpr std::string_view kOrdinaryWords[] = {"in",    "foot", "feet", "yard",
                                               "yards", "mil",  "mils", "thou"};

// The unit in a word such as "mm" and "50mm"; empty for words without one.
std::string_view unit_in(std::string_view word) {
  word.remove_prefix(word.rfind('-') + 1);  // "tip-mm"; npos + 1 is 0
  const std::size_t begin = word.find_first_not_of("0123456789.,+");
  if (begin == std::string_view::npos) return "";
  word.remove_prefix(begin);
  if (is_among(kOtherUnits, word)) return word;
  const auto length = find_length_unit(word);
  return length && *length != kMetre && !is_among(kOrdinaryWords, word) ? word : "";
}

// Whether a word before "m" makes it a part of a metre: "1e-3", "1/1000", "10^-3".
bool is_fraction(std::string_view word) {
  if (word.empty() || word[0] < '0' || word[0] > '9') return false;
  const Number number = parse_number(word);
  if (number.kind == NumberKind::kNumber) return number.value > 0.0 && number.value < 1.0;
  return word.find_first_of("/^") != std::string_view::npos;
}

}  // namespace

std::optional<LineProblem> TrajectoryComments::add(std::string_view comment, std::size_t line) {
  if (const auto rate_Hz = rate_of_comment(comment)) {
    rate_Hz_ = rate_Hz;
    rate_line_ = line;
  }
  // "x y z # units: mm"
  const std::size_t second = comment.find(" # ", 1);
  if (second != std::string_view::npos) {
    if (auto problem = add(comment.substr(0, second), line)) return problem;
    return add(comment.substr(second + 1), line);
  }
  const std::string text = comment_text(comment);
  if (text.empty()) return std::nullopt;
  bool are_units = false;
  if (auto problem = add_units(text, line, are_units)) return problem;
  if (are_units) return std::nullopt;
  add_mentions(text, line);
  return add_naming(text, line);
}

// "units: mm", "length unit = cm", "units are [mm], [s]".
std::optional<LineProblem> TrajectoryComments::add_units(std::string_view text, std::size_t line,
                                                         bool& are_units) {
  static constexpr std::string_view kUnitWords[] = {
      "unit", "units", "einheit", "einheiten", "unit\u00e9", "unit\u00e9s", "unidad", "unidades"};
  static constexpr std::string_view kLengthWords[] = {"length", "lengths", "position", "positions"};
  static constexpr std::string_view kStates[] = {":", "=", "is", "are"};
  if (text.find_first_of("\"'([{<") == 0) return std::nullopt;
  Words words = words_between(text, " \t_,;()[]{}<>|\"'`", ":=");
  auto word = words.begin();
  const auto take = [&](const auto& names) {
    return word != words.end() && is_among(names, *word) && (++word, true);
  };
  const bool is_time = take(std::array{std::string_view("time")});
  const bool is_length = !is_time && take(kLengthWords);
  if (!take(kUnitWords) || !take(kStates) || word == words.end()) return std::nullopt;
  const std::string value(
      trimmed(text.substr(static_cast<std::size_t>(word->data() - text.data()))));
  // "units are in mm"
  if (folded_unit(*word) == "in" && word + 1 != words.end() && find_length_unit(word[1])) ++word;
  Units units{line, std::nullopt, std::nullopt};
  const auto refused = [&](const std::string& why) {
    return LineProblem{line, "is a comment that states the units " + in_quotes(value) + "; " + why,
                       "write it like \"units: mm\" or \"units: mm, s\", or name the columns and "
                       "their units in a header, such as \"x [mm]\""};
  };
  for (; word != words.end(); ++word) {
    if (folded_unit(*word) == "and") continue;
    const bool is_si = folded_unit(*word) == "si";
    const auto length = is_time ? std::nullopt : is_si ? kMetre : find_length_unit(*word);
    const auto time = is_length ? std::nullopt : is_si ? kSecond : find_time_unit(*word);
    if (!length && !time) {
      return refused(in_quotes(*word) + " is no known unit; expected " +
                     (is_time ? "" : std::string(kLengthUnits)) +
                     (is_time || is_length ? "" : " for positions, and ") +
                     (is_length ? "" : std::string(kTimeUnits)) +
                     (is_time || is_length ? "" : " for times"));
    }
    if ((length && units.length && *length != *units.length) ||
        (time && units.time && time->name != units.time->name)) {
      return refused("expected one unit of length and one of time");
    }
    if (length) units.length = length;
    if (time) units.time = time;
  }
  if (!units.length && !units.time) return std::nullopt;
  are_units = true;
  units_.push_back(units);
  return std::nullopt;
}

std::optional<LineProblem> TrajectoryComments::add_naming(std::string_view text, std::size_t line) {
  const bool is_labelled = take_label(text);
  take_brackets_around(text);
  take_remark(text);
  std::string row(text);
  if (row.find(';') == std::string::npos) {  // "| x | y | z |"
    while (row.starts_with('|')) row.erase(0, 1);
    while (row.ends_with('|')) row.pop_back();
    std::replace(row.begin(), row.end(), '|', ';');
  }
  HeaderReading reading = read_named_columns(row);
  if (!reading.names_positions) return std::nullopt;
  const Separator separator = separator_of_header(row);
  const bool is_list = have_names(read_column_names(row, separator), is_labelled, separator);
  if (reading.columns) {
    namings_.push_back({line, std::move(*reading.columns), is_list});
    return std::nullopt;
  }
  if (!is_list) return std::nullopt;
  return LineProblem{line, "is a comment that names the columns and " + reading.problem,
                     std::move(reading.hint)};
}

void TrajectoryComments::add_mentions(std::string_view text, std::size_t line) {
  static constexpr std::string_view kTimes[] = {"ms", "us", "ns"};
  const Words words = words_between(text, " \t_,;:=()[]{}<>|\"'`!?*");
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string unit(unit_in(words[i]));
    const bool is_part = i > 0 && find_length_unit(words[i]) == kMetre && is_fraction(words[i - 1]);
    if (is_part) unit = std::string(words[i - 1]) + " " + std::string(words[i]);
    if (!unit.empty() && length_mention_.line == 0) length_mention_ = {line, unit};
    const auto time = find_time_unit(words[i]);
    const bool is_short = time && std::count(std::begin(kTimes), std::end(kTimes), time->name) > 0;
    if (is_short && time_mention_.line == 0) time_mention_ = {line, std::string(words[i])};
  }
}

std::optional<LineProblem> TrajectoryComments::choose_columns(
    std::size_t row_columns, std::size_t row_line, std::optional<TrajectoryColumns>& columns) {
  const auto is_list = [](const Naming& naming) { return naming.is_list; };
  const bool has_list = std::any_of(namings_.begin(), namings_.end(), is_list);
  for (Naming& naming : namings_) {
    if (has_list && !naming.is_list) continue;
    std::vector<std::string>& unused = naming.columns.unused;
    // "x, y, z,": a separator at the end.
    if (naming.columns.count == row_columns + 1 && !unused.empty() && unused.back().empty()) {
      --naming.columns.count;
      unused.pop_back();
    }
    if (columns && naming.columns.count == row_columns && !agree(naming.columns, *columns)) {
      return conflict_of("columns", naming.line, naming_line_);
    }
    if (naming.columns.count == row_columns) {
      if (!columns) {
        columns = naming.columns;
        columns->states_length = columns->states_time_unit = false;  // apply_units() states them
        naming_line_ = naming.line;
      }
      continue;
    }
    const std::string names =
        "names x, y and z among " + std::to_string(naming.columns.count) + " columns";
    if (naming.is_list) {
      return LineProblem{row_line,
                         "has " + std::to_string(row_columns) + " columns, and line " +
                             std::to_string(naming.line) + ", a comment, " + names +
                             "; expected the same number",
                         "correct or delete the comment"};
    }
    // A sentence that names the columns as they are read without it.
    const std::size_t usual_columns = naming.columns.time ? 4 : 3;
    if (naming.columns.is_in_order() && row_columns == usual_columns) continue;
    unused_naming_ = "line " + std::to_string(naming.line) + ", a comment, " + names +
                     ", and the lines have " + std::to_string(row_columns) + "; it is read as text";
  }
  if (columns) unused_naming_.clear();
  return std::nullopt;
}

std::optional<LineProblem> TrajectoryComments::apply_units(TrajectoryColumns& columns,
                                                           std::size_t column_line) {
  // The lines that state units; 0: none.
  std::size_t length_line = columns.states_length || columns.is_trace ? column_line : 0;
  std::size_t time_line = columns.states_time_unit || columns.is_trace ? column_line : 0;
  TimeUnit time_unit = columns.time_unit;
  bool counts_samples = columns.counts_samples;
  const auto contradiction = [&](const char* what, std::size_t line, std::size_t other) {
    if (!columns.is_trace) return conflict_of(what, line, other);
    return LineProblem{column_line,
                       "is the header of a trace, which is in metres and seconds; line " +
                           std::to_string(line) + ", a comment, states other units",
                       "correct or delete the comment"};
  };
  const auto state_length = [&](const std::array<LengthUnit, 3>& length, std::size_t line) {
    if (length_line > 0) return length == columns.length;
    columns.length = length;
    columns.states_length = true;
    length_line = unit_line_ = line;
    return true;
  };
  const auto state_time = [&](const TimeUnit& unit, bool counts, std::size_t line) {
    if (time_line > 0) return counts == counts_samples && unit.name == time_unit.name;
    time_unit = unit;
    counts_samples = counts;
    time_line = line;
    return true;
  };
  for (const Naming& naming : namings_) {
    const TrajectoryColumns& named = naming.columns;
    if (!naming.is_list && naming.line != naming_line_) continue;
    if (named.states_length && !state_length(named.length, naming.line)) {
      return contradiction("units of length", naming.line, length_line);
    }
    if (named.states_time_unit && !state_time(named.time_unit, named.counts_samples, naming.line)) {
      return contradiction("units of time", naming.line, time_line);
    }
  }
  for (const Units& units : units_) {
    if (units.length && !state_length({*units.length, *units.length, *units.length}, units.line)) {
      return contradiction("units of length", units.line, length_line);
    }
    if (units.time && !state_time(*units.time, false, units.line)) {
      return contradiction("units of time", units.line, time_line);
    }
  }
  if (columns.time && time_line > 0 && !columns.is_trace && !columns.states_time_unit) {
    columns.time_unit = time_unit;
    columns.counts_samples = counts_samples;
    columns.states_time_unit = true;
    if (unit_line_ == 0) unit_line_ = time_line;
  }
  return std::nullopt;
}

std::vector<std::string> TrajectoryComments::warnings(const TrajectoryColumns& columns) const {
  std::vector<std::string> warnings;
  if (!unused_naming_.empty()) warnings.push_back(unused_naming_);
  if (columns.is_trace) return warnings;
  const auto warn = [&](const Mention& mention, const char* read, const char* form) {
    warnings.push_back("line " + std::to_string(mention.line) + ", a comment, names " +
                       mention.unit + "; " + read + " (a comment of the form \"# units: " + form +
                       "\" states the unit)");
  };
  if (!columns.states_length && length_mention_.line > 0) {
    warn(length_mention_, "x, y and z are read as metres", "mm");
  }
  if (columns.time && !columns.states_time_unit && time_mention_.line > 0) {
    warn(time_mention_, "t is read as seconds", "ms");
  }
  return warnings;
}

std::optional<double> rate_of_comment(std::string_view comment) {
  static constexpr std::string_view kRateWords[] = {
      "rate", "sampled", "sampling", "samplerate", "frequency", "fs", "abtastrate"};
  static constexpr std::string_view kPeriodWords[] = {"dt", "period", "interval", "step",
                                                      "timestep"};
  const Words words = words_between(comment, "# \t,;()[]{}<>|\"'_", ":=");
  bool has_rate_word = false;
  bool has_hertz = false;  // also before the number: "rate (Hz): 500"
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto word_at = [&](std::size_t n) { return n < words.size() ? words[n] : ""; };
    has_rate_word |= is_among(kRateWords, words[i]);
    has_hertz |= folded_unit(words[i]) == "hz";
    std::string text = folded_unit(words[i]);
    std::string unit = folded_unit(word_at(i + 1));
    const std::size_t end = text.find_last_of("0123456789.") + 1;  // "2ms"
    if (end > 0 && end < text.size()) {
      unit = text.substr(end);
      text.resize(end);
    }
    const Number number = parse_number(text);
    if (number.kind != NumberKind::kNumber || !std::isfinite(number.value)) continue;
    if (number.value <= 0.0) continue;
    const bool is_stated = i > 1 && (words[i - 1] == ":" || words[i - 1] == "=");  // "rate: 500"
    const bool is_hertz = unit == "hz" || unit == "khz";
    const bool is_alone = i == 0 && words.size() <= 2 && is_hertz;  // "500 Hz"
    if (is_alone || (has_rate_word && (is_hertz || has_hertz || is_stated))) {
      return unit == "khz" ? 1000.0 * number.value : number.value;
    }
    if (!is_stated || !is_among(kPeriodWords, words[i - 2])) continue;
    const TimeUnit time = find_time_unit(unit).value_or(kSecond);
    double seconds = number.value * static_cast<double>(time.scale.factor);
    for (int n = time.scale.power; n < 9; ++n) seconds /= 10.0;
    return 1.0 / seconds;
  }
  return std::nullopt;
}

}  // namespace palpate
