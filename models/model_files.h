#pragma once

// Generates the model files of this folder.

#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

struct ModelFile {
  std::string file_name;  // "star.glb"
  std::string bytes;
};

// All .glb files of models/, as described in models/MODELS.md. Deterministic: the same bytes on
// every run and platform. Not for the haptic thread. Thread-safe.
Result<std::vector<ModelFile>> model_files();

}  // namespace palpate
