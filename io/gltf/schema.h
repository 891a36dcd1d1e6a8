#pragma once

// Checks the schema of the JSON of a glTF asset: types, required properties, ids within range.
//
// tinygltf silently ignores a property of the wrong type and checks no id. Therefore it parses only
// elements that were checked here.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

enum class GltfSection { kScenes, kNodes, kMeshes, kAccessors, kBufferViews, kBuffers };

// Receives the checked elements.
class GltfElements {
 public:
  virtual ~GltfElements() = default;
  // Announces the number of elements of a section. The number is within the limits.
  virtual void expect(GltfSection section, std::size_t count) = 0;
  // The next element. taken: an object with the properties that the reader uses. Each has the type,
  // the array length and the id range that glTF 2.0 requires; a whole number that the file writes
  // as "3.0" is stored as 3. The scenes are passed first, as one element {"scene": 0, "scenes":
  // [...]}. rest: what remains of the element in the document. It is passed only if the document no
  // longer needs it; taken and rest can then be destroyed together.
  virtual std::optional<Error> add(GltfSection section, nlohmann::json taken,
                                   nlohmann::json rest) = 0;
};

// Checks the sections in the order of GltfSection and passes their elements on, one at a time. The
// properties are moved out of root to avoid a second copy; root keeps the lengths of all sections,
// and all content that is not read through tinygltf, such as buffer views, extensions and extras.
// Error::element is the JSON path of the first invalid property. If min and max of an accessor
// contradict each other, there is a warning. text_bytes: length of the JSON text, which limits the
// number of elements. Thread-safe.
std::optional<Error> check_sections(nlohmann::json& root, std::size_t text_bytes,
                                    std::vector<std::string>& warnings, GltfElements& elements);

}  // namespace palpate
