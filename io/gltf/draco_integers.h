#pragma once

// The integer types of a Draco stream, and conversion between them.

#include <cstddef>
#include <cstdint>
#include <draco/core/draco_types.h>
#include <optional>
#include <vector>

namespace palpate {

// The range and size of an integer type; Draco and glTF have the same types.
struct DracoIntegerType {
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  std::size_t bytes = 0;
};

// No value for types that are not integers.
std::optional<DracoIntegerType> draco_integer_type(draco::DataType type);

// Converts integers of one type to another. Returns false if any of them is out of range.
bool convert_draco_integers(const std::uint8_t* stored, const DracoIntegerType& from,
                            std::size_t count, const DracoIntegerType& to,
                            std::vector<std::uint8_t>& converted);

}  // namespace palpate
