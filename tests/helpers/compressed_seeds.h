#pragma once

// As gltf_seeds.h, for what is compressed: these need the encoders of Draco and meshoptimizer.

#include <vector>

#include "tests/helpers/gltf_seeds.h"

namespace palpate::test {

std::vector<GltfSeed> compressed_gltf_seeds();

}  // namespace palpate::test
