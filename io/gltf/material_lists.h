#pragma once

// Lists of materials that extensions of the root hold, and what nobody knows in their elements.

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// The array that an extension of the root has; null if the asset has none. An error
// (kLimitExceeded) if it has more than kMaxGltfHapticMaterials elements.
Result<const nlohmann::json*> extension_list(const nlohmann::json& root, const char* extension,
                                             const char* name);

// One warning for all properties of an object that are not these and not of every glTF object.
void warn_about_others(const nlohmann::json& object, const std::string& element,
                       std::span<const char* const> known, std::vector<std::string>& warnings);

}  // namespace palpate
