#pragma once

// Estimates, before parsing, the memory that JSON text needs when parsed.

#include <cstddef>
#include <cstdint>

#include "geometry/base/memory_breakdown.h"
#include "io/gltf/json_scan.h"

namespace palpate {

// The bytes of a text that the JSON library gets: without the long spaces and data of the scan.
std::uint64_t parsed_bytes(const JsonScan& scan, std::uint64_t text_bytes);

// The memory that parsing the text of an asset needs, for the JSON and for tinygltf's model of the
// JSON. text_bytes: parsed_bytes().
MemoryNeed memory_of_json(std::uint64_t text_bytes, const JsonExtent& extent);

// The memory that the JSON library needs to destroy the JSON. It needs memory because it first
// moves the values to a list.
std::size_t memory_to_destroy(std::uint64_t text_bytes, const JsonExtent& extent);

}  // namespace palpate
