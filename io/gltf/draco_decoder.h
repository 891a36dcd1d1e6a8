#pragma once

// Decodes Draco streams within limits. The library's decoder is interrupted before each part in
// which counts of the stream determine allocations, and continues after these counts have been
// checked.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "geometry/base/result.h"
#include "io/gltf/buffers.h"

namespace draco {
class Mesh;
}

namespace palpate {

// The size of the decoded primitive according to its accessors.
struct DracoDeclared {
  std::uint64_t vertices = 0;
  std::uint64_t indices = 0;
  bool strip = false;
  std::uint64_t vertex_bytes = 0;  // bytes of one vertex, summed over all accessors
  std::uint64_t index_bytes = 0;   // bytes of one index

  // No product overflows: a count is at most 2^53, an element has at most 64 bytes, and all
  // elements together fit into a buffer.
  std::uint64_t bytes() const { return bytes_of(vertices, indices); }
  std::uint64_t bytes_of(std::uint64_t vertex_count, std::uint64_t index_count) const {
    return vertex_count * vertex_bytes + index_count * index_bytes;
  }
  // The accessor of a strip may describe the strip or the decoded list of triangles.
  bool agrees_in_triangles(std::uint64_t faces) const {
    return strip ? faces + 2 <= indices : 3 * faces == indices;
  }
};

// The remaining budget.
struct DracoLimits {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

// Decodes a stream. Decoded data beyond the declared size, and the memory for decoding, are counted
// in the buffers. element: JSON path of the extension, for messages. As thread-safe as the buffers.
Result<std::shared_ptr<const draco::Mesh>> decode_draco(std::span<const std::uint8_t> bytes,
                                                        GltfBuffers& buffers,
                                                        const DracoDeclared& declared,
                                                        const DracoLimits& remaining,
                                                        const std::string& element);

}  // namespace palpate
