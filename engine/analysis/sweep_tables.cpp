#include "engine/analysis/sweep_tables.h"

#include <utility>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

ResultCell cell(const std::optional<double>& value) {
  return value ? ResultCell(*value) : ResultCell();
}
ResultCell name_cell(std::string_view name) {
  return std::string(name);
}
// A number, or a word.
ResultCell value_cell(std::size_t parameter, double value) {
  if (sweep_parameters()[parameter].words.empty()) return value;
  return sweep_value_text(parameter, value);
}
ResultCell parameter_cell(std::size_t parameter) {
  return name_cell(sweep_parameters()[parameter].name);
}

void add_level(const SweepAnalysis& analysis, const SweepAxis& axis, std::size_t point,
               ResultTable& table) {
  const SweepPointResult& of = analysis.points[point];
  const double level = *of.rows.front().values[axis.parameter];
  const SweepTrials trials = trials_of(of);
  for (std::size_t outcome = 0; outcome < kSweepOutcomes.size(); ++outcome) {
    for (std::size_t haptic = 0; haptic < kHapticNames.size(); ++haptic) {
      for (std::size_t rotation = 0; rotation < kRotationNames.size(); ++rotation) {
        const SweepMean mean = sweep_mean(of, outcome, haptic, rotation);
        table.rows.push_back(
            {parameter_cell(axis.parameter), value_cell(axis.parameter, level),
             of.rows.front().point, name_cell(outcome_text(kSweepOutcomes[outcome]).column),
             name_cell(kHapticNames[haptic]), name_cell(kRotationNames[rotation]), trials.trials,
             trials.done, mean.participants, cell(mean.mean), cell(mean.sd)});
      }
    }
  }
}

ResultTable levels_table(const SweepAnalysis& analysis) {
  ResultTable table{"one_at_a_time",
                    {"parameter", "level", "point", "measure", "haptic", "rotation",
                     "trials_of_point", "done_of_point", "participants", "mean", "sd"},
                    {}};
  for (const SweepAxis& axis : analysis.axes) {
    for (const std::size_t point : axis.points) add_level(analysis, axis, point, table);
  }
  return table;
}

ResultTable flips_table(const SweepAnalysis& analysis) {
  ResultTable table{
      "flips",
      {"parameter", "ranking", "order", "from", "to", "holds_at_from", "holds_at_to", "is_clear"},
      {}};
  for (const SweepFlip& flip : analysis.flips) {
    const SweepRanking& ranking = sweep_rankings()[flip.ranking];
    table.rows.push_back({parameter_cell(flip.parameter), ranking.name, ranking.order(),
                          value_cell(flip.parameter, flip.from),
                          value_cell(flip.parameter, flip.to), flip.holds_at_to ? 0 : 1,
                          flip.holds_at_to ? 1 : 0, flip.is_clear ? 1 : 0});
  }
  return table;
}

// "following align"
std::string decisive_names(const RankingResult& result) {
  std::string names;
  for (const std::size_t i : result.decisive()) {
    names += (names.empty() ? "" : " ") +
             std::string(sweep_parameters()[result.halves[i].parameter].name);
  }
  return names;
}

ResultTable rankings_table(const SweepAnalysis& analysis) {
  ResultTable table{"rankings",
                    {"ranking", "order", "is_of_paper", "points", "untestable", "holds", "share",
                     "low", "high", "decisive_parameters", "p"},
                    {}};
  for (std::size_t i = 0; i < analysis.rankings.size(); ++i) {
    const SweepRanking& ranking = sweep_rankings()[i];
    const RankingResult& result = analysis.rankings[i];
    const Interval interval = result.all.interval();
    const bool is_testable = result.all.points > 0;
    const auto bound = [&](double value) { return is_testable ? ResultCell(value) : ResultCell(); };
    table.rows.push_back({ranking.name, ranking.order(), ranking.is_of_paper ? 1 : 0,
                          result.all.points, result.all.untestable, result.all.holds,
                          cell(result.all.share()), bound(interval.low), bound(interval.high),
                          decisive_names(result), cell(result.p)});
  }
  return table;
}

ResultTable halves_table(const SweepAnalysis& analysis) {
  ResultTable table{
      "halves", {"ranking", "parameter", "part", "points", "holds", "share", "difference"}, {}};
  for (std::size_t i = 0; i < analysis.rankings.size(); ++i) {
    for (const RankingHalves& halves : analysis.rankings[i].halves) {
      for (const RankingHalves::Part& part : halves.parts) {
        table.rows.push_back({sweep_rankings()[i].name, parameter_cell(halves.parameter), part.name,
                              part.share.points, part.share.holds, cell(part.share.share()),
                              cell(halves.difference())});
      }
    }
  }
  return table;
}

}  // namespace

std::vector<ResultTable> sweep_tables(const SweepAnalysis& analysis) {
  return {levels_table(analysis), flips_table(analysis), rankings_table(analysis),
          halves_table(analysis)};
}

std::string sweep_json(const SweepAnalysis& analysis, const std::string& name) {
  const nlohmann::ordered_json head(name);
  std::string text = "{\n  \"palpate_sweep_results\": 1,\n  \"name\": " +
                     head.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  for (const ResultTable& table : sweep_tables(analysis)) {
    text += ",\n  \"" + table.name + "\": " + json_rows_of(table, 2);
  }
  return text + "\n}\n";
}

}  // namespace palpate
