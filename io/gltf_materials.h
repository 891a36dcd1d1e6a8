#pragma once

// What the file declares about how surfaces feel, and which triangles it is said of: glTF materials
// with extras.palpate, KHR_physics_rigid_bodies (draft) and MPEG_haptic_material (ISO/IEC
// 23090-14). Nothing is interpreted here. Thread-safe.

#include <cstddef>
#include <cstdint>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "geometry/result.h"
#include "io/scene_description.h"

namespace palpate {

// Fills the materials of all three kinds into a scene whose tree, nodes and meshes have been read,
// and binds them:
// - glTF materials that triangles refer to, in the order of their first use: the runs of the meshes
//   come with ids of the file and leave with indices of the scene. A material that no triangle has
//   is not looked at.
// - physics materials, all of them: a node has that of its own collider; else that of a collider
//   whose geometry names the node or, nearest first, an ancestor (the geometry of a node includes
//   its children). Where such colliders disagree, the first in depth-first order wins, with a note.
//   Colliders outside the scene and triggers say nothing.
// - haptic materials, all of them; their meshes are bound by haptic_material_of_mesh.
// A note names the variants of KHR_materials_variants, which are not read.
//
// An error if a declaration is not as its convention asks, or cannot be represented. The JSON is
// one that checked_sections() takes.
std::optional<Error> read_materials(const nlohmann::json& root, SceneDescription& scene);

// The haptic material of a mesh of the file: index into the list of the extension, which the asset
// has under its name or its older one, MPEG_material_haptic.
Result<std::optional<std::uint32_t>> haptic_material_of_mesh(const nlohmann::json& root,
                                                             std::size_t mesh);

}  // namespace palpate
