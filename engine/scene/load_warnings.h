#pragma once

// What a user should know about a loaded scene: what the file declares and the scene does not have.

#include <string>
#include <vector>

#include "engine/scene/scene.h"

namespace palpate {

// One line for each key or group of extras that is not applied, and for each ignored value. Errors
// in lines name fields of settings, as in Error.
std::vector<std::string> unapplied_lines(const Scene& scene);

// Both hidden_nodes_text() and these lines, for the warnings of a command.
std::vector<std::string> load_warnings(const Scene& scene);

}  // namespace palpate
