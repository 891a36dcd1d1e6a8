#include "engine/live/live_row.h"

#include <algorithm>

#include "engine/report/csv.h"
#include "engine/trials/trials_file.h"

namespace palpate {

namespace {

constexpr double kMsPerS = 1000.0;
constexpr std::size_t kMostPictures = 1000;  // a second of the fastest display has fewer pictures

}  // namespace

void DrawnPictures::add(const std::vector<double>& times_ms) {
  for (const double time_ms : times_ms) {
    if (last_ms_) longest_s = std::max(longest_s, (time_ms - *last_ms_) / kMsPerS);
    last_ms_ = time_ms;
    ++count;
    newest_ms_.push_back(time_ms);
    while (newest_ms_.back() - newest_ms_.front() > kMsPerS || newest_ms_.size() > kMostPictures) {
      newest_ms_.pop_front();
    }
  }
}

std::optional<double> DrawnPictures::rate_Hz() const {
  if (newest_ms_.size() < 2 || !(newest_ms_.back() > newest_ms_.front())) return std::nullopt;
  return kMsPerS * static_cast<double>(newest_ms_.size() - 1) /
         (newest_ms_.back() - newest_ms_.front());
}

std::string live_row_text(const ExperimentPlan& plan, int participant, const PlannedTrial& planned,
                          int attempt, const TrialOutcome& outcome, const LiveColumns& live) {
  TrialRow row = row_of(plan, participant, planned, outcome);
  if (live.input != LiveInput::kScript) row.following.clear();
  row.attempt = attempt;
  row.live = live;
  CsvLines lines("");
  lines.clear();
  add_row(lines, row);
  return lines.text();
}

}  // namespace palpate
