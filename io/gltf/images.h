#pragma once

// The images of one asset, decoded when a texture map is called for, and once.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/material_description.h"

namespace palpate {

// Not thread-safe; one per call of read_gltf(). The asset must outlive it.
class GltfImages {
 public:
  explicit GltfImages(const GltfAsset& asset) : asset_(asset) {}

  // Decodes the image of the texture, from a buffer view, a data URI or a file as buffers have
  // them, unless that is done; and sets TextureReference::pixels. wanted_by: what calls for it, for
  // the hint. An error that names the texture or the image if there is none, it is broken, of
  // another format than PNG and JPEG or beyond gltf/limits.h.
  std::optional<Error> decode(TextureReference& reference, const std::string& wanted_by);

  std::vector<ImageDescription> take() { return std::move(images_); }

 private:
  Result<ImageDescription> decoded(std::size_t image);
  Result<std::span<const std::uint8_t>> encoded(std::size_t image, FileBytes& storage);

  const GltfAsset& asset_;
  std::vector<ImageDescription> images_;
  std::map<std::uint32_t, std::uint32_t> indices_;  // by id in the file
  std::uint64_t pixels_left_ = kMaxGltfPixels;
};

}  // namespace palpate
