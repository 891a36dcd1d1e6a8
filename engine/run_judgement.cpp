#include "engine/run_judgement.h"

#include <iomanip>
#include <sstream>

namespace palpate {

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

std::string shortfall_text(Shortfall shortfall, const ExplorationRun& run) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  const double seconds_per_tick =
      run.records.size() > 1 ? run.records[1].time_s - run.records[0].time_s : 0.0;
  switch (shortfall) {
    case Shortfall::kNeverTouched:
      return "the hand touched nothing";
    case Shortfall::kLostContact:
      text << "the hand was out of contact for "
           << static_cast<double>(run.summary.longest_gap_ticks) * seconds_per_tick
           << " s at a stretch, more than a tenth of the run";
      break;
    case Shortfall::kLittleWay:
      text << (run.contour_scene_m.empty() ? "it reached " : "it completed ") << 100 * run.way_share
           << (run.contour_scene_m.empty() ? " % of the places it aimed at" : " % of the contour")
           << ", expected 90 % or more";
      break;
  }
  return text.str();
}

bool has_means(const RunSummary& summary) {
  return summary.contact_share() >= kLeastContactShareOfMeans;
}

}  // namespace palpate
