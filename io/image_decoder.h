#pragma once

// Encoded images to numbers. PNG is decoded by libspng, JPEG by the TurboJPEG interface of
// libjpeg-turbo: both are made for data from anywhere, and neither jumps over C++ code.

#include <cstdint>
#include <span>

#include "geometry/result.h"
#include "io/material_description.h"

namespace palpate {

// The pixels of a PNG or JPEG, told apart by its content. Grey becomes red, green and blue; what is
// transparent is taken as if it were not; gamma and colour profiles are not applied: the numbers
// are those of the file. Refused: what is cut short or damaged, and, before anything is allocated
// by them, a width or height beyond kMaxGltfImageSide or more than max_pixels (kLimitExceeded).
// Memory while it decodes: see gltf_limits.h. Error::element is empty. Thread-safe.
Result<ImageDescription> decode_image(std::span<const std::uint8_t> bytes,
                                      std::uint64_t max_pixels);

}  // namespace palpate
