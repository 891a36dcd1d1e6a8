#pragma once

// Checks the glTF version and the extensions that the asset declares.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// Returns an error if /asset/version is not 2.x, or /asset/minVersion is above 2.0. Thread-safe.
std::optional<Error> check_asset_version(const nlohmann::json& root);

struct GltfExtensions {
  bool mesh_quantization = false;     // KHR_mesh_quantization is listed
  std::vector<std::string> warnings;  // one for each unknown extension in use
};

// Returns an error if the asset requires an unsupported extension without which its triangles
// cannot be read. Thread-safe.
Result<GltfExtensions> check_extensions(const nlohmann::json& root);

}  // namespace palpate
