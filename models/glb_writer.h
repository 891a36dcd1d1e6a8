#pragma once

// Writes scenes as binary glTF 2.0 assets.

#include <cstddef>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "models/primitives.h"

namespace palpate {

struct SceneContent;

// Returns the bytes of a GLB container (glTF 2.0, section 4) with one scene. Positions and texture
// coordinates are floats, rounded from double. Indices have 16 bits if these suffice, otherwise 32.
// The asset has no normals, so a viewer shades the scene flat. Extensions are listed as used, never
// as required. The same content gives the same bytes. Returns kInvalidArgument if there is no mesh,
// if a mesh has no triangle, if an index is out of range, if a number is not a finite float, or if
// some but not all vertices of a mesh have texture coordinates. Returns kLimitExceeded beyond 4
// GiB. Not for the haptic thread. Thread-safe.
Result<std::string> encode_scene(const SceneContent& content);

struct GlbContent {
  std::string name;      // name of the mesh and of the only node; the node has no transform
  std::string material;  // name of the only material
  TriangleMesh mesh;
};

// Encodes a scene with one mesh. node_extras becomes the node's "extras" unless it is null.
Result<std::string> encode_glb(GlbContent content, const nlohmann::json& node_extras);

// Writes the file, replacing an existing one. Returns the number of bytes written, or
// kFileUnwritable.
Result<std::size_t> write_file(const std::string& path, const std::string& bytes);

}  // namespace palpate
