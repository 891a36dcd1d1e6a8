#include "engine/analysis/sweep_rankings.h"

#include <algorithm>
#include <map>
#include <utility>

#include "engine/analysis/intervals.h"
#include "engine/analysis/paper_findings.h"
#include "engine/trials/plan.h"

namespace palpate {
namespace {

constexpr std::size_t kUaH = 1;  // index into kHapticNames
constexpr std::size_t kNoR = 0, kR = 1;

std::size_t place_of(Outcome outcome) {
  const auto found = std::find(kSweepOutcomes.begin(), kSweepOutcomes.end(), outcome);
  return static_cast<std::size_t>(found - kSweepOutcomes.begin());
}

SweepRanking::Level haptic_level(std::string_view name) {
  const auto place = static_cast<std::size_t>(
      std::find(kHapticNames.begin(), kHapticNames.end(), name) - kHapticNames.begin());
  return {std::string(name), {{place, kNoR}, {place, kR}}};
}

SweepRanking::Level rotation_level(std::string_view name, bool is_uah_alone) {
  const std::size_t place = name == kRotationNames[kR] ? kR : kNoR;
  if (is_uah_alone) return {std::string(name), {{kUaH, place}}};
  return {std::string(name), {{0, place}, {1, place}, {2, place}}};
}

SweepRanking of_paper(const PaperRanking& paper) {
  SweepRanking ranking;
  ranking.outcome = place_of(paper.outcome);
  ranking.name = std::string(outcome_text(paper.outcome).name) + ", " + effect_name(paper.term);
  ranking.statement = paper.statement;
  ranking.is_of_paper = true;
  const bool is_haptic = paper.term == FactorSet{kHapticFactor};
  for (const std::string_view level : paper.ascending) {
    ranking.ascending.push_back(
        is_haptic ? haptic_level(level)
                  : rotation_level(level, paper.outcome == Outcome::kContactAngle));
  }
  return ranking;
}

SweepRanking a4_improves(Outcome outcome) {
  SweepRanking ranking;
  ranking.outcome = place_of(outcome);
  ranking.ascending = {rotation_level("R", true), rotation_level("NoR", true)};
  ranking.name = std::string(outcome_text(outcome).name) + ", A4 in UaH";
  ranking.statement =
      "in UaH, rotation makes the " + std::string(outcome_text(outcome).name) + " smaller";
  return ranking;
}

// The rows of a participant in the six cells; null: missing.
using CellRows =
    std::array<std::array<const SweepRow*, kRotationNames.size()>, kHapticNames.size()>;

std::optional<double> level_mean(const SweepRanking::Level& level, std::size_t outcome,
                                 const CellRows& rows) {
  double sum = 0.0;
  for (const SweepRanking::Cell& cell : level.cells) {
    const SweepRow* const row = rows[cell.haptic][cell.rotation];
    const auto mean = row ? sweep_cell_mean(*row, outcome) : std::nullopt;
    if (!mean) return std::nullopt;
    sum += *mean;
  }
  return sum / static_cast<double>(level.cells.size());
}

// Whether a participant completed a trial of any cell of the ranking.
bool has_done_trial(const SweepRanking& ranking, const CellRows& rows) {
  for (const SweepRanking::Level& level : ranking.ascending) {
    for (const SweepRanking::Cell& cell : level.cells) {
      const SweepRow* const row = rows[cell.haptic][cell.rotation];
      if (row && row->done > 0) return true;
    }
  }
  return false;
}

// The values of the levels, one list for each complete participant.
std::vector<std::vector<double>> complete_values(const SweepRanking& ranking,
                                                 std::span<const SweepRow> rows) {
  std::map<int, CellRows> participants;
  for (const SweepRow& row : rows) participants[row.participant][row.haptic][row.rotation] = &row;
  std::vector<std::vector<double>> all;
  for (const auto& [participant, cells] : participants) {
    if (!has_done_trial(ranking, cells)) continue;
    std::vector<double> values;
    for (const SweepRanking::Level& level : ranking.ascending) {
      const auto mean = level_mean(level, ranking.outcome, cells);
      if (mean) values.push_back(*mean);
    }
    if (values.size() == ranking.ascending.size()) all.push_back(std::move(values));
  }
  return all;
}

}  // namespace

std::string SweepRanking::order() const {
  std::string text;
  for (const Level& level : ascending) text += (text.empty() ? "" : " < ") + level.name;
  return text;
}

const std::vector<SweepRanking>& sweep_rankings() {
  static const std::vector<SweepRanking> all = [] {
    std::vector<SweepRanking> rankings;
    for (const PaperRanking& paper : paper_rankings()) rankings.push_back(of_paper(paper));
    for (const Outcome outcome : {Outcome::kTime, Outcome::kLosses, Outcome::kPenetration}) {
      rankings.push_back(a4_improves(outcome));
    }
    return rankings;
  }();
  return all;
}

RankingAtPoint ranking_at(const SweepRanking& ranking, std::span<const SweepRow> rows_of_point) {
  const auto values = complete_values(ranking, rows_of_point);
  RankingAtPoint at;
  at.participants = static_cast<int>(values.size());
  if (values.empty()) return at;
  bool is_each_clear = true, is_one_reversed = false;
  at.holds = true;
  for (std::size_t level = 0; level < ranking.ascending.size(); ++level) {
    double sum = 0.0;
    for (const auto& of_participant : values) sum += of_participant[level];
    at.means.push_back(sum / static_cast<double>(values.size()));
    if (level == 0) continue;
    if (!(at.means[level - 1] < at.means[level])) at.holds = false;
    std::vector<double> steps;
    for (const auto& of_participant : values) {
      steps.push_back(of_participant[level] - of_participant[level - 1]);
    }
    const MeanInterval step = mean_interval(steps);
    is_each_clear = is_each_clear && step.excludes_zero() && step.mean > 0.0;
    is_one_reversed = is_one_reversed || (step.excludes_zero() && step.mean < 0.0);
  }
  at.is_clear = *at.holds ? is_each_clear : is_one_reversed;
  return at;
}

}  // namespace palpate
