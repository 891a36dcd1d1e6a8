#pragma once

// Parsers of settings that are texts on the command line. Their errors name the option.

#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/node_motions.h"
#include "geometry/base/result.h"
#include "haptics/energy_budgets.h"

namespace palpate {

// --actuated-axes "0 0 1; 1 0 0"
Result<std::vector<Vec3>> parse_axes(const std::string& text);

// --place "x y z qw qx qy qz": T_device_scene; empty: the identity.
Result<ScenePose> parse_place(const std::string& text);

// --move 'NODE=vx vy vz wx wy wz'
Result<std::vector<SteadyMotion>> parse_moves(const std::vector<std::string>& texts);

// --energy-budget SOURCE=MJ,W; what is not stated has its default.
Result<EnergyBudgets> parse_energy_budgets(const std::vector<std::string>& texts);
// "motors 100 mJ at once and 0.25 W for ever (default 250 mJ and 0.25 W)" for each that differs
// from its default, separated by semicolons; empty if none does.
std::string energy_budgets_text(const EnergyBudgets& budgets);

// --material NAME.key=value
Result<std::vector<MaterialOverride>> parse_overrides(const std::vector<std::string>& texts);

}  // namespace palpate
