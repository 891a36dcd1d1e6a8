#include "engine/experiment/sweep_analysis.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

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
    for (std::size_t i = 1; i < axis.points.size(); ++i) {
      const SweepPointResult& before = points[axis.points[i - 1]];
      const SweepPointResult& after = points[axis.points[i]];
      const RankingAtPoint& was = before.rankings[r];
      const RankingAtPoint& is = after.rankings[r];
      if (!was.holds || !is.holds || *was.holds == *is.holds) continue;
      flips.push_back({axis.parameter, r, *value_of(before, axis.parameter),
                       *value_of(after, axis.parameter), *is.holds, was.is_clear && is.is_clear});
    }
  }
}

void count_point(const RankingAtPoint& at, RankingShare& share) {
  if (!at.holds) return;
  ++share.points;
  share.holds += *at.holds ? 1 : 0;
}

RankingHalves halves_of(const std::vector<const SweepPointResult*>& hypercube, std::size_t ranking,
                        std::size_t parameter) {
  std::set<double> values;
  for (const SweepPointResult* point : hypercube) values.insert(*value_of(*point, parameter));
  RankingHalves halves{parameter, {}, {}};
  const std::size_t half = values.size() / 2;
  if (half == 0) return halves;
  const double low_end = *std::next(values.begin(), static_cast<std::ptrdiff_t>(half) - 1);
  const double high_begin = *std::prev(values.end(), static_cast<std::ptrdiff_t>(half));
  for (const SweepPointResult* point : hypercube) {
    const double value = *value_of(*point, parameter);
    if (value <= low_end) count_point(point->rankings[ranking], halves.low);
    if (value >= high_begin) count_point(point->rankings[ranking], halves.high);
  }
  return halves;
}

RankingResult result_of(const std::vector<const SweepPointResult*>& hypercube, std::size_t ranking,
                        const std::vector<std::size_t>& parameters) {
  RankingResult result;
  for (const SweepPointResult* point : hypercube) count_point(point->rankings[ranking], result.all);
  double largest = 0.0;
  for (const std::size_t parameter : parameters) {
    const RankingHalves halves = halves_of(hypercube, ranking, parameter);
    const double size = std::abs(halves.difference().value_or(0.0));
    if (size > largest) result.decisive.clear();
    if (size > 0.0 && size >= largest) result.decisive.push_back(result.halves.size());
    largest = std::max(largest, size);
    result.halves.push_back(halves);
  }
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
      if (is_here && row.means[outcome]) use(*row.means[outcome]);
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

std::optional<double> RankingShare::share() const {
  if (points == 0) return std::nullopt;
  return static_cast<double>(holds) / points;
}

std::optional<double> RankingHalves::difference() const {
  if (!low.share() || !high.share()) return std::nullopt;
  return *high.share() - *low.share();
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
