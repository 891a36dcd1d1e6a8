#pragma once

// Seeds with compressed data, as in gltf_seeds.h. They need the encoders of Draco and
// meshoptimizer.

#include <vector>

#include "tests/helpers/gltf_seeds.h"

namespace palpate::test {

std::vector<GltfSeed> compressed_gltf_seeds();

}  // namespace palpate::test
