#pragma once

// The model files of this folder, made from code.

#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

struct ModelFile {
  std::string file_name;  // "star.glb"
  std::string bytes;
};

// Every .glb of models/, as models/README.md describes them. Deterministic: the same bytes on every
// run and platform. Not for the haptic thread. Thread-safe.
Result<std::vector<ModelFile>> model_files();

}  // namespace palpate
