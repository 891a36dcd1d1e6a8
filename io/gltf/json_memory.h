#pragma once

// What JSON text takes once it is parsed, told before it is.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "geometry/base/memory_breakdown.h"

namespace palpate {

// Numbers of one text.
struct JsonExtent {
  std::uint64_t values = 0;  // of arrays and objects, all levels together
  std::uint64_t objects = 0;
  std::uint64_t largest = 0;  // values of one array or object, at most
};

// Does not check the grammar. Iterative; levels deeper than kMaxGltfJsonDepth are counted with the
// one above.
JsonExtent extent_of_json(std::string_view text);

// What parsing the text of an asset takes: the JSON, and tinygltf's model of it.
MemoryNeed memory_of_json(std::string_view text, const JsonExtent& extent);

// What the JSON library takes to destroy it: it moves the values of what it destroys to a list.
std::size_t memory_to_destroy(std::string_view text, const JsonExtent& extent);

}  // namespace palpate
