#pragma once

// Estimates, before parsing, the memory that JSON text needs when parsed.

#include <cstddef>
#include <string_view>

#include "geometry/base/memory_breakdown.h"
#include "io/gltf/json_scan.h"

namespace palpate {

// The memory that parsing the text of an asset needs, for the JSON and for tinygltf's model of the
// JSON.
MemoryNeed memory_of_json(std::string_view text, const JsonExtent& extent);

// The memory that the JSON library needs to destroy the JSON. It needs memory because it first
// moves the values to a list.
std::size_t memory_to_destroy(std::string_view text, const JsonExtent& extent);

}  // namespace palpate
