#pragma once

// The integers of a Draco stream, and the same numbers in another type.

#include <cstddef>
#include <cstdint>
#include <draco/core/draco_types.h>
#include <optional>
#include <vector>

namespace palpate {

// The integers of a type, which are the same in Draco and in glTF.
struct DracoIntegerType {
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  std::size_t bytes = 0;
};

// Nothing for types that are none.
std::optional<DracoIntegerType> draco_integer_type(draco::DataType type);

// Rewrites integers of one type as those of another. False if the other does not have them all.
bool convert_draco_integers(const std::uint8_t* stored, const DracoIntegerType& from,
                            std::size_t count, const DracoIntegerType& to,
                            std::vector<std::uint8_t>& converted);

}  // namespace palpate
