#include "io/gltf/draco_integers.h"

#include <cstring>
#include <limits>

namespace palpate {
namespace {

template <typename Integer>
constexpr DracoIntegerType integers() {
  return {std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max(),
          sizeof(Integer)};
}

// Little-endian.
std::int64_t integer_at(const std::uint8_t* bytes, const DracoIntegerType& type) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, bytes, type.bytes);
  const auto value = static_cast<std::int64_t>(bits);
  return value > type.highest ? value - (std::int64_t{1} << (8 * type.bytes)) : value;
}

}  // namespace

std::optional<DracoIntegerType> draco_integer_type(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return integers<std::int8_t>();
    case draco::DT_UINT8:
      return integers<std::uint8_t>();
    case draco::DT_INT16:
      return integers<std::int16_t>();
    case draco::DT_UINT16:
      return integers<std::uint16_t>();
    case draco::DT_INT32:
      return integers<std::int32_t>();
    case draco::DT_UINT32:
      return integers<std::uint32_t>();
    default:
      return std::nullopt;
  }
}

bool convert_draco_integers(const std::uint8_t* stored, const DracoIntegerType& from,
                            std::size_t count, const DracoIntegerType& to,
                            std::vector<std::uint8_t>& converted) {
  converted.resize(count * to.bytes);
  for (std::size_t c = 0; c < count; ++c) {
    const std::int64_t value = integer_at(stored + c * from.bytes, from);
    if (value < to.lowest || value > to.highest) return false;
    const auto bits = static_cast<std::uint32_t>(value);
    std::memcpy(converted.data() + c * to.bytes, &bits, to.bytes);
  }
  return true;
}

}  // namespace palpate
