#pragma once

// What a scene declares about how it feels, and what was felt, told as JSON and as text.

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"
#include "engine/session/run_summary.h"

namespace palpate {

// effects, honoured, defaulted and not_understood of one part of a file.
nlohmann::ordered_json declaration_json(const DeclarationReport& declaration);
// The same of each material with its name and the parameters of its extras, as they are.
nlohmann::ordered_json materials_json(const Scene& scene);
nlohmann::ordered_json regions_json(const Scene& scene);
// {"friction": {"ticks": n, "time_share": x}, ..., "a4": {"ticks": n}}: time_share if it was
// measured.
nlohmann::ordered_json effects_use_json(const RunSummary& summary, const Scene& scene);

// What nothing was made of, a line each: which part of the file, key, place and reason.
std::vector<std::string> not_understood_lines(const Scene& scene);
// Lines for all that declares anything, and one with the effects of the scene.
std::string declarations_text(const Scene& scene);
// "12 ticks, 3.4 % of the time"
std::string effect_use_text(const RunSummary& summary, std::string_view effect);

}  // namespace palpate
