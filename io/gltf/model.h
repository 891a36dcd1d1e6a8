#pragma once

// What the sections of the asset's JSON say that the core of glTF describes.

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

// tinygltf reads each element of a section as check_sections() hands it over, by the functions by
// which it reads those of a file, so that no section is written as text and parsed again. root,
// text_bytes, warnings: as there. Thread-safe.
Result<GltfModel> read_model(nlohmann::json& root, std::size_t text_bytes,
                             std::vector<std::string>& warnings);

}  // namespace palpate
