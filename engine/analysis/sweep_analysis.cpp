#include "engine/analysis/sweep_analysis.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "engine/analysis/sweep_chance.h"

namespace palpate {
namespace {

SweepBlock block_of(const SweepPointResult& point) {
  return point.rows.front().block;
}

const std::optional<double>& value_of(const SweepPointResult& point, std::size_t parameter) {
  return point.rows.front().values[parameter];
}

std::vector<SweepPointResult> points_in(std::span<const SweepRow> rows) {
  std::vector<SweepPointResult> points;
  while (!rows.empty()) {
    const auto end = std::find_if(rows.begin(), rows.end(), [&](const SweepRow& row) {
      return row.point != rows.front().point;
    });
    const auto count = static_cast<std::size_t>(end - rows.begin());
    SweepPointResult point{rows.first(count), {}};
    for (const SweepRanking& ranking : sweep_rankings()) {
      point.rankings.push_back(ranking_at(ranking, point.rows));
    }
    points.push_back(std::move(point));
    rows = rows.subspan(count);
  }
  return points;
}

SweepAxis axis_of(const std::vector<SweepPointResult>& points, std::size_t parameter) {
  SweepAxis axis{parameter, {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_base =
        block_of(points[i]) == SweepBlock::kBase && value_of(points[i], parameter).has_value();
    if (is_base || points[i].rows.front().varied == parameter) axis.points.push_back(i);
  }
  std::sort(axis.points.begin(), axis.points.end(), [&](std::size_t a, std::size_t b) {
    return *value_of(points[a], parameter) < *value_of(points[b], parameter);
  });
  return axis;
}

void add_flips(const std::vector<SweepPointResult>& points, const SweepAxis& axis,
               std::vector<SweepFlip>& flips) {
  for (std::size_t r = 0; r < sweep_rankings().size(); ++r) {
    const SweepPointResult* before = nullptr;  // the last testable level
    for (const std::size_t place : axis.points) {
      const SweepPointResult& after = points[place];
      const RankingAtPoint& is = after.rankings[r];
      if (!is.holds) continue;
      const SweepPointResult* const last = std::exchange(before, &after);
      if (!last || *last->rankings[r].holds == *is.holds) continue;
      flips.push_back({axis.parameter, r, *value_of(*last, axis.parameter),
                       *value_of(after, axis.parameter), *is.holds,
                       last->rankings[r].is_clear && is.is_clear});
    }
  }
}

void count_point(const RankingAtPoint& at, RankingShare& share) {
  if (!at.holds) {
    ++share.untestable;
    return;
  }
  ++share.points;
  share.holds += *at.holds ? 1 : 0;
}

// The parts of the points by a parameter: the words, or the halves of the values that occur.
PointSplit split_of(const std::vector<const SweepPointResult*>& points, std::size_t parameter) {
  std::set<double> values;
  for (const SweepPointResult* point : points) values.insert(*value_of(*point, parameter));
  const bool has_words = !sweep_parameters()[parameter].words.empty();
  PointSplit split;
  split.parts = has_words ? values.size() : std::size_t{2};
  const std::size_t half = values.size() / 2;
  for (const SweepPointResult* point : points) {
    const auto place = static_cast<std::size_t>(
        std::distance(values.begin(), values.find(*value_of(*point, parameter))));
    const bool is_low = place < half, is_high = place >= values.size() - half;
    const std::optional<std::size_t> part_of_number =
        is_low || is_high ? std::optional<std::size_t>(is_high ? 1 : 0) : std::nullopt;
    split.part_of.push_back(has_words ? place : part_of_number);
  }
  return split;
}

RankingHalves halves_of(const std::vector<const SweepPointResult*>& hypercube, std::size_t ranking,
                        std::size_t parameter) {
  RankingHalves halves{parameter, {}};
  const PointSplit split = split_of(hypercube, parameter);
  halves.parts.resize(split.parts);
  if (sweep_parameters()[parameter].words.empty()) {
    halves.parts[0].name = "low half";
    halves.parts[1].name = "high half";
  }
  for (std::size_t i = 0; i < hypercube.size(); ++i) {
    if (!split.part_of[i]) continue;
    RankingHalves::Part& part = halves.parts[*split.part_of[i]];
    if (part.name.empty())
      part.name = sweep_value_text(parameter, *value_of(*hypercube[i], parameter));
    count_point(hypercube[i]->rankings[ranking], part.share);
  }
  return halves;
}

// The p of the largest difference, over the testable points. Points keep their places in the parts.
double p_of(const std::vector<const SweepPointResult*>& hypercube, std::size_t ranking,
            const std::vector<std::size_t>& parameters) {
  std::vector<bool> holds;
  std::vector<PointSplit> splits;
  for (const SweepPointResult* point : hypercube) {
    if (point->rankings[ranking].holds) holds.push_back(*point->rankings[ranking].holds);
  }
  for (const std::size_t parameter : parameters) {
    PointSplit split = split_of(hypercube, parameter);
    std::vector<std::optional<std::size_t>> testable;
    for (std::size_t i = 0; i < hypercube.size(); ++i) {
      if (hypercube[i]->rankings[ranking].holds) testable.push_back(split.part_of[i]);
    }
    split.part_of = std::move(testable);
    splits.push_back(std::move(split));
  }
  return largest_difference_p(splits, std::move(holds), sweep_rankings()[ranking].name);
}

RankingResult result_of(const std::vector<const SweepPointResult*>& hypercube, std::size_t ranking,
                        const std::vector<std::size_t>& parameters) {
  RankingResult result;
  for (const SweepPointResult* point : hypercube) count_point(point->rankings[ranking], result.all);
  double largest = 0.0;
  for (const std::size_t parameter : parameters) {
    RankingHalves halves = halves_of(hypercube, ranking, parameter);
    const double size = std::abs(halves.difference().value_or(0.0));
    if (size > largest) result.most_different.clear();
    if (size > 0.0 && size >= largest) result.most_different.push_back(result.halves.size());
    largest = std::max(largest, size);
    result.halves.push_back(std::move(halves));
  }
  if (!result.most_different.empty()) result.p = p_of(hypercube, ranking, parameters);
  return result;
}

}  // namespace

SweepMean sweep_mean(const SweepPointResult& point, std::size_t outcome, std::size_t haptic,
                     std::size_t rotation) {
  SweepMean found;
  double sum = 0.0;
  const auto each = [&](auto use) {
    for (const SweepRow& row : point.rows) {
      const bool is_here = row.haptic == haptic && row.rotation == rotation;
      const auto value = is_here ? sweep_cell_mean(row, outcome) : std::nullopt;
      if (value) use(*value);
    }
  };
  each([&](double value) {
    sum += value;
    ++found.participants;
  });
  if (found.participants == 0) return found;
  found.mean = sum / found.participants;
  if (found.participants < 2) return found;
  double squares = 0.0;
  each([&](double value) { squares += (value - *found.mean) * (value - *found.mean); });
  found.sd = std::sqrt(squares / (found.participants - 1));
  return found;
}

SweepTrials trials_of(const SweepPointResult& point) {
  SweepTrials counts;
  for (const SweepRow& row : point.rows) {
    counts.trials += row.trials;
    counts.done += row.done;
  }
  return counts;
}

std::optional<double> RankingShare::share() const {
  if (points == 0) return std::nullopt;
  return static_cast<double>(holds) / points;
}

std::optional<double> RankingHalves::difference() const {
  std::vector<double> shares;
  for (const Part& part : parts) {
    if (part.share.share()) shares.push_back(*part.share.share());
  }
  if (shares.size() < 2) return std::nullopt;
  if (parts.size() == 2) return shares.back() - shares.front();
  const auto [smallest, largest] = std::minmax_element(shares.begin(), shares.end());
  return *largest - *smallest;
}

std::vector<std::size_t> RankingResult::decisive() const {
  constexpr double kChance = 0.05;
  return p && *p < kChance ? most_different : std::vector<std::size_t>();
}

int SweepAnalysis::point_count(SweepBlock block) const {
  return static_cast<int>(
      std::count_if(points.begin(), points.end(),
                    [&](const SweepPointResult& point) { return block_of(point) == block; }));
}

SweepAnalysis analyse_sweep(std::vector<SweepRow> rows) {
  SweepAnalysis analysis;
  analysis.rows = std::move(rows);
  analysis.points = points_in(analysis.rows);
  std::set<std::size_t> varied;
  std::vector<const SweepPointResult*> hypercube;
  for (const SweepPointResult& point : analysis.points) {
    if (point.rows.front().varied) varied.insert(*point.rows.front().varied);
    if (block_of(point) == SweepBlock::kHypercube) hypercube.push_back(&point);
  }
  analysis.parameters.assign(varied.begin(), varied.end());
  for (const std::size_t parameter : analysis.parameters) {
    analysis.axes.push_back(axis_of(analysis.points, parameter));
    add_flips(analysis.points, analysis.axes.back(), analysis.flips);
  }
  for (std::size_t r = 0; r < sweep_rankings().size(); ++r) {
    analysis.rankings.push_back(result_of(hypercube, r, analysis.parameters));
  }
  return analysis;
}

}  // namespace palpate
