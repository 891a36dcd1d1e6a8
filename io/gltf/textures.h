#pragma once

// References to textures, glTF 2.0, section 5.30 (textureInfo), with its sampler and
// KHR_texture_transform.

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/material_description.h"

namespace palpate {

// What a textureInfo of an asset says; element is its JSON path. An error unless it leads to a
// texture, and from there, where the texture has a source, to an image, both of them objects. The
// content of the image is not looked at. TextureReference::scale and pixels are left as they are.
// Thread-safe.
Result<TextureReference> read_texture_reference(const nlohmann::json& root,
                                                const nlohmann::json& info,
                                                const std::string& element);

}  // namespace palpate
