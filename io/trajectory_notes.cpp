#include "io/trajectory_notes.h"

#include <algorithm>
#include <sstream>

#include "geometry/base/quoted.h"

namespace palpate {
namespace {

std::string shown(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

std::string shown(const LengthUnit& unit) {
  double metres = unit.factor;
  for (int n = 0; n < unit.power; ++n) metres *= 10.0;
  for (int n = 0; n > unit.power; --n) metres /= 10.0;
  return std::string(unit.name) + " (1 " + std::string(unit.name) + " = " + shown(metres) + " m)";
}

std::string lengths_text(const TrajectoryColumns& columns) {
  const auto& length = columns.length;
  if (length[0] == length[1] && length[1] == length[2]) {
    return length[0] == kMetre ? "" : "x, y and z are in " + shown(length[0]);
  }
  return "x is in " + shown(length[0]) + ", y in " + shown(length[1]) + ", z in " +
         shown(length[2]);
}

std::string time_text(const TrajectoryFacts& facts) {
  const TrajectoryColumns& columns = facts.columns;
  if (!columns.time) return "";
  if (columns.counts_samples) {
    return "t counts samples (1 sample = " + shown(1.0 / facts.rate_Hz.value_or(1.0)) + " s)";
  }
  const TimeUnit& unit = columns.time_unit;
  if (unit.name == kSecond.name) return "";
  double seconds = static_cast<double>(unit.scale.factor);
  for (int n = unit.scale.power; n < 9; ++n) seconds /= 10.0;
  const std::string name(unit.name);
  return "t is in " + name + " (1 " + name + " = " + shown(seconds) + " s)";
}

}  // namespace

std::vector<std::string> trajectory_notes(const TrajectoryFacts& facts) {
  std::vector<std::string> notes;
  const std::string lengths = lengths_text(facts.columns);
  const std::string time = time_text(facts);
  if (!lengths.empty() || !time.empty()) {
    const std::string origin =
        facts.unit_comment == 0
            ? ""
            : ", as the comment in line " + std::to_string(facts.unit_comment) + " states";
    notes.push_back(lengths + (lengths.empty() || time.empty() ? "" : "; ") + time + origin);
  }
  // A comment that names x, y and z in their order changes nothing.
  const bool is_usual = facts.columns.is_in_order() && facts.columns.unused.empty();
  if (facts.naming_comment > 0 && !is_usual) {
    notes.push_back("the comment in line " + std::to_string(facts.naming_comment) +
                    " names the columns");
  }
  if (facts.decimal_comma_line > 0) {
    notes.push_back("commas are decimal commas, as in line " +
                    std::to_string(facts.decimal_comma_line));
  }
  if (!facts.columns.unused.empty() && !facts.columns.is_trace) {
    constexpr std::size_t kMostNames = 12;
    std::vector<std::string> names = facts.columns.unused;
    std::erase(names, "");
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
      text += (i > 0 ? ", " : "") + in_quotes(names[i]);
    }
    if (names.size() > kMostNames) {
      text += " and " + std::to_string(names.size() - kMostNames) + " more";
    }
    if (!names.empty()) notes.push_back("columns that are not used: " + text);
  }
  return notes;
}

}  // namespace palpate
