#pragma once

// A scene as JSON for programs and as text for people.

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"

namespace palpate {

nlohmann::ordered_json scene_json(const Scene& scene);
nlohmann::ordered_json tree_json(std::span<const TreeNode> tree);  // an array of nodes, depth first
std::string scene_text(const std::string& path, const Scene& scene);

// The time that the scene took to load.
double load_ms(const SceneStatistics& statistics);

}  // namespace palpate
