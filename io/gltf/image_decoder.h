#pragma once

// Encoded images to numbers. PNG is decoded by libspng, JPEG by the TurboJPEG interface of
// libjpeg-turbo: both are made for data from anywhere, and neither jumps over C++ code.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "geometry/base/result.h"
#include "io/material_description.h"

namespace palpate {

// How much an image may take.
struct ImageRoom {
  std::uint64_t max_pixels = 0;
  // Asked for the bytes that decoding takes, before it takes them: an Error ends it. May be empty.
  std::function<std::optional<Error>(std::uint64_t bytes)> admit = {};
};

// The pixels of a PNG or JPEG, told apart by its content. Grey becomes red, green and blue; what is
// transparent is taken as if it were not; gamma and colour profiles are not applied: the numbers
// are those of the file. Refused: what is cut short or damaged, and, before anything is allocated
// by them, a width or height beyond kMaxGltfImageSide, more than max_pixels (kLimitExceeded), and
// what admit() refuses.
// Memory while it decodes: see gltf/limits.h. Error::element is empty. Thread-safe.
Result<ImageDescription> decode_image(std::span<const std::uint8_t> bytes, const ImageRoom& room);

}  // namespace palpate
