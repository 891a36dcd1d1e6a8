#pragma once

// What a sweep shows: the measures along one parameter, where rankings flip, and at which share of
// the hypercube they hold.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/analysis/intervals.h"
#include "engine/analysis/sweep_rankings.h"
#include "engine/trials/sweep/sweep_rows.h"

namespace palpate {

// A point and its rankings, in the order of sweep_rankings(). The rows are those of the analysis.
struct SweepPointResult {
  std::span<const SweepRow> rows;
  std::vector<RankingAtPoint> rankings;
};

// The mean of a measure in one condition over the participants who have a value there
// (sweep_cell_mean), and its standard deviation over them (n - 1; no value below two participants).
struct SweepMean {
  int participants = 0;
  std::optional<double> mean, sd;
};
SweepMean sweep_mean(const SweepPointResult& point, std::size_t outcome, std::size_t haptic,
                     std::size_t rotation);

// How many trials of a point ended at the red sphere.
struct SweepTrials {
  int trials = 0, done = 0;
};
SweepTrials trials_of(const SweepPointResult& point);

// One parameter alone: its points by ascending value, those of its levels and the base plan's. The
// base plan is left out if its participants have different values.
struct SweepAxis {
  std::size_t parameter = 0;
  std::vector<std::size_t> points;  // indices of SweepAnalysis::points
};

// Between two levels of a parameter, a ranking begins to hold or ceases to. `from` is the last
// level below `to` at which the ranking is testable.
struct SweepFlip {
  std::size_t parameter = 0, ranking = 0;
  double from = 0.0, to = 0.0;  // the levels; from < to
  bool holds_at_to = false;
  bool is_clear = false;  // RankingAtPoint::is_clear of both levels
};

// At how many points a ranking holds among those at which it is testable. It is not testable at a
// point if no participant counts there (RankingAtPoint).
struct RankingShare {
  int holds = 0, points = 0;  // testable points
  int untestable = 0;         // the other points

  std::optional<double> share() const;  // no value without points
  Interval interval() const { return wilson_interval(holds, points); }
};

// The share in the parts of the hypercube by one parameter. The parts of a number are its "low
// half", the points with the first half of the values that occur in ascending order, and its "high
// half", those with the last half. The middle of an odd number of values belongs to neither half.
// Each word is a part with the name of the word.
struct RankingHalves {
  struct Part {
    std::string name;
    RankingShare share;
  };
  std::size_t parameter = 0;
  std::vector<Part> parts;

  // Of two parts, the last share minus the first; of more parts, the largest minus the smallest. No
  // value if fewer than two parts have a share.
  std::optional<double> difference() const;
};

// A ranking over the hypercube.
struct RankingResult {
  RankingShare all;
  std::vector<RankingHalves> halves;  // of each parameter of the sweep
  // The indices in `halves` of the largest |difference|, several if they are equal; empty if no
  // difference is above 0.
  std::vector<std::size_t> most_different;
  // The probability that chance alone makes the largest of all differences as large
  // (largest_difference_p); no value if no difference is above 0.
  std::optional<double> p;

  // `most_different` if p < 0.05; otherwise empty: no parameter decides beyond chance.
  std::vector<std::size_t> decisive() const;
};

// Movable; a copy would look into the rows of the original.
struct SweepAnalysis {
  SweepAnalysis() = default;
  SweepAnalysis(SweepAnalysis&&) = default;
  SweepAnalysis& operator=(SweepAnalysis&&) = default;

  std::vector<SweepRow> rows;
  std::vector<SweepPointResult> points;  // in the order of their numbers
  std::vector<std::size_t> parameters;   // that the sweep varies, in the order of the table
  std::vector<SweepAxis> axes;           // one for each of them
  std::vector<SweepFlip> flips;          // by parameter, ranking and level
  std::vector<RankingResult> rankings;   // in the order of sweep_rankings()

  int point_count(SweepBlock block) const;
};

// rows: by point, as in sweep.csv.
SweepAnalysis analyse_sweep(std::vector<SweepRow> rows);

}  // namespace palpate
