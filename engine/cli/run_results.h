#pragma once

// What the runs of a simulated hand and the runs on a device have in common when they write their
// results.

#include <optional>
#include <string>
#include <vector>

#include "engine/cli/prepared_run.h"
#include "engine/report/output_files.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr const char* kRunPicture = "paths.svg";
// Of runs on a device with motors: the chart of its stiffness, as a picture and as numbers.
inline constexpr const char* kStiffnessPicture = "stiffness.svg";
inline constexpr const char* kStiffnessTable = "stiffness.csv";

// Every file that any form of `run` writes.
std::vector<std::string> run_file_names();

// "trace-on.csv" or "trace-off.csv".
std::string trace_name(bool a4);

// Says that a signal came before the first tick. Returns the exit code.
int report_nothing_done();

// Refuses if stdout cannot be written to. After a signal the results are moved all the same: a user
// who closed the terminal finds them.
std::optional<Error> move_into_place(OutputFiles& files);

// The error, of this file if it names none.
Error with_path(Error error, const std::string& path);

// One line about the scene, the axes and the workspace, which all runs of a command share.
// workspace: "0.4 m along each sensed axis".
std::string run_heading(const RunRequest& command, const PreparedRun& prepared,
                        const std::string& workspace);

}  // namespace palpate
