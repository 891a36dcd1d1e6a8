#pragma once

// Estimates, before parsing, the memory that JSON text needs when parsed.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "geometry/base/memory_breakdown.h"

namespace palpate {

// The counts for one text.
struct JsonExtent {
  std::uint64_t values = 0;  // in arrays and objects, on all levels together
  std::uint64_t objects = 0;
  std::uint64_t largest = 0;  // the largest number of values in one array or object
};

// Counts the values of a text without checking its grammar. Iterative; levels deeper than
// kMaxGltfJsonDepth are counted with the level above.
JsonExtent extent_of_json(std::string_view text);

// The memory that parsing the text of an asset needs, for the JSON and for tinygltf's model of the
// JSON.
MemoryNeed memory_of_json(std::string_view text, const JsonExtent& extent);

// The memory that the JSON library needs to destroy the JSON. It needs memory because it first
// moves the values to a list.
std::size_t memory_to_destroy(std::string_view text, const JsonExtent& extent);

}  // namespace palpate
