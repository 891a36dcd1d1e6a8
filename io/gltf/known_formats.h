#pragma once

// Names the format of a file that is not glTF.

#include <optional>
#include <string_view>

namespace palpate {

struct KnownFormat {
  std::string_view name;    // "a ZIP archive"
  std::string_view remedy;  // "unpack it, and name the .gltf or .glb file in it"
};

// The format that the first bytes of a file belong to; no value if they are not known. Thread-safe.
std::optional<KnownFormat> known_format(std::string_view start);

}  // namespace palpate
