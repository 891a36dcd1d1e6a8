#include "io/column_names.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "io/ascii.h"
#include "io/measuring_units.h"

namespace palpate {
namespace {

// Words beside x, y or z in the name of a column of positions.
constexpr std::string_view kPositionWords[] = {
    "pos",      "position",    "positions",  "p",        "pt",        "point",       "device",
    "dev",      "tip",         "tool",       "tcp",      "stylus",    "pen",         "probe",
    "handle",   "hand",        "finger",     "haptic",   "hip",       "ee",          "end",
    "effector", "endeffector", "coordinate", "coord",    "coords",    "coordinates", "loc",
    "location", "pose",        "field",      "cursor",   "sensed",    "actual",      "act",
    "measured", "meas",        "current",    "cur",      "cartesian", "cart",        "translation",
    "trans",    "axis",        "achse",      "marker",   "robot",     "data",        "value",
    "ist",      "lage",        "raw",        "filtered", "smoothed",  "smooth",      "left",
    "right",    "world",       "base",       "global",   "local",     "abs",         "absolute",
    "rel",      "relative",    "xyz"};

// Words of one piece that name an axis.
struct AxisWord {
  std::string_view word;
  int axis;
  std::string_view family;
};
constexpr AxisWord kAxisWords[] = {{"x", 0, ""},       {"y", 1, ""},       {"z", 2, ""},
                                   {"px", 0, "p"},     {"py", 1, "p"},     {"pz", 2, "p"},
                                   {"posx", 0, "pos"}, {"posy", 1, "pos"}, {"posz", 2, "pos"},
                                   {"xpos", 0, "pos"}, {"ypos", 1, "pos"}, {"zpos", 2, "pos"}};

constexpr std::string_view kTimeWords[] = {"t",
                                           "time",
                                           "times",
                                           "timestamp",
                                           "timestamps",
                                           "stamp",
                                           "zeit",
                                           "zeitstempel",
                                           "temps",
                                           "tiempo",
                                           "tempo",
                                           "tijd",
                                           "tid",
                                           "aika",
                                           "czas",
                                           "elapsed",
                                           "clock",
                                           "epoch",
                                           "uhrzeit",
                                           "sekunden",
                                           "seconds",
                                           "second",
                                           "secs",
                                           "sec",
                                           "milliseconds",
                                           "millis",
                                           "msec",
                                           "msecs",
                                           "microseconds",
                                           "micros",
                                           "usec",
                                           "usecs",
                                           "nanoseconds",
                                           "nanos",
                                           "nsec",
                                           "nsecs",
                                           "ms",
                                           "us",
                                           "ns",
                                           "\u0432\u0440\u0435\u043c\u044f",
                                           "\u65f6\u95f4",
                                           "\u6642\u9593"};

// Words beside a time word.
constexpr std::string_view kTimeModifiers[] = {
    "since",    "start",    "begin",      "from",      "of",        "the",      "rel",
    "relative", "sys",      "system",     "ros",       "header",    "local",    "host",
    "abs",      "absolute", "sample",     "sampling",  "monotonic", "wall",     "unix",
    "real",     "sim",      "simulation", "recording", "device",    "measured", "in"};

// Words that count samples; a time only with a unit such as "[samples]".
constexpr std::string_view kCountWords[] = {
    "n",      "i",       "k",     "no",    "nr",     "num",  "number", "idx",   "id",
    "sample", "samples", "index", "frame", "frames", "tick", "ticks",  "count", "step"};

template <typename Words>
bool contains(const Words& words, std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

// Words end at blanks and at the signs between the parts of a name, and before the capital of
// "posX".
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool is_sign = std::string_view(" \t_-.:/,'\"").find(c) != std::string_view::npos;
    if (is_sign || (i > 0 && is_upper(c) && is_lower(text[i - 1]))) words.emplace_back();
    if (!is_sign) words.back() += lower(c);
  }
  std::erase(words, "");
  return words;
}

bool is_axis(std::string_view word) {
  return word == "x" || word == "y" || word == "z";
}

bool is_unit(std::string_view word) {
  return find_length_unit(word) || find_time_unit(word) || is_count_unit(word);
}

// "xmm" and "tms": a name and a unit in one word.
void split_joined_unit(ColumnName& name) {
  if (name.words.empty() || name.words.back().size() < 3) return;
  std::string& word = name.words.back();
  const std::string unit = word.substr(1);
  const bool has_length = is_axis(word.substr(0, 1)) && find_length_unit(unit);
  const bool has_time =
      name.words.size() == 1 && word[0] == 't' && unit.ends_with('s') && unit.size() == 2;
  if (!has_length && !(has_time && find_time_unit(unit))) return;
  name.unit = unit;
  word.resize(1);
}

// Moves a last word that is a unit out of the words.
void take_last_word(ColumnName& name) {
  split_joined_unit(name);
  if (!name.unit.empty() || name.words.size() < 2 || !is_unit(name.words.back())) return;
  name.unit = name.words.back();
  name.words.pop_back();
  if (name.words.size() > 1 && name.words.back() == "in") name.words.pop_back();
}

// Moves the text of brackets out of a name. "position (x)" has an axis in brackets, and no unit.
std::string take_brackets(std::string text, ColumnName& name) {
  constexpr std::string_view kOpening = "[({<";
  constexpr std::string_view kClosing = "])}>";
  std::string outside;
  std::string inside;
  int depth = 0;
  for (const char c : text) {
    if (kOpening.find(c) != std::string_view::npos) {
      if (depth == 0) inside.clear();
      ++depth;
    } else if (kClosing.find(c) != std::string_view::npos && depth > 0) {
      --depth;
      const std::string folded = folded_unit(inside);
      if (depth > 0) continue;
      outside += ' ';
      if (is_axis(folded) || is_unit(name.unit)) {
        outside += inside + " ";  // "position (x)", "x [mm] (raw)"
      } else {
        name.unit += (name.unit.empty() ? "" : " ") + std::string(trimmed(inside));
        name.has_unit_in_brackets = true;
      }
    } else {
      (depth > 0 ? inside : outside) += c;
    }
  }
  if (depth > 0) outside += " " + inside;
  return outside;
}

// Takes "mm" of "x / mm". The last part of a path, as in "pose/position/x", is no unit.
void take_quotient(std::string& text, ColumnName& name) {
  const std::size_t slash = text.rfind('/');
  if (slash == std::string::npos || !name.unit.empty()) return;
  // "mm/s" is one unit.
  const std::size_t first = text.find('/');
  const bool is_speed = first != slash && first > 0;
  const std::string unit(trimmed(std::string_view(text).substr((is_speed ? first : slash) + 1)));
  const std::string_view before =
      trimmed(std::string_view(text).substr(0, is_speed ? first : slash));
  const std::vector<std::string> words = words_of(unit);
  if (before.empty() || words.empty() || is_axis(words.back()) || contains(kTimeWords, unit))
    return;
  if (!is_unit(unit) && before.find('/') != std::string_view::npos) return;
  name.unit = unit;
  text = std::string(before);
}

// Blanks separate the names: joins a unit to its name.
std::vector<std::string> joined_names(const std::vector<TextField>& fields) {
  std::vector<std::string> names;
  const auto has_open_bracket = [&] {
    const std::string& last = names.back();
    return std::count(last.begin(), last.end(), '[') > std::count(last.begin(), last.end(), ']') ||
           std::count(last.begin(), last.end(), '(') > std::count(last.begin(), last.end(), ')');
  };
  constexpr std::size_t kLongestName = 128;  // with its unit; limits the work on a hostile line
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string field(fields[i].text);
    if (names.empty() || field.empty() || names.back().size() + field.size() > kLongestName) {
      names.push_back(field);
      continue;
    }
    const ColumnName last = read_column_name(names.back());
    const bool may_have_unit =
        last.unit.empty() && meaning_of(last).kind != ColumnKind::kOther && !fields[i].is_quoted;
    const bool is_bracket = std::string_view("[({<").find(field[0]) != std::string_view::npos;
    const bool before_unit = i + 1 < fields.size() && is_unit(fields[i + 1].text);
    const bool is_link = field[0] == '/' || names.back().ends_with('/') ||
                         names.back().ends_with(" in") || (field == "in" && before_unit);
    if (has_open_bracket() || is_bracket || is_link || (may_have_unit && is_unit(field))) {
      names.back() += " " + field;
    } else {
      names.push_back(field);
    }
  }
  return names;
}

}  // namespace

std::string in_ascii(std::string_view text) {
  struct Sign {
    std::string_view from, to;
  };
  static constexpr Sign kSigns[] = {
      {"\u00a0", " "},  {"\u2009", " "},  {"\u202f", " "},  {"\u3000", " "},  {"\u00b5", "u"},
      {"\u03bc", "u"},  {"\u3010", "["},  {"\u3011", "]"},  {"\u3014", "["},  {"\u3015", "]"},
      {"\u27e8", "<"},  {"\u27e9", ">"},  {"\u3008", "<"},  {"\u3009", ">"},  {"\u2044", "/"},
      {"\u2215", "/"},  {"\u339c", "mm"}, {"\u339d", "cm"}, {"\u339b", "um"}, {"\u33a1", "m^2"},
      {"\u33b3", "ms"}, {"\u33b2", "us"}, {"\u33b1", "ns"}, {"\u2033", "in"}, {"\ufeff", ""}};
  std::string ascii;
  while (!text.empty()) {
    // U+FF01 to U+FF5E: the ASCII characters from ! on, of full width.
    if (text.size() >= 3 && text[0] == '\xef' && (text[1] == '\xbc' || text[1] == '\xbd')) {
      const int point = (text[1] == '\xbc' ? 0 : 64) + (static_cast<unsigned char>(text[2]) & 63);
      if (point >= 1 && point <= 0x5e) {
        ascii += static_cast<char>(0x20 + point);
        text.remove_prefix(3);
        continue;
      }
    }
    const auto* sign = std::find_if(std::begin(kSigns), std::end(kSigns),
                                    [&](const Sign& s) { return text.starts_with(s.from); });
    if (sign != std::end(kSigns)) {
      ascii += sign->to;
      text.remove_prefix(sign->from.size());
      continue;
    }
    ascii += text.front();
    text.remove_prefix(1);
  }
  return ascii;
}

ColumnName read_column_name(std::string_view text) {
  ColumnName name;
  name.text = std::string(trimmed(text));
  std::string rest = take_brackets(in_ascii(name.text), name);
  take_quotient(rest, name);
  name.words = words_of(rest);
  if (name.unit.empty()) take_last_word(name);
  return name;
}

std::vector<ColumnName> read_column_names(std::string_view line, Separator separator) {
  std::vector<ColumnName> names;
  const std::vector<TextField> fields = split_fields(line, separator);
  if (separator == Separator::kBlankOrComma) {
    for (const std::string& name : joined_names(fields)) names.push_back(read_column_name(name));
  } else {
    for (const TextField& field : fields) names.push_back(read_column_name(field.text));
  }
  return names;
}

ColumnMeaning meaning_of(const ColumnName& name) {
  ColumnMeaning meaning;
  int axes = 0;
  for (const std::string& word : name.words) {
    const auto* axis = std::find_if(std::begin(kAxisWords), std::end(kAxisWords),
                                    [&](const AxisWord& a) { return a.word == word; });
    if (axis != std::end(kAxisWords)) {
      ++axes;
      meaning.axis = axis->axis;
      meaning.family += axis->family;
    } else if (contains(kPositionWords, word)) {
      meaning.family += (meaning.family.empty() ? "" : " ") + word;
    } else {
      axes = 2;  // the word of another quantity
    }
  }
  if (axes == 1) {
    meaning.kind = ColumnKind::kPosition;
    return meaning;
  }
  std::size_t times = 0;
  bool is_time = !name.words.empty();
  bool is_count = !name.words.empty() && is_count_unit(name.unit);
  for (const std::string& word : name.words) {
    const bool is_time_word = contains(kTimeWords, word);
    times += is_time_word;
    is_time = is_time && (is_time_word || contains(kTimeModifiers, word));
    is_count = is_count && contains(kCountWords, word);
  }
  ColumnMeaning other;
  if ((is_time && times > 0) || is_count) other.kind = ColumnKind::kTime;
  return other;
}

bool begins_with_axis(const ColumnName& name) {
  return !name.words.empty() && is_axis(name.words.front());
}

}  // namespace palpate
