#pragma once

// The material lists of root extensions, and warnings about unknown properties of their elements.

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// The array `name` of a root extension; null if absent. Returns an error (kLimitExceeded) if the
// array has more than kMaxGltfHapticMaterials elements.
Result<const nlohmann::json*> extension_list(const nlohmann::json& root, const char* extension,
                                             const char* name);

// Adds one warning for all properties of an object that are neither in `known` nor allowed in every
// glTF object.
void warn_about_others(const nlohmann::json& object, const std::string& element,
                       std::span<const char* const> known, std::vector<std::string>& warnings);

}  // namespace palpate
