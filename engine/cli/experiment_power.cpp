#include "engine/cli/experiment_power.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/python_page.h"
#include "engine/report/output_files.h"
#include "engine/trials/as_printed.h"
#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/deal/experiment_run.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

constexpr const char* kModelGroup = "Assumptions";
constexpr const char* kSimulationGroup = "Simulation";

// The largest standard deviation, in the unit of the measure: far beyond any measure, and small
// enough that no square overflows.
constexpr double kMostDeviation = 1e9;
constexpr int kMostPowerParticipants = 200;
constexpr int kMostPowerSets = 1'000'000;
constexpr int kMostPowerTrials = 1'000;

// The arguments of palpate.analysis.
std::vector<std::string> power_arguments(const ExperimentPowerRequest& request) {
  const int cores = static_cast<int>(std::min<std::size_t>(core_count(), kMostJobs));
  std::vector<std::string> arguments = {"power",
                                        "--measure=" + request.measure,
                                        "--effect=" + request.effects,
                                        "--pilot=" + request.pilot,
                                        "--following=" + request.following,
                                        "--participants=" + std::to_string(request.participants),
                                        "--sets=" + std::to_string(request.sets),
                                        "--seed=" + std::to_string(request.seed),
                                        "--jobs=" + std::to_string(request.jobs.value_or(cores))};
  const std::pair<const char*, std::optional<double>> numbers[] = {{"--error=", request.error_sd},
                                                                   {"--share-u=", request.share_u},
                                                                   {"--share-w=", request.share_w}};
  for (const auto& [option, value] : numbers) {
    if (value) arguments.push_back(option + as_printed(*value));
  }
  if (request.trials) arguments.push_back("--trials=" + std::to_string(*request.trials));
  return arguments;
}

void add_assumptions(CLI::App& app, ExperimentPowerRequest& power) {
  app.add_option("--measure", power.measure, "time, losses, penetration or angle")
      ->capture_default_str()
      ->group(kModelGroup);
  app.add_option("--effect", power.effects,
                 "means of the conditions: NoH-NoR=29,NoH-R=31,... for each of NoH, UaH, H with "
                 "NoR, R; of the angle, UaH-NoR and UaH-R alone [the paper's means]")
      ->type_name("LIST")
      ->group(kModelGroup);
  app.add_option("--pilot", power.pilot,
                 "trials.csv of a pilot: it gives the variances of u, w and e")
      ->type_name("FILE")
      ->group(kModelGroup);
  app.add_option("--following", power.following,
                 "which trials of the pilot's file to use, if it has several kinds: delayed, "
                 "predict, ..., or people")
      ->type_name("NAME")
      ->group(kModelGroup);
  const NumberRange sd{0.0, kMostDeviation, true};
  add_real(app, "--error", power.error_sd, sd,
           "standard deviation of one trial: of u, w and e together [the paper's]")
      ->group(kModelGroup);
  add_real(app, "--share-u", power.share_u, {0.0, 1.0},
           "share of u in the variance of one trial [a grid, 0.1 to 0.8]")
      ->group(kModelGroup);
  add_real(app, "--share-w", power.share_w, {0.0, 1.0}, "share of w [a grid, 0.1 to 0.8]")
      ->group(kModelGroup);
  add_integer(app, "--trials", power.trials, {1, kMostPowerTrials},
              "trials of a person in a condition: objects times blocks [the pilot's, or 12]")
      ->group(kModelGroup);
}

}  // namespace

int run_power(const ExperimentPowerRequest& request) {
  if (const auto error = check_not_canonical(request.pilot)) return refuse(*error);
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  auto files = OutputFiles::create(request.out_dir,
                                   {"report.html", "power.json", "needed_people.csv", "power.csv"});
  if (!files) return refuse(files.error());
  PageOutcome outcome = make_page(power_arguments(request), *files);
  outcome.text += "report.html, power.json and 2 tables are in " + request.out_dir + "/\n";
  return finish_page(outcome, *files);
}

void add_power(CLI::App& experiment, ExperimentPowerRequest& request) {
  CLI::App& app = *experiment.add_subcommand("power", "how many people an experiment needs");
  set_help(app,
           "  ./run.sh experiment power\n"
           "  ./run.sh experiment power --measure angle --trials 4\n"
           "  ./run.sh experiment power --effect NoH-NoR=30,NoH-R=34,UaH-NoR=29,UaH-R=29,H-NoR=27,"
           "H-R=28 --error 9 --share-u 0.3 --share-w 0.1\n",
           "A trial is y = condition + u(person) + w(person, condition) + e(trial), all normal. u "
           "is how a\nperson differs in all conditions alike, w how this person differs in one "
           "condition. Data sets are\nsimulated, and each one is analysed as `experiment analyse` "
           "does, with its first 2, 3, ... people.\nThe power is the share of the data sets in "
           "which a test is significant at 5 %. DIR/report.html has\nthe power over the number of "
           "people, needed_people.csv the smallest numbers, power.csv the curves.\nw and e are "
           "independent "
           "and scatter equally in all conditions. Sphericity therefore holds, and\nwhat the "
           "correction of Greenhouse and Geisser really costs is not shown.\n\n"
           "The paper states the error of one trial as a whole. How much of it is u and w must be "
           "assumed: a\nshare is a share of the variance u + w + e of one trial. Shares that are "
           "not given run over a grid.\nA pilot (a file of `experiment run`, or of people) "
           "measures u, w and e instead:\n"
           "  ./run.sh experiment power --pilot experiment/trials.csv --following delayed\n");
  add_assumptions(app, request);
  add_integer(app, "--participants", request.participants, {2, kMostPowerParticipants},
              "largest number of people")
      ->group(kSimulationGroup);
  add_integer(app, "--sets", request.sets, {100, kMostPowerSets}, "simulated data sets")
      ->group(kSimulationGroup);
  add_integer(app, "--seed", request.seed, {0, (std::uint64_t{1} << 53) - 1},
              "seed of the data sets")
      ->group(kSimulationGroup);
  add_integer(app, "--jobs", request.jobs, {1, kMostJobs},
              "data sets to compute at the same time [the number of cores]")
      ->group(kSimulationGroup);
  app.add_option("--out", request.out_dir, "folder of the results")
      ->capture_default_str()
      ->group(kSimulationGroup);
}

}  // namespace palpate
