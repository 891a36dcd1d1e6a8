#include "engine/simulation/run_judgement.h"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <sstream>

#include "engine/simulation/path_plan.h"

namespace palpate {
namespace {

// A hand that advances evenly covers a fifth of its path in the last fifth of the run; half of that
// counts as still advancing.
constexpr double kLateShareOfWay = 0.1;

constexpr double kPressDepth_m = PathPlanSettings{}.press_depth_m;

// The cause of lost contact, if the run shows it.
std::string slips_off_text(const ExplorationRun& run) {
  if (!slips_off(run)) return {};
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << ": it slips off the object, which spans only "
       << 1e3 * way_extent_m(run) << " mm where the hand presses " << 1e3 * kPressDepth_m
       << " mm deep";
  return text.str();
}

std::string lost_contact_text(const ExplorationRun& run) {
  const double seconds_per_tick =
      run.records.size() > 1 ? run.records[1].time_s - run.records[0].time_s : 0.0;
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the hand was without contact for "
       << static_cast<double>(run.summary.longest_gap_ticks) * seconds_per_tick
       << " s without interruption, more than a tenth of the run" << slips_off_text(run);
  return text.str();
}

std::string little_contact_text(const ExplorationRun& run) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the hand was in contact for "
       << 100 * run.summary.contact_share() << " % of the run; expected at least "
       << std::setprecision(0) << 100 * kLeastContactShareOfMeans
       << " % (below, means are not printed)" << slips_off_text(run);
  return text.str();
}

std::string unreached_rest_text(const ExplorationRun& run) {
  std::ostringstream text;
  text << "the hand did not reach the rest; other parts may cover it, or it is smaller than the "
          "press depth of the hand";
  if (run.proxy_radius_m > 0.0) {
    text << ", or the sphere of `HapticSettings::god_object.radius_m` " << run.proxy_radius_m
         << " m is too large to enter";
  }
  return text.str();
}

std::string little_coverage_text(const ExplorationRun& run) {
  const bool is_walk = run.contour_scene_m.empty();
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the proxy "
       << (is_walk ? "reached " : "completed ") << 100 * run.way_share
       << (is_walk ? " % of the places on the path" : " % of the contour")
       << "; expected at least 90 %: "
       << (was_still_getting_on(run) ? "the hand was still advancing when the run ended"
                                     : unreached_rest_text(run));
  return text.str();
}

}  // namespace

std::vector<Shortfall> shortfalls(const ExplorationRun& run) {
  const RunSummary& s = run.summary;
  if (s.contact_ticks == 0) return {Shortfall::kNeverTouched};
  std::vector<Shortfall> found;
  if (!has_means(s)) found.push_back(Shortfall::kLittleContact);
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
        texts.emplace_back("the hand touched no surface");
        break;
      case Shortfall::kLittleContact:
        texts.push_back(little_contact_text(run));
        break;
      case Shortfall::kLostContact:
        texts.push_back(lost_contact_text(run));
        break;
      case Shortfall::kLittleWay:
        texts.push_back(little_coverage_text(run));
        break;
    }
  }
  return texts;
}

double way_extent_m(const ExplorationRun& run) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const auto* points : {&run.contour_scene_m, &run.places_scene_m}) {
    for (const Vec3& p : *points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  return std::max((high - low).maxCoeff(), 0.0);
}

bool slips_off(const ExplorationRun& run) {
  return way_extent_m(run) <= 2 * kPressDepth_m;
}

bool has_means(const RunSummary& summary) {
  return summary.contact_share() >= kLeastContactShareOfMeans;
}

bool was_still_getting_on(const ExplorationRun& run) {
  return run.late_way_share > kLateShareOfWay * run.way_share;
}

}  // namespace palpate
