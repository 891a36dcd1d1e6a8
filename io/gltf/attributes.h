#pragma once

// Attributes of the vertices of a primitive, whether its compressed stream holds them or not.

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/draco.h"
#include "io/material_description.h"

namespace tinygltf {
struct Primitive;
}

namespace palpate {

// The accessor of an attribute; fails if it is not there or not as long as the positions. element:
// of the primitive. wanted_by: what needs it, for the message: "a node gives the mesh a skin".
Result<std::size_t> attribute_accessor(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                       const DracoPrimitive* compressed, const std::string& element,
                                       const std::string& name, std::size_t vertex_count,
                                       const char* wanted_by);

// The components of the attribute, vertex by vertex. All finite. Fails if it is of another format.
// compressed: null if the primitive is not. Like read_numbers(), it counts no zeros.
Result<std::vector<double>> attribute_numbers(const GltfAsset& asset,
                                              const DracoPrimitive* compressed,
                                              const std::string& name, std::size_t accessor,
                                              const GltfNumberFormat& format,
                                              std::size_t vertex_count);

// Where the vertices of a primitive lie in a map, in fractions of its width from the left and its
// height from the top: TEXCOORD_n, as the map chooses n, with KHR_texture_transform applied. All
// finite. Floats, or normalised unsigned integers; with KHR_mesh_quantization any integers of 8 or
// 16 bits. Displacements by morph targets are not applied. Fails if the primitive has no such
// attribute. Thread-safe.
Result<std::vector<std::array<double, 2>>> read_texture_coordinates(
    const GltfAsset& asset, const tinygltf::Primitive& primitive, const DracoPrimitive* compressed,
    const std::string& element, const TextureReference& map, std::size_t vertex_count);

}  // namespace palpate
