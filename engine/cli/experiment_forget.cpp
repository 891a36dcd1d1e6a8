#include "engine/cli/experiment_forget.h"

#include <iostream>

#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/live/live_folder.h"

namespace palpate {

int run_forget(const ExperimentForgetRequest& request) {
  const SignalPhaseScope deferred(SignalPhase::kDeferred);
  const auto folder = LiveFolder::existing(request.folder);
  if (!folder) return refuse(folder.error());
  if (const auto error = folder->forget_participant(*request.participant)) return refuse(*error);
  std::cout << "participant " << *request.participant << " is forgotten: " << request.folder
            << " keeps only the number and the date, in forgotten.csv\n"
            << "out of reach are backups of the folder, and exports and analyses made before: make "
               "them again, and delete the old ones\n";
  return exit_code_after_signals(finish_output());
}

void add_forget(CLI::App& experiment, ExperimentForgetRequest& request) {
  CLI::App& app = *experiment.add_subcommand("forget", "remove all that is known of a participant");
  set_help(app,
           "  ./run.sh experiment plan paper-live-mouse --out plan.json\n"
           "  ./run.sh experiment live plan.json --participant 1 --script people2005 --out people\n"
           "  ./run.sh experiment forget people 1\n",
           "Removes the rows, the recordings, the journal and what the participant said about "
           "themselves.\nThis cannot be undone.\n");
  app.add_option("DIR", request.folder, "folder of `experiment live --out`")->required();
  add_integer(app, "NUMBER", request.participant, {1, kMostParticipants},
              "number of the participant")
      ->required();
}

}  // namespace palpate
