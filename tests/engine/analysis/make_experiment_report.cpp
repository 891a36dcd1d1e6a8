// make_experiment_report people|simulated FOLDER: the report of made-up trials, for viewing and for
// the test in a browser. The simulated operators have all followings, and timeouts; the people's
// file has the columns that an analysis needs and the contact angle.

#include <cstdio>
#include <string>
#include <utility>

#include "engine/analysis/experiment_report.h"
#include "engine/trials/levels.h"
#include "tests/engine/analysis/sample_trials.h"

namespace palpate {
namespace {

std::vector<TrialRow> made_up(bool is_simulated) {
  test::SampleTrials sample;
  if (is_simulated) {
    sample.followings.assign(kFollowingNames.begin(), kFollowingNames.begin() + kTurningFollowings);
    sample.has_timeouts = true;
    return sample_trials(sample);
  }
  auto rows = sample_trials(sample);
  for (TrialRow& row : rows) {
    row.measures[kLossesPerSecond].reset();
    row.measures[kLosses100ms].reset();
    row.measures[kPenetration].reset();
  }
  return rows;
}

bool write_all(bool is_simulated, const std::string& folder) {
  auto analysed = report_trials(made_up(is_simulated), {"trials.csv", 120.0}, folder);
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
}  // namespace palpate

int main(int argc, char** argv) {
  const std::string kind = argc == 3 ? argv[1] : "";
  if (kind != "people" && kind != "simulated") {
    std::fprintf(stderr, "make_experiment_report people|simulated FOLDER\n");
    return 2;
  }
  return palpate::write_all(kind == "simulated", argv[2]) ? 0 : 1;
}
