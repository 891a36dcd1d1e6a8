#pragma once

// The checks of a glTF file that must precede JSON parsing: the container, and the depth and the
// number of JSON values.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// Views into the bytes of the file.
struct GltfContainer {
  std::string_view json;                                   // after a byte order mark
  std::optional<std::span<const std::uint8_t>> bin_chunk;  // if a GLB has one
  // A chunk length of a GLB is not a multiple of 4, which violates glTF. Some exporters write such
  // files; the stated lengths are used without rounding.
  bool misaligned = false;
  bool byte_order_mark = false;  // a UTF-8 byte order mark, which JSON must not have
};

// Splits the content of a file. A GLB (glTF 2.0, section 4.4) is recognised by its magic number;
// its unknown chunks are ignored. Any other content is taken as JSON text as a whole. If this text
// is in UTF-16 or UTF-32, the error says so. Thread-safe.
Result<GltfContainer> split_container(std::span<const std::uint8_t> bytes);

// An error if the text nests deeper than kMaxGltfJsonDepth, holds more than kMaxGltfJsonValues
// values or is longer than kMaxGltfJsonBytes. Iterative; it does not check the grammar.
std::optional<Error> check_json_size(std::string_view json);

}  // namespace palpate
