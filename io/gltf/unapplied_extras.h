#pragma once

// Finds what authors wrote for Palpate where no reader looks for it: keys beside the group palpate,
// groups on other elements, other spellings.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/gltf/accessor.h"
#include "io/key_names.h"

namespace palpate {

// The elements of the file whose extras.palpate the scene has read.
struct AppliedElements {
  std::vector<bool> materials;       // by id: those of triangles that were read
  std::vector<bool> nodes;           // by id: those of the loaded scene that are not hidden
  std::vector<bool> hidden_nodes;    // by id: those of the loaded scene that are hidden
  std::optional<std::size_t> scene;  // the loaded scene
};

inline constexpr std::size_t kMostUnappliedLines = 32;

// One line for each key or group in the extras of any element that is not applied: its JSON path,
// and where it belongs. After kMostUnappliedLines, a line with the number of the others. Extras of
// other programs give no line: a key outside a group counts only if it is a key of Palpate or is
// misspelt in a few letters (KeyNames::find), and a key that is an ordinary word only together with
// a value that it can have. A group of another name counts if it has nothing but keys of Palpate.
// Keys inside a group that is applied are not searched; the engine reports them.
//
// Linear in the size of the JSON, which stays as it is. Thread-safe.
std::vector<std::string> unapplied_extras(const GltfAsset& asset, const AppliedElements& applied,
                                          const KeyNames& names);

}  // namespace palpate
