#pragma once

// Decodes Draco streams within limits: the decoder of the library is asked to stop before each part
// that allocates by numbers of the stream which are not accounted for.

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

// What the accessors say of the decoded primitive.
struct DracoDeclared {
  std::uint64_t vertices = 0;
  std::uint64_t indices = 0;
  bool strip = false;
  std::uint64_t vertex_bytes = 0;  // of one vertex, in all of its accessors together
  std::uint64_t index_bytes = 0;   // of one index

  // No product wraps: a count is at most 2^53 and an element has at most 64 bytes, and all of them
  // together are no more than a buffer may have.
  std::uint64_t bytes() const { return bytes_of(vertices, indices); }
  std::uint64_t bytes_of(std::uint64_t vertex_count, std::uint64_t index_count) const {
    return vertex_count * vertex_bytes + index_count * index_bytes;
  }
  // A strip may stand for the list that is decoded, or be as long as that list.
  bool agrees_in_triangles(std::uint64_t faces) const {
    return strip ? faces + 2 <= indices : 3 * faces == indices;
  }
};

// How much more may be read.
struct DracoRoom {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

// What is decoded beyond the word of the accessors is counted in the buffers, with the memory that
// decoding takes. element: of the extension, for messages. Thread-safe as far as the buffers are.
Result<std::shared_ptr<const draco::Mesh>> decode_draco(std::span<const std::uint8_t> bytes,
                                                        GltfBuffers& buffers,
                                                        const DracoDeclared& declared,
                                                        const DracoRoom& room,
                                                        const std::string& element);

}  // namespace palpate
