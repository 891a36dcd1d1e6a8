#include "engine/cli/run_results.h"

#include <iostream>
#include <sstream>
#include <utility>

#include "engine/cli/command_output.h"
#include "engine/cli/program_signals.h"

namespace palpate {

std::vector<std::string> run_file_names() {
  std::vector<std::string> names{kRunPicture, kStiffnessPicture, kStiffnessTable};
  for (const char* a4 : {"on", "off"}) {
    for (const char* what : {"trace-", "contour-", "places-"}) {
      names.push_back(std::string(what) + a4 + ".csv");
    }
  }
  return names;
}

std::string trace_name(bool a4) {
  return a4 ? "trace-on.csv" : "trace-off.csv";
}

int report_nothing_done() {
  std::cerr << "palpate: interrupted before the first tick; no file was written\n";
  return exit_code_after_signals(0);
}

std::optional<Error> move_into_place(OutputFiles& files) {
  if (!signal_flag().requested()) {
    if (auto error = check_output()) return error;
  }
  const SignalPhaseScope not_now(SignalPhase::kDeferred);
  return files.move_into_place();
}

Error with_path(Error error, const std::string& path) {
  if (error.path.empty()) error.path = path;
  return error;
}

std::string run_heading(const RunRequest& command, const PreparedRun& prepared,
                        const std::string& workspace) {
  const ActuationModel& actuation = prepared.setup.actuation;
  std::ostringstream text;
  text << command.scene.path << ": " << prepared.scene.statistics().cleaning.triangles
       << " triangles, " << actuation.sensors() << " sensors, " << actuation.actuators()
       << (actuation.actuators() == 1 ? " actuator" : " actuators") << ", workspace " << workspace;
  if (actuation.is_planar()) {
    text << ", plane at A3 = " << prepared.setup.haptics.plane_height_m << " m";
  }
  if (const double scale = prepared.scene.statistics().scale; scale != 1.0) {
    text << ", scale " << scale;
  }
  return text.str() + "\n";
}

}  // namespace palpate
