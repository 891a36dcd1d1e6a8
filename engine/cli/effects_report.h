#pragma once

// Reports of a scene's haptic parameters and of the ticks in which effects were active, as JSON and
// as text.

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"
#include "engine/session/run_summary.h"

namespace palpate {

// The keys effects, honoured, defaulted and not_understood of one declaration.
nlohmann::ordered_json declaration_json(const DeclarationReport& declaration);
// The keys of declaration_json() for each material, and also its name and the unchanged parameters
// of its extras.
nlohmann::ordered_json materials_json(const Scene& scene);
nlohmann::ordered_json regions_json(const Scene& scene);
// {"friction": {"ticks": n, "time_share": x}, ..., "a4": {"ticks": n}}. time_share is present only
// if it was measured.
nlohmann::ordered_json effects_use_json(const RunSummary& summary, const Scene& scene);

// One line for each key or group of extras that is not applied and each ignored parameter
// (unapplied_lines); load_warning_lines(): all load_warnings(). Fields are replaced by options.
std::vector<std::string> not_understood_lines(const Scene& scene);
std::vector<std::string> load_warning_lines(const Scene& scene);
// Lines for every declaration with parameters, and one line with the effects of the scene.
std::string declarations_text(const Scene& scene);
// "12 ticks, 3.4 % of the time"
std::string effect_use_text(const RunSummary& summary, std::string_view effect);

}  // namespace palpate
