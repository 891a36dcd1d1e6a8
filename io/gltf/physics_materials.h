#pragma once

// The materials of KHR_physics_rigid_bodies (draft), and the nodes that they are bound to. Nothing
// is interpreted here. Thread-safe.

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// Reads the physics materials, all of them, into a scene whose tree and nodes have been read, and
// binds them: a node has that of its own collider; else that of a collider whose geometry names the
// node or, nearest first, an ancestor (the geometry of a node includes its children). Where such
// colliders disagree, the first in depth-first order wins, with a note. Colliders outside the scene
// and triggers say nothing. An error if a declaration is not as its convention asks. The JSON is
// as check_sections() has left it.
std::optional<Error> read_physics_materials(const nlohmann::json& root, SceneDescription& scene);

}  // namespace palpate
