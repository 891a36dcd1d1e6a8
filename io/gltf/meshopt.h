#pragma once

// Buffer views compressed by EXT_meshopt_compression, or by KHR_meshopt_compression with the same
// codecs. Decoded when first asked for, and once.

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
  std::size_t stride = 0;           // from element to element, in bytes
};

// The fallback that such a view may have in its own buffer is neither read nor needed. Not
// thread-safe; one per call of read_gltf().
class GltfMeshoptViews {
 public:
  // root: the JSON of the asset, of the shape that gltf/schema.h checks. Both must outlive this.
  GltfMeshoptViews(const nlohmann::json& root, GltfBuffers& buffers)
      : root_(root), buffers_(buffers) {}

  // The decoded view; null if the view is not compressed. Valid while this lives. Refused before
  // anything is allocated: what breaks a rule of the extension, and more elements than so many
  // compressed bytes can hold. Decoded views count among the bytes that kMaxGltfBufferBytes limits.
  Result<const GltfDecodedView*> decoded(std::size_t view);

 private:
  const nlohmann::json& root_;
  GltfBuffers& buffers_;
  std::map<std::size_t, GltfDecodedView> decoded_;
};

}  // namespace palpate
