#include "engine/run_judgement.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace palpate {
namespace {

// A hand that gets on evenly reaches a fifth in the last fifth of its time; half of that is enough.
constexpr double kLateShareOfWay = 0.1;

std::string lost_contact_text(const ExplorationRun& run) {
  const double seconds_per_tick =
      run.records.size() > 1 ? run.records[1].time_s - run.records[0].time_s : 0.0;
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the hand was out of contact for "
       << static_cast<double>(run.summary.longest_gap_ticks) * seconds_per_tick
       << " s at a stretch, more than a tenth of the run";
  return text.str();
}

std::string little_way_text(const ExplorationRun& run) {
  const bool is_walk = run.contour_scene_m.empty();
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the proxy came near to " << 100 * run.way_share
       << (is_walk ? " % of the places that the hand aimed at" : " % of the contour")
       << ", expected 90 % or more: "
       << (was_still_getting_on(run) ? "the hand was still getting on when its time ended"
                                     : "the hand did not get to the rest, which other parts may "
                                       "cover, or which is smaller than the hand presses deep");
  return text.str();
}

}  // namespace

std::vector<Shortfall> shortfalls(const ExplorationRun& run) {
  const RunSummary& s = run.summary;
  if (s.contact_ticks == 0) return {Shortfall::kNeverTouched};
  std::vector<Shortfall> found;
  const auto longest_gap = kLongestGapShare * static_cast<double>(s.ticks);
  if (static_cast<double>(s.longest_gap_ticks) > longest_gap) {
    found.push_back(Shortfall::kLostContact);
  }
  if (run.way_share < kLeastWayShare) found.push_back(Shortfall::kLittleWay);
  return found;
}

bool are_comparable(const std::vector<ExplorationRun>& runs) {
  return std::all_of(runs.begin(), runs.end(), is_comparable);
}

std::vector<std::string> reasons(const ExplorationRun& run) {
  std::vector<std::string> texts;
  for (const Shortfall shortfall : shortfalls(run)) {
    switch (shortfall) {
      case Shortfall::kNeverTouched:
        texts.push_back("the hand touched nothing");
        break;
      case Shortfall::kLostContact:
        texts.push_back(lost_contact_text(run));
        break;
      case Shortfall::kLittleWay:
        texts.push_back(little_way_text(run));
        break;
    }
  }
  return texts;
}

bool has_means(const RunSummary& summary) {
  return summary.contact_share() >= kLeastContactShareOfMeans;
}

bool was_still_getting_on(const ExplorationRun& run) {
  return run.late_way_share > kLateShareOfWay * run.way_share;
}

}  // namespace palpate
