#pragma once

// Writes scenes as binary glTF 2.0 assets.

#include <cstddef>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "models/primitives.h"

namespace palpate {

struct SceneContent;

// The bytes of a GLB container (glTF 2.0, section 4) of one scene: positions and texture
// coordinates as float, rounded from double; indices of 16 bit where they suffice, else of 32. No
// normals, so a viewer shades it flat. Extensions are listed as used, never as required. The same
// content gives the same bytes. kInvalidArgument if there is no mesh, a mesh has no triangle, an
// index is out of range, a number is not a finite float or a vertex lacks texture coordinates that
// others have; kLimitExceeded beyond 4 GiB. Not for the haptic thread. Thread-safe.
Result<std::string> encode_scene(const SceneContent& content);

struct GlbContent {
  std::string name;      // of the mesh and of the one node, which has no transform
  std::string material;  // name of the one material
  TriangleMesh mesh;
};

// encode_scene() for one mesh. node_extras goes to the node's "extras" unless it is null.
Result<std::string> encode_glb(GlbContent content, const nlohmann::json& node_extras);

// Replaces the file. Returns the number of bytes written, or kFileUnwritable.
Result<std::size_t> write_file(const std::string& path, const std::string& bytes);

}  // namespace palpate
