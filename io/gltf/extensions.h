#pragma once

// What the asset says about itself: the version of glTF and the extensions it uses.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// The error if /asset/version is not 2.x, or /asset/minVersion is beyond 2.0. Thread-safe.
std::optional<Error> check_asset_version(const nlohmann::json& root);

struct GltfExtensions {
  bool mesh_quantization = false;     // KHR_mesh_quantization is listed
  std::vector<std::string> warnings;  // one per extension that is used, but not known
};

// The error if the asset requires an extension without which its triangles cannot be read.
// Thread-safe.
Result<GltfExtensions> check_extensions(const nlohmann::json& root);

}  // namespace palpate
