#pragma once

// The plan that ships, the paper's experiment on the paper's objects, and the sweep that ships.

#include <string>

#include "geometry/base/result.h"

namespace palpate {

inline constexpr const char* kPaperPlan = "paper";  // its name
inline constexpr const char* kShippedSweep = "sweep";

// The folder that holds the models of the paper's objects: `models` in the current folder, or in
// the folder of the program, or in one of the four folders above that. An error if there is none.
Result<std::string> models_folder();

// The text of the plan or the sweep, in which the names of the objects' files begin with this
// folder; empty: without a folder.
std::string paper_plan_text(const std::string& objects_folder);
std::string shipped_sweep_text(const std::string& objects_folder);

// The text for a file in this folder, with paths that lead from there to the models.
// The paths are relative if possible. An empty folder stands for the current one.
Result<std::string> paper_plan_for(const std::string& folder);
Result<std::string> shipped_sweep_for(const std::string& folder);

}  // namespace palpate
