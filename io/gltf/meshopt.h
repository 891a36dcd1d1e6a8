#pragma once

// Buffer views compressed by EXT_meshopt_compression, or by KHR_meshopt_compression with the same
// codecs. Each view is decoded once, at its first use.

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/buffers.h"

namespace palpate {

struct GltfDecodedView {
  std::vector<std::uint8_t> bytes;  // exactly byteLength of the view
  std::size_t stride = 0;           // distance between elements, in bytes
};

// The decoded buffer views of one asset. The uncompressed fallback that a compressed view may have
// in its own buffer is not read. Not thread-safe; one per call of read_gltf().
class GltfMeshoptViews {
 public:
  // root: the JSON of the asset, checked by gltf/schema.h. root and buffers must outlive this
  // object.
  GltfMeshoptViews(const nlohmann::json& root, GltfBuffers& buffers)
      : root_(root), buffers_(buffers) {}

  // The decoded view; null if the view is not compressed. Valid for the lifetime of this object.
  // Returns an error if the view violates the extension or has more elements than the compressed
  // bytes can encode; both conditions are checked before any allocation. kMaxGltfBufferBytes limits
  // the bytes of decoded views and buffers together.
  Result<const GltfDecodedView*> decoded(std::size_t view);

 private:
  const nlohmann::json& root_;
  GltfBuffers& buffers_;
  std::map<std::size_t, GltfDecodedView> decoded_;
};

}  // namespace palpate
