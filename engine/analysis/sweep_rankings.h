#pragma once

// Rankings of conditions, and whether they hold at a point of a sweep.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/trials/sweep/sweep_rows.h"

namespace palpate {

// An order of two or three conditions by the mean of a measure. A condition is a set of cells: its
// value for a participant is the mean of the cells.
struct SweepRanking {
  struct Cell {
    std::size_t haptic, rotation;
  };
  struct Level {
    std::string name;  // "UaH", "R"
    std::vector<Cell> cells;
  };
  std::size_t outcome = 0;       // index into kSweepOutcomes
  std::vector<Level> ascending;  // in the order that the ranking claims
  std::string name;              // "total time, Haptic"
  std::string statement;         // "H is quickest, then UaH, then NoH"
  bool is_of_paper = false;      // otherwise: A4 improves the measure of UaH

  // "H < UaH < NoH"
  std::string order() const;
};

// The rankings that the paper reports, then, for each other measure, that A4 makes it smaller in
// the condition UaH. The paper reports the latter for the contact angle.
const std::vector<SweepRanking>& sweep_rankings();

// A ranking at a point. Participants count if each cell of the ranking has a value
// (sweep_cell_mean): they completed all trials of these cells; for the total time, a trial may also
// have ended by the time limit, but not all of them. All conditions are thus compared by the same
// trials.
struct RankingAtPoint {
  int participants = 0;
  std::vector<double>
      means;  // over participants, in the order of `ascending`; empty if there are 0
  // No value if there is no participant. Holds if each mean is below the next one.
  std::optional<bool> holds;
  // Whether this is more than noise of the persons: the 95 % intervals (Student's t) of the paired
  // differences of neighbours exclude 0; of a ranking that fails, that of a reversed pair.
  bool is_clear = false;
};
RankingAtPoint ranking_at(const SweepRanking& ranking, std::span<const SweepRow> rows_of_point);

}  // namespace palpate
