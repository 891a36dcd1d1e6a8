#pragma once

// One small asset for each thing that the reader knows: where fuzzing begins.

#include <string>
#include <vector>

namespace palpate::test {

struct GltfSeed {
  std::string name;   // of a file
  std::string bytes;  // its content: nothing else is needed to read it
};

// All of them are valid: hostile_gltf_test reads each.
std::vector<GltfSeed> gltf_seeds();

}  // namespace palpate::test
