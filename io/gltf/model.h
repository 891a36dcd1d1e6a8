#pragma once

// The core sections of the asset's JSON as a tinygltf model.

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/buffers.h"
#include "io/gltf/tinygltf.h"

namespace palpate {

struct GltfModel {
  tinygltf::Model model;  // scenes, nodes, meshes, accessors and views; no buffers
  std::vector<GltfBufferDeclaration> buffers;
};

// Builds the model. tinygltf's own functions parse each element as check_sections() provides it, so
// that no section has to be written as text and parsed again. root, text_bytes, warnings: as for
// check_sections(). Thread-safe.
Result<GltfModel> read_model(nlohmann::json& root, std::size_t text_bytes,
                             std::vector<std::string>& warnings);

}  // namespace palpate
