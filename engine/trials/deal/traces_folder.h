#pragma once

// The traces in the folder of a run: one file per trial (trace_name() in participant_run.h).

#include <string>

namespace palpate {

std::string traces_folder_of(const std::string& run_folder);

// Removes the traces of a run, but no other files. A trace does not state its run, so that another
// run would take it for its own.
void remove_traces(const std::string& run_folder);

}  // namespace palpate
