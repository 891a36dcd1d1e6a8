#pragma once

// Writes one triangle mesh as a binary glTF 2.0 asset.

#include <cstddef>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/result.h"
#include "models/primitives.h"

namespace palpate {

struct GlbContent {
  std::string name;      // of the mesh and of the one node, which has no transform
  std::string material;  // name of the one material
  TriangleMesh mesh;
};

// The bytes of a GLB container (glTF 2.0, section 4): one scene, node, mesh and material; positions
// as float, rounded from double; indices of 16 bit where they suffice, else of 32. No normals, so a
// viewer shades it flat. node_extras goes to the node's "extras" unless it is null. The same
// content gives the same bytes. kInvalidArgument if the mesh has no triangle, an index is out of
// range or a coordinate is not a finite float; kLimitExceeded beyond 4 GiB.
// Not for the haptic thread. Thread-safe.
Result<std::string> encode_glb(const GlbContent& content, const nlohmann::json& node_extras);

// Replaces the file. Returns the number of bytes written, or kFileUnwritable.
Result<std::size_t> write_file(const std::string& path, const std::string& bytes);

}  // namespace palpate
