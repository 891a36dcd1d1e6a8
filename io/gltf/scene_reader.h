#pragma once

// Builds the description of a scene from an asset whose JSON has been checked.

#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/reader.h"
#include "io/scene_description.h"

namespace palpate {

// As read_gltf(), but without the path, the time and the files read. of_text: warnings about the
// form of the file. of_extensions: warnings about unsupported extensions. May throw.
Result<SceneDescription> read_scene(const GltfAsset& asset, const ReadOptions& options,
                                    std::vector<std::string> of_text,
                                    const std::vector<std::string>& of_extensions);

}  // namespace palpate
