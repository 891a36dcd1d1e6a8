#pragma once

// Decodes images. libspng decodes PNG, and the TurboJPEG interface of libjpeg-turbo decodes JPEG.
// Both are designed for untrusted data, and neither uses longjmp() across C++ code.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "geometry/base/result.h"
#include "io/material_description.h"

namespace palpate {

// The limits for one image.
struct ImageRoom {
  std::uint64_t max_pixels = 0;
  // Called with the number of bytes that decoding needs, before they are allocated. A returned
  // Error ends the decoding. May be empty.
  std::function<std::optional<Error>(std::uint64_t bytes)> admit = {};
};

// The pixels of a PNG or JPEG; the content determines the format. Grey becomes equal red, green and
// blue; transparency is ignored; gamma and colour profiles are not applied, so the numbers are
// those of the file. Errors: a truncated or damaged image, a width or height above
// kMaxGltfImageSide, more than max_pixels (kLimitExceeded), and an error of admit(). The sizes are
// checked before the allocations that depend on them. Memory for decoding: see gltf/limits.h.
// Error::element is empty. Thread-safe.
Result<ImageDescription> decode_image(std::span<const std::uint8_t> bytes, const ImageRoom& room);

}  // namespace palpate
