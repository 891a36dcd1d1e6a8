#pragma once

// The checks that must come before any JSON library sees a glTF file: the container, and the depth
// and the number of JSON values.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// Views into the bytes of the file.
struct GltfContainer {
  std::string_view json;                                   // behind the byte order mark
  std::optional<std::span<const std::uint8_t>> bin_chunk;  // of a GLB that has one
  // A chunk length of a GLB is not a multiple of 4, as it must be. Real exporters write such files;
  // the lengths are followed to the letter.
  bool misaligned = false;
  bool byte_order_mark = false;  // of UTF-8, which JSON must not have
};

// Splits a GLB (told by its magic) or takes the whole as JSON text. GLB: glTF 2.0, section 4.4;
// unknown chunks are passed over. JSON in UTF-16 or UTF-32 is refused as that. Thread-safe.
Result<GltfContainer> split_container(std::span<const std::uint8_t> bytes);

// The error if the text nests deeper than kMaxGltfJsonDepth, holds more than kMaxGltfJsonValues
// values or is longer than kMaxGltfJsonBytes. Iterative; it does not check the grammar.
std::optional<Error> check_json_size(std::string_view json);

}  // namespace palpate
