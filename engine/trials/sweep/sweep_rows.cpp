#include "engine/trials/sweep/sweep_rows.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "engine/trials/csv_cells.h"

namespace palpate {
namespace {

// The time limit counts only for Outcome::kTimeToLimit.
constexpr double kNoLimit_s = 0.0;

std::optional<double> mean_of(std::span<const TrialRow> trials, Outcome outcome) {
  double sum = 0.0;
  int count = 0;
  for (const TrialRow& trial : trials) {
    const auto value = outcome_of(trial, outcome, kNoLimit_s);
    if (!value) continue;
    sum += *value;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

int count_of(std::span<const TrialRow> trials, TrialStatus status) {
  return static_cast<int>(std::count_if(
      trials.begin(), trials.end(), [&](const TrialRow& trial) { return trial.status == status; }));
}

template <std::size_t count>
std::size_t place_in(const std::array<std::string_view, count>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

using Row = SweepRow;
using Field = CsvCells<SweepRow>;

constexpr FieldRule kWord{"a known word", Blank::kNone, {}};
constexpr FieldRule kWordOrEmpty{"a known word", Blank::kEmpty, {}};
constexpr FieldRule kNumber{"a number", Blank::kNone, {}};
constexpr FieldRule kNumberOrEmpty{"a number or an empty field", Blank::kEmpty, {}};

const std::array<std::string_view, kSweepParameterCount>& parameter_names() {
  static const auto names = [] {
    std::array<std::string_view, kSweepParameterCount> all;
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = sweep_parameters()[i].name;
    return all;
  }();
  return names;
}

Column<Row> column_of_parameter(std::size_t i) {
  const SweepParameter& parameter = sweep_parameters()[i];
  const auto member = [i](auto& row) -> auto& {
    return row.values[i];
  };
  return {parameter.name,
          parameter.unit,
          std::string(parameter.meaning) + "; empty: each participant's own",
          "",
          Presence::kRequired,
          parameter.words.empty() ? Field::number(member, {}, kNumberOrEmpty)
                                  : Field::level(member, parameter.words, kWordOrEmpty)};
}

Column<Row> column_of_outcome(std::size_t i) {
  const OutcomeText& text = outcome_text(kSweepOutcomes[i]);
  const auto member = [i](auto& row) -> auto& {
    return row.means[i];
  };
  return {text.column,
          text.unit.empty() ? "1" : text.unit,
          "mean of the " + std::string(text.name) + " over the trials that were done",
          "",
          Presence::kRequired,
          Field::number(member, {}, kNumberOrEmpty)};
}

CsvTable<Row> make_sweep_table() {
  CsvTable<Row> table;
  using enum Presence;
  table.columns = {
      {"point", "", "the number of the point, 1 for the first", "", kRequired,
       Field::whole(&Row::point)},
      {"block", "", "the block of points", "", kRequired,
       Field::level(&Row::block, kSweepBlockNames, kWord)},
      {"parameter", "", "the parameter that varies; empty in the other blocks", "", kRequired,
       Field::level(&Row::varied, parameter_names(), kWordOrEmpty)},
  };
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) {
    table.columns.push_back(column_of_parameter(i));
  }
  const std::vector<Column<Row>> behind_parameters = {
      {"participant", "", "the number of the simulated operator", "", kRequired,
       Field::whole(&Row::participant)},
      {"haptic", "", haptic_meaning(kFeltHapticCount), "", kRequired,
       Field::level(&Row::haptic, std::span(kHapticNames).first(kFeltHapticCount), kWord)},
      {"rotation", "", rotation_meaning(), "", kRequired,
       Field::level(&Row::rotation, kRotationNames, kWord)},
      {"trials", "1", "trials of the participant in the condition", "", kRequired,
       Field::whole(&Row::trials)},
      {"done", "1", "trials that were done", "", kRequired, Field::whole(&Row::done)},
      {"timeouts", "1", "trials that reached the limit", "", kRequired,
       Field::whole(&Row::timeouts)},
      {"faults", "1", "trials that a fault ended", "", kRequired, Field::whole(&Row::faults)},
      {"limit_s", "s", "the time limit of a trial", "", kRequired,
       Field::number(&Row::limit_s, {}, kNumber)},
  };
  table.columns.insert(table.columns.end(), behind_parameters.begin(), behind_parameters.end());
  for (std::size_t i = 0; i < kSweepOutcomes.size(); ++i) {
    table.columns.push_back(column_of_outcome(i));
  }
  table.other_columns = "has other fields; expected the columns " + names_in(table);
  table.other_count = [problem = table.other_columns](std::size_t, std::size_t) { return problem; };
  return table;
}

}  // namespace

const CsvTable<SweepRow>& sweep_table() {
  static const CsvTable<SweepRow> table = make_sweep_table();
  return table;
}

const std::string& sweep_columns() {
  static const std::string columns = names_in(sweep_table());
  return columns;
}

std::vector<SweepRow> sweep_rows(int number, const SweepPoint& point,
                                 std::span<const TrialRow> trials, double limit_s) {
  std::map<std::tuple<int, std::size_t, std::size_t>, std::vector<TrialRow>> cells;
  for (const TrialRow& trial : trials) {
    cells[{std::stoi(trial.participant), place_in(kHapticNames, trial.haptic),
           place_in(kRotationNames, trial.rotation)}]
        .push_back(trial);
  }
  std::vector<SweepRow> rows;
  for (const auto& [cell, of_cell] : cells) {
    SweepRow row;
    row.point = number;
    row.block = point.block;
    row.varied = point.varied;
    row.values = point.values;
    std::tie(row.participant, row.haptic, row.rotation) = cell;
    row.trials = static_cast<int>(of_cell.size());
    row.done = count_of(of_cell, TrialStatus::kDone);
    row.timeouts = count_of(of_cell, TrialStatus::kTimeout);
    row.faults = count_of(of_cell, TrialStatus::kFault);
    row.limit_s = limit_s;
    for (std::size_t i = 0; i < kSweepOutcomes.size(); ++i) {
      row.means[i] = mean_of(of_cell, kSweepOutcomes[i]);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

void add_sweep_row(CsvLines& lines, const SweepRow& row) {
  write_row(sweep_table(), row, lines);
}

std::string sweep_columns_csv() {
  return columns_text(sweep_table());
}

Result<std::vector<SweepRow>> parse_sweep_rows(std::string_view text, const std::string& path) {
  return read_table(sweep_table(), text, path);
}

}  // namespace palpate
