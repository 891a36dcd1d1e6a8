#pragma once

// Goes once through JSON text before any parser does: checks its size and depth, counts what
// determines the memory of parsing it, and finds long runs of spaces and the data of data URIs.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/json_spaces.h"

namespace palpate {

// The counts for one text.
struct JsonExtent {
  std::uint64_t values = 0;  // in arrays and objects, on all levels together
  std::uint64_t objects = 0;
  std::uint64_t largest = 0;  // the largest number of values in one array or object
  // Bounds the memory of the values in the JSON library, beside the text of long strings.
  std::uint64_t bytes = 0;
};

struct JsonScan {
  JsonExtent extent;
  // The objects in arrays of the root.
  std::size_t nodes = 0;
  std::size_t scenes = 0;
  std::size_t animations = 0;
  // The long runs of spaces between values, each without its last byte, in ascending order.
  std::vector<JsonTextPart> long_spaces;
  // The long data of strings that are data URIs, behind the comma, in ascending order; none if
  // they are few.
  std::vector<JsonTextPart> long_data;
};

// An error if the text exceeds a limit: kMaxGltfJsonBytes, kMaxGltfJsonDepth, kMaxGltfJsonValues,
// kMaxGltfStringBytes (data URIs may be longer), kMaxGltfStringBytesInAll or kMaxGltfJsonMemory.
// Does not check the grammar. Iterative; O(n). Thread-safe.
Result<JsonScan> scan_json(std::string_view text);

}  // namespace palpate
