#pragma once

// Vertex attributes of a primitive, stored in its compressed stream or outside it.

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

// The accessor of an attribute. Returns an error if the attribute is absent or if its length
// differs from that of the positions. element: JSON path of the primitive. wanted_by: the reason
// why the attribute is needed, for the message: "a node gives the mesh a skin".
Result<std::size_t> attribute_accessor(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                       const DracoPrimitive* compressed, const std::string& element,
                                       const std::string& name, std::size_t vertex_count,
                                       const char* wanted_by);

// The components of the attribute, vertex by vertex. All values are finite. Returns an error if the
// attribute has another format. compressed: null if the primitive is not compressed. As in
// read_numbers(), kMaxGltfUnstored does not count zeros that the file does not store.
Result<std::vector<double>> attribute_numbers(const GltfAsset& asset,
                                              const DracoPrimitive* compressed,
                                              const std::string& name, std::size_t accessor,
                                              const GltfNumberFormat& format,
                                              std::size_t vertex_count);

// The texture coordinates of the vertices of a primitive in a map, as fractions of the map's width
// from the left and of its height from the top. They are read from the attribute TEXCOORD_n; the
// map selects the number n. KHR_texture_transform is applied to them. All values are finite. The
// attribute contains floats or normalised unsigned integers or, with KHR_mesh_quantization, any
// integers of 8 or 16 bits. Displacements by morph targets are not applied. Returns an error if the
// primitive lacks the attribute. Thread-safe.
Result<std::vector<std::array<double, 2>>> read_texture_coordinates(
    const GltfAsset& asset, const tinygltf::Primitive& primitive, const DracoPrimitive* compressed,
    const std::string& element, const TextureReference& map, std::size_t vertex_count);

}  // namespace palpate
