#pragma once

// The materials of KHR_physics_rigid_bodies (draft), and the nodes that they are bound to. The
// values are not interpreted here. Thread-safe.

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// Reads all physics materials into a scene whose tree and nodes have been read, and binds them to
// nodes. A node has the material of its own collider. A node without a material of its own has the
// material of a collider whose geometry names the node or an ancestor, because the geometry of a
// node includes its children; the nearest of the named nodes counts. If several colliders name one
// node and disagree, the first collider in depth-first order is used, with a note. Colliders
// outside the scene and triggers are ignored. Returns an error if a declaration violates the
// extension's specification. root: the JSON after check_sections().
std::optional<Error> read_physics_materials(const nlohmann::json& root, SceneDescription& scene);

}  // namespace palpate
