#pragma once

// The plans that ship, the paper's experiment on the paper's objects, and the sweep that ships.

#include <array>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// The plans by name: with simulated persons only; for people with a board; for people with a mouse.
inline constexpr const char* kPaperPlan = "paper";
inline constexpr std::array<std::string_view, 3> kShippedPlans = {kPaperPlan, "paper-live",
                                                                  "paper-live-mouse"};
bool is_shipped_plan(std::string_view name);

inline constexpr const char* kShippedSweep = "sweep";

// The folder that holds the models of the paper's objects: `models` in the current folder, or in
// the folder of the program, or in one of the four folders above that. An error if there is none.
Result<std::string> models_folder();

// The text of a plan, which must ship, or of the sweep, in which the names of the objects' files
// begin with this folder; empty: without a folder.
std::string shipped_plan_text(std::string_view name, const std::string& objects_folder);
std::string shipped_sweep_text(const std::string& objects_folder);

// The text for a file in this folder, with paths that lead from there to the models.
// The paths are relative if possible. An empty folder stands for the current one.
Result<std::string> shipped_plan_for(std::string_view name, const std::string& folder);
Result<std::string> shipped_sweep_for(const std::string& folder);

}  // namespace palpate
