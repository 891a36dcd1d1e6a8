#pragma once

// The checks of a glTF file that must precede reading its JSON.

#include <optional>
#include <string_view>

#include "geometry/base/result.h"
#include "io/gltf/source.h"

namespace palpate {

// Where the parts of an asset are in its file.
struct GltfContainer {
  GltfRange json;                      // after a byte order mark
  std::optional<GltfRange> bin_chunk;  // if a GLB has one
  // A chunk length of a GLB is not a multiple of 4, which violates glTF. Some exporters write such
  // files; the stated lengths are used without rounding.
  bool misaligned = false;
  bool byte_order_mark = false;  // a UTF-8 byte order mark, which JSON must not have
};

// Judges a file by its size, its first bytes, the headers in it, and the ends of a long JSON text;
// reads nothing else, however large the file is. A GLB (glTF 2.0, section 4.4) is recognised by its
// magic number; its unknown chunks are ignored. Any other content is taken as JSON text as a whole.
// The error for other content names its format if that is known (known_formats.h), and the encoding
// if it is text in UTF-16 or UTF-32.
Result<GltfContainer> find_content(const GltfSource& source);

}  // namespace palpate
