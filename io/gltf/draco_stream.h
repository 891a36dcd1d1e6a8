#pragma once

// Reads and checks the headers of a Draco stream before the library decodes it.

#include <cstdint>
#include <draco/core/decoder_buffer.h>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

inline constexpr const char* kDracoDamagedHint = "the data may be damaged";

// A buffer that starts at the beginning of the bytes. The bytes must outlive the buffer.
draco::DecoderBuffer draco_buffer(std::span<const std::uint8_t> bytes);

// A stream whose format the library supports; the counts in it are still unchecked.
struct CheckedDracoStream {
  bool edgebreaker = false;
  std::span<const std::uint8_t> bytes;
  std::vector<std::uint8_t> storage;  // owns bytes if they differ from those of the file
};

// Checks header and version, and removes the metadata. The bytes must outlive the result.
Result<CheckedDracoStream> check_draco_stream(std::span<const std::uint8_t> bytes,
                                              const std::string& element);

// The numbers at the start of the connectivity.
struct DracoConnectivity {
  std::uint32_t faces = 0;
  // Includes the vertices of split symbols. The number is the size of the decoder's table.
  std::uint32_t vertices = 0;
  std::uint32_t attribute_tables = 0;  // further connectivities, besides that of the positions
};

// Both functions read from a copy of a stream that is positioned at the connectivity. They return
// no value if the stream is too short or its numbers contradict each other.
std::optional<DracoConnectivity> peek_sequential_draco(draco::DecoderBuffer stream);
std::optional<DracoConnectivity> peek_edgebreaker_draco(draco::DecoderBuffer stream);

}  // namespace palpate
