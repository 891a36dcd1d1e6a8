#pragma once

// The shape of the JSON of a glTF asset: types, required properties, ids within range.
//
// tinygltf ignores a property of the wrong type without a word and checks no id. So it is given
// only what was checked here, and needs no check of this kind behind it.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

enum class GltfSection { kScenes, kNodes, kMeshes, kAccessors, kBufferViews, kBuffers };

// Takes what was checked.
class GltfElements {
 public:
  virtual ~GltfElements() = default;
  // So many elements of a section are about to come. The number is within the limits.
  virtual void expect(GltfSection section, std::size_t count) = 0;
  // The next one: taken, an object with the properties that the reader uses, each of the type, the
  // array length and the id range that glTF 2.0 asks for; a whole number written "3.0" is 3. The
  // scenes come as one, {"scene": 0, "scenes": [...]}, before all others. rest: what is left of it
  // in the document, if that is nothing, so that both can go together.
  virtual std::optional<Error> add(GltfSection section, nlohmann::json taken,
                                   nlohmann::json rest) = 0;
};

// Checks the sections in the order of GltfSection and hands over their elements, one at a time. The
// properties are moved out of root, so that they are not held twice: it keeps buffer views,
// extensions, extras and what else is read beside tinygltf, and the lengths of all sections.
// Error::element is the JSON path of the first property that breaks a rule. Min and max of an
// accessor that contradict each other are a warning. text_bytes: of the JSON text, by which the
// number of elements is bounded. Thread-safe.
std::optional<Error> check_sections(nlohmann::json& root, std::size_t text_bytes,
                                    std::vector<std::string>& warnings, GltfElements& elements);

}  // namespace palpate
