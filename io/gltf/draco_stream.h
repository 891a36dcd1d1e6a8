#pragma once

// What a Draco stream says of itself, read and checked before the library sees it.

#include <cstdint>
#include <draco/core/decoder_buffer.h>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

inline constexpr const char* kDracoDamagedHint = "the data may be damaged";

// Reads the bytes from their beginning, which must outlive it.
draco::DecoderBuffer draco_buffer(std::span<const std::uint8_t> bytes);

// A stream of which the library knows everything but the numbers in it.
struct CheckedDracoStream {
  bool edgebreaker = false;
  std::span<const std::uint8_t> bytes;
  std::vector<std::uint8_t> storage;  // of bytes, where they are not those of the file
};

// Checks header and version, and leaves out the metadata. The bytes must outlive what is returned.
Result<CheckedDracoStream> check_draco_stream(std::span<const std::uint8_t> bytes,
                                              const std::string& element);

// The numbers at the start of the connectivity.
struct DracoConnectivity {
  std::uint32_t faces = 0;
  std::uint32_t vertices = 0;  // with those of split symbols: of the table the decoder makes
  std::uint32_t attribute_tables = 0;  // connectivities of their own, beside that of the positions
};

// Both take a copy of the stream where the connectivity begins, and leave the original there.
// Nothing if the stream ends there, or its numbers contradict each other.
std::optional<DracoConnectivity> peek_sequential_draco(draco::DecoderBuffer stream);
std::optional<DracoConnectivity> peek_edgebreaker_draco(draco::DecoderBuffer stream);

}  // namespace palpate
