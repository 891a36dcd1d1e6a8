#pragma once

// The images of one asset; each is decoded once, when a material first uses a texture map with it.

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

// Not thread-safe; one per call of read_gltf(). The asset must outlive this object.
class GltfImages {
 public:
  explicit GltfImages(const GltfAsset& asset) : asset_(asset) {}

  // Decodes the image of the texture unless it is already decoded, and sets
  // TextureReference::pixels. The encoded image is read from a buffer view, a data URI or a file;
  // data URIs and files are read in the same way as those of buffers. wanted_by: the element that
  // requires the image, for the hint. An error if the image is absent, damaged, neither PNG nor
  // JPEG, or above the limits of gltf/limits.h. The error names the texture or the image.
  std::optional<Error> decode(TextureReference& reference, const std::string& wanted_by);

  std::vector<ImageDescription> take() { return std::move(images_); }

 private:
  Result<ImageDescription> decoded(std::size_t image);
  Result<std::span<const std::uint8_t>> encoded(std::size_t image, FileBytes& storage);

  const GltfAsset& asset_;
  std::vector<ImageDescription> images_;
  std::map<std::uint32_t, std::uint32_t> indices_;  // id in the file to index in images_
  std::uint64_t pixels_left_ = kMaxGltfPixels;
};

}  // namespace palpate
