#pragma once

// The shape of the JSON of a glTF asset: types, required properties, ids within range.
//
// tinygltf ignores a property of the wrong type without a word and checks no id. So it is given
// only what was checked here, and needs no check of this kind behind it.

#include <nlohmann/json_fwd.hpp>

#include "geometry/result.h"

namespace palpate {

// A copy of root with the sections and properties that the reader uses, each of the type, the
// array length and the id range that glTF 2.0 asks for; a whole number written "3.0" becomes 3.
// Sections: scene, scenes, nodes, meshes, accessors, bufferViews, buffers. Error::element is the
// JSON path of the first property that breaks a rule. text_bytes: of the JSON text, by which the
// number of elements is bounded. Thread-safe.
Result<nlohmann::json> checked_sections(const nlohmann::json& root, std::size_t text_bytes);

}  // namespace palpate
