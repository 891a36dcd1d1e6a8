#pragma once

// One small asset for each feature of the reader. Fuzzing starts from these seeds.

#include <string>
#include <vector>

namespace palpate::test {

struct GltfSeed {
  std::string name;   // file name
  std::string bytes;  // the file's content; no other file is needed
};

// All seeds are valid assets: hostile_gltf_test reads each of them.
std::vector<GltfSeed> gltf_seeds();

}  // namespace palpate::test
