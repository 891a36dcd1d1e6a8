#include "engine/trials/trials_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "engine/trials/as_printed.h"
#include "engine/trials/csv_cells.h"
#include "engine/trials/plan.h"
#include "engine/trials/strict_json.h"
#include "haptics/strategies/strategy.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

using Row = TrialRow;
using Columns = std::vector<Column<Row>>;
using Field = CsvCells<Row>;
using enum Presence;

// The order of reading. What distinguishes trials is read first, the strategy before what it stands
// for. Which measures a row needs follows from its status.
enum Turn : int { kFirst = -2, kStrategyTurn = -1, kOther = 0, kMeasures = 1 };

constexpr WholeRange kFromZero{0, 1'000'000};
constexpr WholeRange kFromOne{1, 1'000'000};
constexpr FieldRule kEmptyForPeople{{}, Blank::kEmpty, {}};
constexpr const char* kOtherMeaning = "rename the column if it has another meaning";

// Columns of what the paper did not vary. An empty field or NA stands for what it did.
constexpr FieldRule kAsInPaper{{}, Blank::kEmptyOrNA, kOtherMeaning};

Cell<Row> printed_number(double Row::*member, const NumberRange& range) {
  return {[member](const Row& row, CsvLines& lines) { lines.add(as_printed(row.*member)); },
          Field::number(member, range, kAsInPaper).read, values_text(range, kAsInPaper.blank)};
}

// Haptic or rotation: empty with a strategy.
Cell<Row> factor(std::string Row::*member, std::span<const std::string_view> names) {
  const Cell<Row> level = Field::level(member, names);
  return {level.write,
          [level](const std::string& field, Row& row) -> std::optional<FieldError> {
            if (row.strategy.empty()) return level.read(field, row);
            if (field.empty()) return std::nullopt;
            return FieldError{"an empty field, because strategy is " + row.strategy};
          },
          values_text(names, Blank::kNone)};
}

// "none|mask|a4-passive:0..1000": a strategy with a number has its range.
std::string strategy_values() {
  std::string text;
  for (const StrategyType* type : strategies()) {
    text.append(text.empty() ? "" : "|").append(type->name);
    if (!type->parameter) continue;
    text += ":" + as_printed(type->parameter->least) + ".." + as_printed(type->parameter->most);
  }
  return values_text(text, Blank::kEmpty);
}

Cell<Row> strategy_name() {
  return {
      [](const Row& row, CsvLines& lines) { lines.add(row.strategy); },
      [](const std::string& field, Row& row) -> std::optional<FieldError> {
        if (field.empty()) return std::nullopt;
        const auto known = parse_strategy(field);
        if (!known || name_of(*known) != field) {
          return FieldError{"an empty field, or the name of a strategy, such as a4", kOtherMeaning};
        }
        row.strategy = field;
        return std::nullopt;
      },
      strategy_values()};
}

constexpr NumberRange kNotNegative{0.0};
constexpr NumberRange kPictureRange_s{0.0, 1e6};
constexpr NumberRange kDensityRange_px_per_mm{0.0, 1e6, true};
// Works, whose sign is their direction; a difference; a share that may go back.
constexpr NumberRange kAnySign{};

std::optional<FieldError> read_measure(const std::string& field, const NumberRange& range,
                                       bool is_done, std::optional<double>& measure) {
  if (is_blank(field, Blank::kEmptyOrNA)) return std::nullopt;
  const std::optional<double> value = number_in(field);
  if (!value) return FieldError{"a number, such as 0.25, or an empty field"};
  if (*value < range.least) return FieldError{text_of(range) + ", or an empty field"};
  if (std::isfinite(*value)) {
    measure = value;
  } else if (is_done) {
    return FieldError{"a finite number, because the status is done",
                      "leave the field empty if the measure is undefined"};
  }
  return std::nullopt;
}

Column<Row> measure(std::size_t index, const NumberRange& range, std::string_view name,
                    std::string_view unit, std::string_view meaning, std::string_view paper = "") {
  const auto member = [index](auto& row) -> auto& {
    return row.measures[index];
  };
  const auto read = [member, range](const std::string& field, Row& row) {
    return read_measure(field, range, row.status == TrialStatus::kDone, member(row));
  };
  return {name,
          unit,
          std::string(meaning),
          paper,
          kOptional,
          {Field::number(member, {}).write, read, values_text(range, Blank::kEmptyOrNA)},
          kMeasures};
}

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

// "done, timeout (the time limit was reached) or fault (a fault ended the trial)"
std::string words_of(std::span<const std::string_view> names,
                     std::span<const std::string_view> meanings) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string meaning(meanings[i]);
    words.push_back(std::string(names[i]) + (meaning.empty() ? "" : " (" + meaning + ")"));
  }
  return joined_words({words.begin(), words.end()});
}

template <class Value, std::size_t count>
std::string words_of(const ConditionLevels<Value, count>& levels, std::size_t first = count) {
  std::array<std::string_view, count> meanings;
  for (std::size_t i = 0; i < count; ++i) meanings[i] = levels[i].meaning;
  const auto names = names_of(levels);
  return words_of(std::span(names).first(first), std::span(meanings).first(first));
}

template <std::size_t count>
std::string one_of(const std::array<std::string_view, count>& names) {
  return joined_words({names.begin(), names.end()});
}

// haptics, statuses: how many of the levels the trials have.
Columns columns_of_trials(std::size_t haptics, std::size_t statuses) {
  return {
      {"following", "", "how a simulated operator follows the turning scene; empty for a person",
       "", kOptional, Field::level(&Row::following, kFollowingNames, kEmptyForPeople), kFirst},
      {"participant", "", "the person, or the number of the simulated operator", "participant",
       kRequired, Field::name(&Row::participant), kFirst},
      {"block", "", "the block of trials; 0 is practice", "trial", kRequired,
       Field::whole(&Row::block, kFromZero), kFirst},
      {"trial", "", "the place of the trial within its block, 1 for the first", "", kOptional,
       Field::whole(&Row::trial, kFromOne), kFirst},
      {"haptic", "", haptic_meaning(haptics), "haptic condition", kRequired,
       factor(&Row::haptic, std::span(kHapticNames).first(haptics))},
      {"rotation", "", rotation_meaning(), "rotation condition", kRequired,
       factor(&Row::rotation, kRotationNames)},
      {"object", "", "the object whose contour is followed", "object", kRequired,
       Field::name(&Row::object)},
      {"attempt", "", "1, or higher for a trial that was repeated", "", kOptional,
       Field::whole(&Row::attempt, kFromOne)},
      {"status", "", words_of(kTrialStatusLevels, statuses), "", kRequired,
       Field::level(&Row::status, std::span(kTrialStatusNames).first(statuses))},
  };
}

Columns columns_of_measures() {
  return {
      measure(kTotalTime, kNotNegative, "total_time_s", "s",
              "from the first contact within the green sphere to the first contact within the red "
              "sphere",
              "total time"),
      measure(kContactTime, kNotNegative, "contact_s", "s", "part of the total time in contact"),
      measure(kLosses, kNotNegative, "losses_of_contact", "1",
              "transitions from contact to no contact, however short",
              "number of losses of contact"),
      measure(kLosses100ms, kNotNegative, "losses_100ms", "1",
              "intervals without contact of 0.1 s or more"),
      measure(kLossesPerSecond, kNotNegative, "losses_per_s", "1/s",
              "losses_of_contact divided by total_time_s"),
      measure(kLosses100msPerSecond, kNotNegative, "losses_100ms_per_s", "1/s",
              "losses_100ms divided by total_time_s"),
      measure(kPenetration, kNotNegative, "mean_penetration_m", "m",
              "mean distance from the device point to the proxy, over contact"),
      measure(kPenetrationDm, kNotNegative, "mean_penetration_dm", "dm",
              "mean_penetration_m in the paper's unit", "mean penetration"),
      measure(kContactAngle, kNotNegative, "mean_contact_angle_deg", "deg",
              "mean angle from the contact normal to the actuated axes, over contact",
              "mean contact angle"),
      measure(kShareWithin30deg, kNotNegative, "share_within_30deg", "1",
              "share of the contact with a contact angle of at most 30 deg"),
      measure(kTrackedShare, kAnySign, "tracked_share", "1",
              "share of the way from green to red along which the contact moved without a loss"),
      measure(kRecoveries, kNotNegative, "recoveries", "1",
              "how often the simulated operator was lost and went back to the contour"),
      measure(kDevicePath, kNotNegative, "device_path_m", "m",
              "length of the path of the device point, device frame"),
      measure(kProxyPath, kNotNegative, "proxy_path_m", "m",
              "length of the path of the proxy, scene frame"),
      measure(kPortWork, kAnySign, "port_work_J", "J",
              "work of the commanded force on the hand; positive: the device gave energy"),
      measure(kWorkLost, kAnySign, "work_lost_J", "J",
              "work of the full force on the hand minus port_work_J"),
      measure(kGhostForce, kNotNegative, "mean_ghost_force_N", "N",
              "mean part of the commanded force that is tangential to the surface, over contact"),
      measure(kMissingForce, kAnySign, "mean_missing_force_N", "N",
              "mean of the full force minus the commanded force along the normal, over contact"),
  };
}

// The number of ticks with each fault, and missed deadlines, which are no bit of a record.
Columns columns_of_faults() {
  Columns columns;
  for (std::size_t fault = 0; fault < kFaultCount; ++fault) {
    columns.push_back(measure(kFirstFaultMeasure + fault, kNotNegative, kFaultNames[fault], "1",
                              kFaultMeanings[fault]));
  }
  columns.push_back(measure(kMissedDeadlines, kNotNegative, "missed_deadlines", "1",
                            "ticks that began after their deadline; 0 in simulated time"));
  return columns;
}

Columns columns_of_strategy_measures() {
  return {
      measure(kWallWork, kNotNegative, "wall_work_J", "J",
              "work that the tangential part of the commanded force did in the direction of the "
              "motion, over contact"),
      measure(kLargestContactWork, kAnySign, "largest_contact_work_J", "J",
              "largest work of the commanded force on the hand in one contact; positive: the "
              "device gave energy"),
      measure(kEmptyTurns, kNotNegative, "empty_turns", "1",
              "turns of the scene in free motion that no contact followed within 0.1 s"),
      measure(kMeanDrift, kNotNegative, "mean_drift_m", "m",
              "mean distance of the scene from its place at the start, device frame; empty if the "
              "scene turned"),
      measure(kWorstDrift, kNotNegative, "worst_drift_m", "m", "largest such distance"),
      measure(kGovernorShare, kNotNegative, "governor_share", "1",
              "share of the ticks in which the governor changed the force"),
      measure(kTurningEnergy, kNotNegative, "turning_energy_J", "J",
              "energy that turns of the scene added to the spring of the motors, on one wall"),
      measure(kDeviceTravel, kNotNegative, "device_travel_m", "m",
              "largest extent of the device's positions along one axis, device frame"),
  };
}

Columns column_of_strategy() {
  return {{"strategy", "", "the technique for missing motors, in place of haptic and rotation", "",
           kOptional, strategy_name(), kStrategyTurn}};
}

Columns columns_of_variants() {
  return {
      {"view", "", "what the display shows of a scene that turns: " + one_of(kViewNames), "",
       kOptional, Field::level(&Row::view, kViewNames, kAsInPaper)},
      {"align", "",
       "the end of the motor's line that the normal turns to: " + one_of(kAlignmentNames), "",
       kOptional, Field::level(&Row::align, kAlignmentNames, kAsInPaper)},
      {"start_orientation_deg", "deg", "by which the scene is turned about A3 before the trial", "",
       kOptional, printed_number(&Row::start_orientation_deg, kStartRange_deg)},
      {"scale", "1", "factor of the object's size", "", kOptional,
       printed_number(&Row::scale, kScaleRange)},
  };
}

// A cell of LiveColumns. An empty field leaves the member as it is.
Cell<Row> of_live(const Cell<LiveColumns>& cell) {
  return {[cell](const Row& row, CsvLines& lines) {
            if (row.live) {
              cell.write(*row.live, lines);
            } else {
              lines.skip(1);
            }
          },
          [cell](const std::string& field, Row& row) -> std::optional<FieldError> {
            if (field.empty()) return std::nullopt;
            if (!row.live) row.live.emplace();
            auto error = cell.read(field, *row.live);
            if (error) error->hint = kOtherMeaning;
            return error;
          },
          values_text(cell.values, Blank::kEmpty)};
}

// Present in trials that were cut, and only there.
Cell<Row> cut_reason(const Cell<Row>& level) {
  return {
      level.write,
      [level](const std::string& field, Row& row) -> std::optional<FieldError> {
        const bool is_cut =
            row.status == TrialStatus::kAborted || row.status == TrialStatus::kSkipped;
        if (field.empty() != is_cut) return level.read(field, row);
        const std::string because =
            ", because the status is " +
            std::string(kTrialStatusNames[static_cast<std::size_t>(row.status)]);
        if (!is_cut) return FieldError{"an empty field" + because};
        return FieldError{joined_words({kCutReasonNames.begin(), kCutReasonNames.end()}) + because};
      },
      level.values};
}

Columns columns_of_live_trials() {
  using Live = LiveColumns;
  using LiveField = CsvCells<Live>;
  return {
      {"pilot", "", "1: a trial of a pilot run, which the analysis leaves out; otherwise 0", "",
       kOptional, of_live(LiveField::whole(&Live::pilot, {0, 1}))},
      {"input", "", "what moved the device point: " + words_of(kLiveInputLevels), "", kOptional,
       of_live(LiveField::level(&Live::input, kLiveInputNames))},
      {"motion", "",
       "motion of the pointer that the browser granted: " + words_of(kPointerMotionLevels) +
           "; empty for a board or a script",
       "", kOptional, of_live(LiveField::level(&Live::motion, kPointerMotionNames))},
      {"reason", "",
       "why the trial was aborted or skipped: " + words_of(kCutReasonLevels) + "; empty otherwise",
       "", kOptional, cut_reason(of_live(LiveField::level(&Live::reason, kCutReasonNames)))},
      {"returns_shown", "1", "how often a ring showed where to return to", "", kOptional,
       of_live(LiveField::whole(&Live::returns_shown, kFromZero))},
      {"clutches", "1", "how often the hand was set back while the device point stood still", "",
       kOptional, of_live(LiveField::whole(&Live::clutches, kFromZero))},
      {"pictures", "1", "pictures drawn in the trial", "", kOptional,
       of_live(LiveField::whole(&Live::pictures, kFromZero))},
      {"longest_picture_s", "s", "longest time between two pictures", "", kOptional,
       of_live(LiveField::number(&Live::longest_picture_s, kPictureRange_s))},
      {"css_px_per_mm", "1/mm",
       "pixels of CSS for each millimetre of the screen, as the participant measured it", "",
       kOptional, of_live(LiveField::number(&Live::css_px_per_mm, kDensityRange_px_per_mm))},
  };
}

// The view of a simulated person is the one of the following.
std::optional<Error> check_view(const Row& row, std::size_t line) {
  if (row.following.empty()) return std::nullopt;
  const auto following = std::find(kFollowingNames.begin(), kFollowingNames.end(), row.following);
  const View view = view_of(kFollowingLevels[following - kFollowingNames.begin()].value);
  const std::string expected(kViewNames[static_cast<std::size_t>(view)]);
  if (row.view == expected) return std::nullopt;
  return field_error(line, "view", row.view,
                     {expected + ", because the following is " + row.following});
}

// What identifies a trial.
std::string key_of(const Row& row) {
  std::string key;
  for (const std::string& part :
       {row.following, row.participant, std::to_string(row.block), row.haptic, row.rotation,
        row.strategy, row.object, std::to_string(row.attempt), row.view, row.align,
        as_printed(row.start_orientation_deg), as_printed(row.scale),
        std::to_string(row.live ? row.live->pilot : 0)}) {
    key += std::to_string(part.size()) + ":" + part;
  }
  return key;
}

std::string description_of(const Row& row) {
  return (row.following.empty() ? "" : row.following + ", ") + "participant " + row.participant +
         ", block " + std::to_string(row.block) + ", " +
         (row.strategy.empty() ? row.haptic + ", " + row.rotation : row.strategy) + ", " +
         row.object + ", attempt " + std::to_string(row.attempt) + ", " + row.view + ", " +
         row.align + ", " + as_printed(row.start_orientation_deg) + " deg, scale " +
         as_printed(row.scale) + (row.live && row.live->pilot == 1 ? ", pilot" : "");
}

CsvTable<Row> table_of(std::initializer_list<Columns> parts) {
  CsvTable<Row> table;
  for (const Columns& columns : parts) {
    table.columns.insert(table.columns.end(), columns.begin(), columns.end());
  }
  return table;
}

CsvTable<Row> make_table() {
  CsvTable<Row> table =
      table_of({columns_of_trials(kHapticNames.size(), kTrialStatusNames.size()),
                columns_of_measures(), columns_of_faults(), columns_of_strategy_measures(),
                column_of_strategy(), columns_of_variants(), columns_of_live_trials()});
  table.first_line = FirstLine::kByName;
  table.other_count = [](std::size_t found, std::size_t expected) {
    return "has " + std::to_string(found) + " fields; expected " + std::to_string(expected) +
           ", as in the first line";
  };
  table.rule = check_view;
  table.rule_turn = kOther;
  table.noun = "trial";
  table.most_rows = kMostTrialRows;
  table.key = key_of;
  table.description = description_of;
  table.repeated_hint = "remove one of the lines, or number the attempts";
  return table;
}

// What is in a file of one kind.
CsvTable<Row> make_written_table(TrialColumns kind) {
  const Columns trials = kind == TrialColumns::kLive
                             ? columns_of_trials(kHapticNames.size(), kTrialStatusNames.size())
                             : columns_of_trials(kFeltHapticCount, kSimulatedStatusCount);
  switch (kind) {
    case TrialColumns::kStrategies:
      return table_of({trials, columns_of_measures(), columns_of_faults(),
                       columns_of_strategy_measures(), column_of_strategy(),
                       columns_of_variants()});
    case TrialColumns::kLive:
      return table_of({trials, columns_of_measures(), columns_of_faults(), columns_of_variants(),
                       columns_of_live_trials()});
    case TrialColumns::kFactors:
      break;
  }
  return table_of({trials, columns_of_measures(), columns_of_faults(), columns_of_variants()});
}

}  // namespace

const CsvTable<TrialRow>& trials_table() {
  static const CsvTable<TrialRow> table = make_table();
  return table;
}

const CsvTable<TrialRow>& written_trials_table(TrialColumns columns) {
  static const std::array<CsvTable<Row>, 3> tables = {make_written_table(TrialColumns::kFactors),
                                                      make_written_table(TrialColumns::kStrategies),
                                                      make_written_table(TrialColumns::kLive)};
  return tables[static_cast<std::size_t>(columns)];
}

const std::array<std::string_view, kMeasureCount>& measure_names() {
  static const auto names = [] {
    std::array<std::string_view, kMeasureCount> all;
    std::size_t next = 0;
    for (const Column<Row>& column : trials_table().columns) {
      if (column.turn == kMeasures) all[next++] = column.name;
    }
    return all;
  }();
  return names;
}

const std::string& trials_columns(TrialColumns columns) {
  static const std::array<std::string, 3> names = {
      names_in(written_trials_table(TrialColumns::kFactors)),
      names_in(written_trials_table(TrialColumns::kStrategies)),
      names_in(written_trials_table(TrialColumns::kLive))};
  return names[static_cast<std::size_t>(columns)];
}

void add_row(CsvLines& lines, const TrialRow& row) {
  const TrialColumns kind = row.live               ? TrialColumns::kLive
                            : row.strategy.empty() ? TrialColumns::kFactors
                                                   : TrialColumns::kStrategies;
  write_row(written_trials_table(kind), row, lines);
}

std::string columns_csv(TrialColumns columns) {
  return columns_text(written_trials_table(columns));
}

std::string all_columns_csv() {
  return columns_text(trials_table());
}

Result<std::vector<TrialRow>> parse_trials(std::string_view text, const std::string& path) {
  return read_table(trials_table(), text, path);
}

Result<std::vector<TrialRow>> read_trials(const std::string& path) {
  const auto bytes = read_regular_file(path, kMostTrialsBytes);
  if (!bytes) return bytes.error();
  return parse_trials({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

}  // namespace palpate
