#pragma once

// The row of trials.csv of a trial in which a person, or a script in a person's place, took part.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/trial_row.h"

namespace palpate {

// What the page reported of the pictures of a trial.
struct DrawnPictures {
  int count = 0;
  double longest_s = 0.0;  // the longest time between two pictures
  // Takes the times of further pictures, on the page's clock.
  void add(const std::vector<double>& times_ms);
  // The mean rate of the last second or so; no value: fewer than two pictures.
  std::optional<double> rate_Hz() const;

 private:
  std::optional<double> last_ms_;
  std::deque<double> newest_ms_;  // the last ones
};

// The row as a line of the file. planned: gives the conditions. outcome: has no measures if the
// trial was cut. A row of a person has no following.
std::string live_row_text(const ExperimentPlan& plan, int participant, const PlannedTrial& planned,
                          int attempt, const TrialOutcome& outcome, const LiveColumns& live);

}  // namespace palpate
