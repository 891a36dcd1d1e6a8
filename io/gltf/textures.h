#pragma once

// References to textures (textureInfo of glTF 2.0, section 5.30), with the texture's sampler and
// KHR_texture_transform.

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/material_description.h"

namespace palpate {

// Reads a textureInfo of an asset; element is its JSON path. Returns an error unless it refers to a
// texture. If the texture has a source, this source must refer to an image. Texture and image must
// be objects. The content of the image is not read. TextureReference::scale and pixels keep their
// defaults. Thread-safe.
Result<TextureReference> read_texture_reference(const nlohmann::json& root,
                                                const nlohmann::json& info,
                                                const std::string& element);

}  // namespace palpate
