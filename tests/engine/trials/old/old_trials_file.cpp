#include "tests/engine/trials/old/old_trials_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "engine/trials/as_printed.h"
#include "engine/trials/csv_reader.h"
#include "engine/trials/plan.h"
#include "engine/trials/strict_json.h"
#include "geometry/base/printable.h"
#include "geometry/base/quoted.h"
#include "haptics/strategies/strategy.h"
#include "io/gltf/file.h"

namespace palpate::old {
namespace {

constexpr std::array<std::string_view, 3> kHapticNames = {"NoH", "UaH", "H"};
constexpr std::array<std::string_view, 2> kRotationNames = {"NoR", "R"};
constexpr std::array<std::string_view, 2> kAlignmentNames = {"nearest", "forward"};
constexpr std::array<std::string_view, 2> kViewNames = {"turning", "still"};
constexpr std::array<std::string_view, 7> kFollowingNames = {
    "delayed", "predict", "replan", "frozen", "adapts-0", "adapts-0.5", "adapts-1"};
constexpr std::array<std::string_view, 3> kTrialStatusNames = {"done", "timeout", "fault"};

constexpr std::array<TrialMeasure, kFirstFaultMeasure> kOwnMeasures = {{
    {"total_time_s", "s",
     "from the first contact within the green sphere to the first contact within the red sphere",
     "total time"},
    {"contact_s", "s", "part of the total time in contact", ""},
    {"losses_of_contact", "1", "transitions from contact to no contact, however short",
     "number of losses of contact"},
    {"losses_100ms", "1", "intervals without contact of 0.1 s or more", ""},
    {"losses_per_s", "1/s", "losses_of_contact divided by total_time_s", ""},
    {"losses_100ms_per_s", "1/s", "losses_100ms divided by total_time_s", ""},
    {"mean_penetration_m", "m", "mean distance from the device point to the proxy, over contact",
     ""},
    {"mean_penetration_dm", "dm", "mean_penetration_m in the paper's unit", "mean penetration"},
    {"mean_contact_angle_deg", "deg",
     "mean angle from the contact normal to the actuated axes, over contact", "mean contact angle"},
    {"share_within_30deg", "1", "share of the contact with a contact angle of at most 30 deg", ""},
    {"tracked_share", "1",
     "share of the way from green to red along which the contact moved without a loss", ""},
    {"recoveries", "1", "how often the simulated operator was lost and went back to the contour",
     ""},
    {"device_path_m", "m", "length of the path of the device point, device frame", ""},
    {"proxy_path_m", "m", "length of the path of the proxy, scene frame", ""},
    {"port_work_J", "J",
     "work of the commanded force on the hand; positive: the device gave energy", ""},
    {"work_lost_J", "J", "work of the full force on the hand minus port_work_J", ""},
    {"mean_ghost_force_N", "N",
     "mean part of the commanded force that is tangential to the surface, over contact", ""},
    {"mean_missing_force_N", "N",
     "mean of the full force minus the commanded force along the normal, over contact", ""},
}};

constexpr std::array<TrialMeasure, kMeasureCount - kPlainMeasureCount> kStrategyMeasures = {{
    {"wall_work_J", "J",
     "work that the tangential part of the commanded force did in the direction of the motion, "
     "over "
     "contact",
     ""},
    {"largest_contact_work_J", "J",
     "largest work of the commanded force on the hand in one contact; positive: the device gave "
     "energy",
     ""},
    {"empty_turns", "1", "turns of the scene in free motion that no contact followed within 0.1 s",
     ""},
    {"mean_drift_m", "m",
     "mean distance of the scene from its place at the start, device frame; empty if the scene "
     "turned",
     ""},
    {"worst_drift_m", "m", "largest such distance", ""},
    {"governor_share", "1", "share of the ticks in which the governor changed the force", ""},
}};

constexpr std::array<std::string_view, kFaultCount> kFaultMeanings = {
    "ticks whose position was not finite",
    "ticks whose time step was not valid",
    "ticks in which the solver reached its limit of steps or work",
    "ticks whose position was farther from the last one than a hand can move",
    "ticks in which the proxy stopped a moving body",
    "ticks in which a new pose of a body was ignored",
    "ticks whose computed force was not finite",
    "ticks whose position was too far from the scene",
    "ticks that were refused because of their settings",
    "ticks whose sample the device marked as invalid",
    "ticks in which new motor axes were ignored",
    "ticks in which magnets and media reached their limit of work"};

std::array<TrialMeasure, kMeasureCount> make_measures() {
  std::array<TrialMeasure, kMeasureCount> all{};
  for (std::size_t i = 0; i < kOwnMeasures.size(); ++i) all[i] = kOwnMeasures[i];
  for (std::size_t i = 0; i < kFaultCount; ++i) {
    all[kFirstFaultMeasure + i] = {kFaultNames[i], "1", kFaultMeanings[i], ""};
  }
  all[kMissedDeadlines] = {"missed_deadlines", "1",
                           "ticks that began after their deadline; 0 in simulated time", ""};
  std::copy(kStrategyMeasures.begin(), kStrategyMeasures.end(), all.begin() + kPlainMeasureCount);
  return all;
}

// A column in front of the measures.
struct LeadingColumn {
  std::string_view name;
  std::string_view meaning;
  std::string_view paper;
  bool is_required;
};

struct Leading {
  enum Index : std::size_t {
    kFollowing,
    kParticipant,
    kBlock,
    kTrial,
    kHaptic,
    kRotation,
    kObject,
    kAttempt,
    kStatus,
    kCount
  };
};

constexpr std::array<LeadingColumn, Leading::kCount> kLeadingColumns = {{
    {"following", "how a simulated operator follows the turning scene; empty for a person", "",
     false},
    {"participant", "the person, or the number of the simulated operator", "participant", true},
    {"block", "the block of trials; 0 is practice", "trial", true},
    {"trial", "the place of the trial within its block, 1 for the first", "", false},
    {"haptic", "commanded force: NoH none, UaH along the actuated axes, H all of it",
     "haptic condition", true},
    {"rotation", "R with A4, NoR without", "rotation condition", true},
    {"object", "the object whose contour is followed", "object", true},
    {"attempt", "1, or higher for a trial that was repeated", "", false},
    {"status", "done, timeout (the time limit was reached) or fault (a fault ended the trial)", "",
     true},
}};

constexpr LeadingColumn kStrategyColumn = {
    "strategy", "the technique for missing motors, in place of haptic and rotation", "", false};

// The columns at the end.
struct Trailing {
  enum Index : std::size_t { kView, kAlign, kStart, kScale, kCount };
};

constexpr std::array<LeadingColumn, Trailing::kCount> kTrailingColumns = {{
    {"view", "what the display shows of a scene that turns: turning or still", "", false},
    {"align", "the end of the motor's line that the normal turns to: nearest or forward", "",
     false},
    {"start_orientation_deg", "by which the scene is turned about A3 before the trial", "", false},
    {"scale", "factor of the object's size", "", false},
}};
constexpr std::array<std::string_view, Trailing::kCount> kTrailingUnits = {"", "", "deg", "1"};

// The measures in a file.
std::span<const TrialMeasure> measures_in(TrialColumns columns) {
  return std::span(trial_measures())
      .first(columns == TrialColumns::kFactors ? kPlainMeasureCount : kMeasureCount);
}

std::string joined_trial_columns(TrialColumns columns) {
  std::string text;
  for (const LeadingColumn& column : kLeadingColumns) text.append(column.name).append(",");
  for (const TrialMeasure& measure : measures_in(columns)) text.append(measure.name).append(",");
  if (columns == TrialColumns::kStrategies) text.append(kStrategyColumn.name).append(",");
  for (const LeadingColumn& column : kTrailingColumns) text.append(column.name).append(",");
  text.pop_back();
  return text;
}

constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

// The place of each known column in the lines of the file.
struct Columns {
  std::array<std::size_t, Leading::kCount> leading;
  std::array<std::size_t, kMeasureCount> measures;
  std::size_t strategy = kAbsent;
  std::array<std::size_t, Trailing::kCount> trailing;
  std::size_t count = 0;
};

Error trials_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

std::string place_of(std::size_t line, std::string_view column) {
  return "line " + std::to_string(line) + ", column " + std::string(column);
}

Result<std::size_t> find_column(const std::vector<std::string>& header, std::string_view name) {
  const auto first = std::find(header.begin(), header.end(), name);
  if (first == header.end()) return kAbsent;
  if (std::find(first + 1, header.end(), name) != header.end()) {
    return trials_error(place_of(1, name), "is present more than once; expected once",
                        "remove or rename one of the columns");
  }
  return static_cast<std::size_t>(first - header.begin());
}

Result<Columns> find_columns(const std::vector<std::string>& header) {
  Columns columns;
  columns.count = header.size();
  for (std::size_t i = 0; i < Leading::kCount; ++i) {
    const auto place = find_column(header, kLeadingColumns[i].name);
    if (!place) return place.error();
    if (*place == kAbsent && kLeadingColumns[i].is_required) {
      const bool has_semicolons = header.size() == 1 && header[0].find(';') != std::string::npos;
      return trials_error(place_of(1, kLeadingColumns[i].name), "is missing; expected this column",
                          has_semicolons ? "separate the columns by commas, not by semicolons"
                                         : "the first line must have the names of the columns");
    }
    columns.leading[i] = *place;
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const auto place = find_column(header, trial_measures()[i].name);
    if (!place) return place.error();
    columns.measures[i] = *place;
  }
  const auto strategy = find_column(header, kStrategyColumn.name);
  if (!strategy) return strategy.error();
  columns.strategy = *strategy;
  for (std::size_t i = 0; i < Trailing::kCount; ++i) {
    const auto place = find_column(header, kTrailingColumns[i].name);
    if (!place) return place.error();
    columns.trailing[i] = *place;
  }
  return columns;
}

// Works, whose sign is their direction; the missing force, a difference; and the share of the way,
// as the place may go back.
bool may_be_negative(std::size_t measure) {
  return measure == kPortWork || measure == kWorkLost || measure == kMissingForce ||
         measure == kTrackedShare || measure == kLargestContactWork;
}

// The fields of one line, by column.
class Line {
 public:
  Line(const std::vector<std::string>& fields, const Columns& columns, std::size_t number)
      : fields_(fields), columns_(columns), number_(number) {}

  Result<TrialRow> row() const;
  std::size_t number() const { return number_; }

 private:
  const std::string* find(std::size_t place) const {
    return place == kAbsent ? nullptr : &fields_[place];
  }
  Error refused(std::string_view column, const std::string& found, const std::string& expected,
                std::string hint = {}) const {
    return trials_error(place_of(number_, column),
                        "is " + in_quotes(found) + "; expected " + expected, std::move(hint));
  }
  template <std::size_t count>
  std::optional<Error> read_level(Leading::Index index,
                                  const std::array<std::string_view, count>& names,
                                  std::string& level, bool may_be_empty = false) const;
  std::optional<Error> read_name(Leading::Index index, std::string& name) const;
  std::optional<Error> read_condition(TrialRow& row) const;
  std::optional<Error> read_whole(Leading::Index index, int least, int& value) const;
  std::optional<Error> read_measure(std::size_t i, TrialRow& row) const;
  template <std::size_t count>
  std::optional<Error> read_setting(Trailing::Index index,
                                    const std::array<std::string_view, count>& names,
                                    std::string& level) const;
  std::optional<Error> read_setting(Trailing::Index index, const NumberRange& range,
                                    double& level) const;
  std::optional<Error> read_variant(TrialRow& row) const;

  const std::vector<std::string>& fields_;
  const Columns& columns_;
  std::size_t number_;
};

template <std::size_t count>
std::optional<Error> Line::read_level(Leading::Index index,
                                      const std::array<std::string_view, count>& names,
                                      std::string& level, bool may_be_empty) const {
  const std::string* const field = find(columns_.leading[index]);
  if (!field) return std::nullopt;
  const bool is_known = std::find(names.begin(), names.end(), *field) != names.end();
  if (!is_known && !(may_be_empty && field->empty())) {
    return refused(kLeadingColumns[index].name, *field, joined_words({names.begin(), names.end()}));
  }
  level = *field;
  return std::nullopt;
}

std::optional<Error> Line::read_name(Leading::Index index, std::string& name) const {
  name = *find(columns_.leading[index]);
  // "Ann" and "Ann " would be two persons.
  const bool has_blanks = name.starts_with(' ') || name.ends_with(' ');
  if (!name.empty() && name.size() <= kMostNameBytes && !has_blanks && printable(name) == name) {
    return std::nullopt;
  }
  return refused(kLeadingColumns[index].name, name,
                 "a name of 1 to " + std::to_string(kMostNameBytes) +
                     " bytes in UTF-8, without blanks around it and control characters");
}

std::optional<Error> Line::read_whole(Leading::Index index, int least, int& value) const {
  const std::string* const field = find(columns_.leading[index]);
  if (!field) return std::nullopt;
  constexpr int kMost = 1'000'000;
  const char* const end = field->data() + field->size();
  const auto [stop, failed] = std::from_chars(field->data(), end, value);
  if (failed == std::errc() && stop == end && value >= least && value <= kMost) return std::nullopt;
  return refused(kLeadingColumns[index].name, *field,
                 "a whole number from " + std::to_string(least) + " to " + std::to_string(kMost));
}

std::optional<Error> Line::read_measure(std::size_t i, TrialRow& row) const {
  const std::string* const field = find(columns_.measures[i]);
  if (!field || field->empty() || *field == "NA") return std::nullopt;
  const std::string_view name = trial_measures()[i].name;
  double value = 0.0;
  const char* const end = field->data() + field->size();
  const auto [stop, failed] = std::from_chars(field->data(), end, value);
  if (failed != std::errc() || stop != end) {
    return refused(name, *field, "a number, such as 0.25, or an empty field");
  }
  if (value < 0.0 && !may_be_negative(i)) {
    return refused(name, *field, "a number of at least 0, or an empty field");
  }
  if (std::isfinite(value)) {
    row.measures[i] = value;
  } else if (row.status == TrialStatus::kDone) {
    return refused(name, *field, "a finite number, because the status is done",
                   "leave the field empty if the measure is undefined");
  }
  return std::nullopt;
}

constexpr const char* kOtherMeaning = "rename the column if it has another meaning";

template <std::size_t count>
std::optional<Error> Line::read_setting(Trailing::Index index,
                                        const std::array<std::string_view, count>& names,
                                        std::string& level) const {
  const std::string* const field = find(columns_.trailing[index]);
  if (!field || field->empty() || *field == "NA") return std::nullopt;
  if (std::find(names.begin(), names.end(), *field) == names.end()) {
    return refused(kTrailingColumns[index].name, *field, joined_words({names.begin(), names.end()}),
                   kOtherMeaning);
  }
  level = *field;
  return std::nullopt;
}

std::optional<Error> Line::read_setting(Trailing::Index index, const NumberRange& range,
                                        double& level) const {
  const std::string* const field = find(columns_.trailing[index]);
  if (!field || field->empty() || *field == "NA") return std::nullopt;
  const char* const end = field->data() + field->size();
  const auto [stop, failed] = std::from_chars(field->data(), end, level);
  if (failed == std::errc() && stop == end && range.contains(level)) return std::nullopt;
  return refused(kTrailingColumns[index].name, *field, text_of(range), kOtherMeaning);
}

std::optional<Error> Line::read_variant(TrialRow& row) const {
  auto error = read_setting(Trailing::kView, kViewNames, row.view);
  if (!error) error = read_setting(Trailing::kAlign, kAlignmentNames, row.align);
  if (!error) error = read_setting(Trailing::kStart, kStartRange_deg, row.start_orientation_deg);
  if (!error) error = read_setting(Trailing::kScale, kScaleRange, row.scale);
  if (error || row.following.empty()) return error;
  const auto following = std::find(kFollowingNames.begin(), kFollowingNames.end(), row.following);
  const auto view = view_of(static_cast<Following>(following - kFollowingNames.begin()));
  const std::string_view expected = kViewNames[static_cast<std::size_t>(view)];
  if (row.view == expected) return error;
  return refused(kTrailingColumns[Trailing::kView].name, row.view,
                 std::string(expected) + ", because the following is " + row.following);
}

// A strategy, or the levels of haptic and rotation.
std::optional<Error> Line::read_condition(TrialRow& row) const {
  const std::string* const strategy = find(columns_.strategy);
  if (!strategy || strategy->empty()) {
    auto error = read_level(Leading::kHaptic, kHapticNames, row.haptic);
    if (!error) error = read_level(Leading::kRotation, kRotationNames, row.rotation);
    return error;
  }
  const auto known = parse_strategy(*strategy);
  if (!known || name_of(*known) != *strategy) {
    return refused(kStrategyColumn.name, *strategy,
                   "an empty field, or the name of a strategy, such as a4", kOtherMeaning);
  }
  for (const Leading::Index factor : {Leading::kHaptic, Leading::kRotation}) {
    if (const std::string& level = *find(columns_.leading[factor]); !level.empty()) {
      return refused(kLeadingColumns[factor].name, level,
                     "an empty field, because strategy is " + *strategy);
    }
  }
  row.strategy = *strategy;
  return std::nullopt;
}

Result<TrialRow> Line::row() const {
  TrialRow row;
  std::string status;
  std::optional<Error> error =
      read_level(Leading::kFollowing, kFollowingNames, row.following, true);
  if (!error) error = read_name(Leading::kParticipant, row.participant);
  if (!error) error = read_whole(Leading::kBlock, 0, row.block);
  if (!error) error = read_whole(Leading::kTrial, 1, row.trial);
  if (!error) error = read_condition(row);
  if (!error) error = read_name(Leading::kObject, row.object);
  if (!error) error = read_whole(Leading::kAttempt, 1, row.attempt);
  if (!error) error = read_level(Leading::kStatus, kTrialStatusNames, status);
  if (!error) error = read_variant(row);
  if (error) return *error;
  const auto place = std::find(kTrialStatusNames.begin(), kTrialStatusNames.end(), status);
  row.status = static_cast<TrialStatus>(place - kTrialStatusNames.begin());
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if ((error = read_measure(i, row))) return *error;
  }
  return row;
}

// What identifies a trial.
std::string key_of(const TrialRow& row) {
  std::string key;
  for (const std::string& part :
       {row.following, row.participant, std::to_string(row.block), row.haptic, row.rotation,
        row.strategy, row.object, std::to_string(row.attempt), row.view, row.align,
        as_printed(row.start_orientation_deg), as_printed(row.scale)}) {
    key += std::to_string(part.size()) + ":" + part;
  }
  return key;
}

Error doubled(const TrialRow& row, std::size_t line, std::size_t first_line) {
  return trials_error(
      "line " + std::to_string(line),
      "has the trial of line " + std::to_string(first_line) +
          " again: " + (row.following.empty() ? "" : row.following + ", ") + "participant " +
          row.participant + ", block " + std::to_string(row.block) + ", " +
          (row.strategy.empty() ? row.haptic + ", " + row.rotation : row.strategy) + ", " +
          row.object + ", attempt " + std::to_string(row.attempt) + ", " + row.view + ", " +
          row.align + ", " + as_printed(row.start_orientation_deg) + " deg, scale " +
          as_printed(row.scale) + "; expected each trial once",
      "remove one of the lines, or number the attempts");
}

Result<std::vector<TrialRow>> read_rows(CsvReader& reader, const Columns& columns) {
  std::vector<TrialRow> rows;
  std::map<std::string, std::size_t> line_of_trial;
  std::vector<std::string> fields;
  while (true) {
    const auto is_read = reader.next(fields);
    if (!is_read) return is_read.error();
    if (!*is_read) return rows;
    if (fields.size() == 1 && fields.front().empty()) continue;  // a blank line
    const std::string element = "line " + std::to_string(reader.line());
    if (fields.size() != columns.count) {
      return trials_error(element, "has " + std::to_string(fields.size()) + " fields; expected " +
                                       std::to_string(columns.count) + ", as in the first line");
    }
    if (rows.size() == kMostTrialRows) {
      return Error{
          ErrorCode::kLimitExceeded, "", element,
          "is beyond the limit; expected at most " + std::to_string(kMostTrialRows) + " trials",
          "divide the file"};
    }
    auto row = Line(fields, columns, reader.line()).row();
    if (!row) return row.error();
    const auto [trial, is_new] = line_of_trial.try_emplace(key_of(*row), reader.line());
    if (!is_new) return doubled(*row, reader.line(), trial->second);
    rows.push_back(std::move(*row));
  }
}

Result<std::vector<TrialRow>> parse_text(std::string_view text) {
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    return trials_error("byte " + std::to_string(zero), "is zero; expected text",
                        "save the table as comma-separated text in UTF-8");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  CsvReader reader(text);
  std::vector<std::string> header;
  const auto has_header = reader.next(header);
  if (!has_header) return has_header.error();
  if (!*has_header) return trials_error("", "is empty; expected a line with the names of columns");
  const auto columns = find_columns(header);
  if (!columns) return columns.error();
  auto rows = read_rows(reader, *columns);
  if (rows && rows->empty()) {
    return trials_error("", "has no trial; expected a line for each trial below the first line");
  }
  return rows;
}

}  // namespace

const std::array<TrialMeasure, kMeasureCount>& trial_measures() {
  static const std::array<TrialMeasure, kMeasureCount> measures = make_measures();
  return measures;
}

const std::string& trials_columns(TrialColumns columns) {
  static const std::array<std::string, 2> texts = {joined_trial_columns(TrialColumns::kFactors),
                                                   joined_trial_columns(TrialColumns::kStrategies)};
  return texts[static_cast<std::size_t>(columns)];
}

void add_row(CsvLines& lines, const TrialRow& row) {
  lines.add(row.following).add(row.participant).add(row.block).add(row.trial).add(row.haptic);
  lines.add(row.rotation).add(row.object).add(row.attempt);
  lines.add(kTrialStatusNames[static_cast<std::size_t>(row.status)]);
  const bool has_strategy = !row.strategy.empty();
  for (std::size_t i = 0; i < (has_strategy ? kMeasureCount : kPlainMeasureCount); ++i) {
    if (row.measures[i]) {
      lines.add(*row.measures[i]);
    } else {
      lines.skip(1);
    }
  }
  if (has_strategy) lines.add(row.strategy);
  lines.add(row.view).add(row.align);
  lines.add(as_printed(row.start_orientation_deg)).add(as_printed(row.scale));
  lines.end_line();
}

std::string columns_csv(TrialColumns columns) {
  CsvLines lines("name,unit,meaning,paper");
  const auto add = [&](const LeadingColumn& column) {
    lines.add(column.name).add("").add(column.meaning).add(column.paper).end_line();
  };
  for (const LeadingColumn& column : kLeadingColumns) add(column);
  for (const TrialMeasure& measure : measures_in(columns)) {
    lines.add(measure.name).add(measure.unit).add(measure.meaning).add(measure.paper).end_line();
  }
  if (columns == TrialColumns::kStrategies) add(kStrategyColumn);
  for (std::size_t i = 0; i < Trailing::kCount; ++i) {
    const LeadingColumn& column = kTrailingColumns[i];
    lines.add(column.name).add(kTrailingUnits[i]).add(column.meaning).add(column.paper).end_line();
  }
  return lines.text();
}

Result<std::vector<TrialRow>> parse_trials(std::string_view text, const std::string& path) {
  auto rows = parse_text(text);
  if (rows) return rows;
  Error error = rows.error();
  error.path = path;
  return error;
}

}  // namespace palpate::old
