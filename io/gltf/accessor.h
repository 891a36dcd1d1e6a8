#pragma once

// Decoding of accessors (glTF 2.0, section 3.6.2): base view and stride, sparse values with or
// without a base view, all component types, normalised integers. The data are what counts: min and
// max are not looked at, and offsets need not be multiples of the component size, because real
// files have both wrong.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/gltf/buffers.h"
#include "io/gltf/meshopt.h"

namespace tinygltf {
struct Accessor;
class Model;
}  // namespace tinygltf

namespace palpate {

// One asset while it is read. The ids in the model are within range (see gltf/schema.h); sizes and
// offsets are not to be trusted.
struct GltfAsset {
  const tinygltf::Model& model;
  const nlohmann::json& json;  // the whole of it: checked as far as the model goes, no farther
  GltfBuffers& buffers;
  GltfMeshoptViews& compressed_views;
  bool mesh_quantization = false;  // integer positions are allowed
};

// The bytes of a buffer view, decoded if the view is compressed. Valid as long as the asset.
Result<std::span<const std::uint8_t>> view_bytes(const GltfAsset& asset, std::size_t view);

// The error if an accessor does not declare the type of positions, or of indices.
std::optional<Error> check_position_type(const GltfAsset& asset, std::size_t accessor);
std::optional<Error> check_index_type(const GltfAsset& asset, std::size_t accessor);

// Appends what the components of one element stand for. element: as many bytes as the accessor
// declares, which need not be its own; no alignment.
void append_components(const tinygltf::Accessor& accessor, const std::uint8_t* element,
                       std::vector<double>& values);

// The elements of a VEC3 accessor: 32-bit floats, or, if integers are allowed, the values that
// these stand for. All finite. Fails if it has more than max_count elements (kLimitExceeded) or
// none, before anything is allocated.
Result<std::vector<Vec3>> read_positions(const GltfAsset& asset, std::size_t accessor,
                                         std::size_t max_count);

// What the components of an accessor may be, in any combination.
inline constexpr unsigned kGltfFloats = 1;
inline constexpr unsigned kGltfNormalizedSigned = 2;    // of 8 or 16 bits
inline constexpr unsigned kGltfNormalizedUnsigned = 4;  // of 8 or 16 bits
inline constexpr unsigned kGltfSigned = 8;              // of 8 or 16 bits, not normalised
inline constexpr unsigned kGltfUnsigned = 16;           // of 8 or 16 bits, not normalised

struct GltfNumberFormat {
  const char* type;     // "SCALAR", "VEC2", "VEC3", "VEC4" or "MAT4"
  unsigned components;  // those of the kinds above that are allowed
  const char* what;     // for messages: "weights of a skin"
};

// The error if the accessor is of another format.
std::optional<Error> check_number_format(const GltfAsset& asset, std::size_t accessor,
                                         const GltfNumberFormat& format);

// The first count elements of an accessor, component by component, matrices by columns. All finite.
// Fails if the accessor has fewer of them or is of another format. All elements of the accessor
// must lie in the buffer, but time and memory are taken for count elements alone. Without a base
// view these may be zeros that the file does not hold and kMaxGltfUnstored does not count: the
// caller must have bounded them by what it has.
Result<std::vector<double>> read_numbers(const GltfAsset& asset, std::size_t accessor,
                                         const GltfNumberFormat& format, std::size_t count);

// How many elements an accessor has: unsigned integer scalars, not normalised.
Result<std::size_t> index_count(const GltfAsset& asset, std::size_t accessor,
                                std::size_t max_count);

// All of them.
std::optional<Error> read_indices(const GltfAsset& asset, std::size_t accessor,
                                  std::span<std::uint32_t> indices);

// The index that glTF reserves for primitive restart: the largest of the type, 255, 65535 or
// 4294967295.
std::uint32_t restart_index(const GltfAsset& asset, std::size_t accessor);

}  // namespace palpate
