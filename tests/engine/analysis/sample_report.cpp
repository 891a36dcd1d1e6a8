#include <cstdio>
#include <string>
#include <vector>

#include "engine/analysis/experiment_report.h"
#include "engine/trials/levels.h"
#include "tests/engine/analysis/sample_trials.h"
#include "tests/engine/report/sample_reports.h"

namespace palpate {
namespace {

bool write_report(const std::vector<TrialRow>& rows, const std::string& folder) {
  auto analysed = report_trials(rows, {"trials.csv", 120.0}, folder);
  if (!analysed) {
    std::fprintf(stderr, "%s\n", analysed.error().to_string().c_str());
    return false;
  }
  for (const std::string& warning : analysed->warnings) {
    std::fprintf(stderr, "%s\n", warning.c_str());
  }
  std::fputs(analysed->text.c_str(), stdout);
  return analysed->warnings.empty() && !analysed->files.move_into_place();
}

}  // namespace

bool test::write_simulated_sample(const std::string& folder) {
  SampleTrials sample;
  sample.followings.assign(kFollowingNames.begin(), kFollowingNames.begin() + kTurningFollowings);
  sample.has_timeouts = true;
  return write_report(sample_trials(sample), folder);
}

bool test::write_people_sample(const std::string& folder) {
  auto rows = sample_trials(SampleTrials());
  for (TrialRow& row : rows) {
    row.measures[kLossesPerSecond].reset();
    row.measures[kLosses100ms].reset();
    row.measures[kPenetration].reset();
  }
  return write_report(rows, folder);
}

}  // namespace palpate
