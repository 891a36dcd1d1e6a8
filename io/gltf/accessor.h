#pragma once

// Decoding of accessors (glTF 2.0, section 3.6.2): base view and stride, sparse values with or
// without a base view, all component types, normalised integers. Only the data are used. Real files
// have errors in min, max and offsets; therefore, min and max are ignored, and offsets need not be
// multiples of the component size.

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

// The asset that is being read. The ids in the model are within range (see gltf/schema.h); sizes
// and offsets are unchecked.
struct GltfAsset {
  const tinygltf::Model& model;
  const nlohmann::json& json;  // the whole JSON; only the parts in the model are checked
  GltfBuffers& buffers;
  GltfMeshoptViews& compressed_views;
  bool mesh_quantization = false;  // integer positions are allowed
};

// The bytes of a buffer view, decoded if the view is compressed. Valid for the lifetime of the
// asset.
Result<std::span<const std::uint8_t>> view_bytes(const GltfAsset& asset, std::size_t view);

// check_position_type() returns an error if the accessor does not declare a type that positions can
// have; check_index_type() does the same for indices.
std::optional<Error> check_position_type(const GltfAsset& asset, std::size_t accessor);
std::optional<Error> check_index_type(const GltfAsset& asset, std::size_t accessor);

// Appends the values of the components of one element. element: the bytes of an element of the
// accessor's type, from any memory and without alignment.
void append_components(const tinygltf::Accessor& accessor, const std::uint8_t* element,
                       std::vector<double>& values);

// The elements of a VEC3 accessor. They are stored as 32-bit floats or, if integers are allowed, as
// integers, which are converted to the values that they represent. All values are finite. Returns
// an error if the accessor has no element or more than max_count elements (kLimitExceeded); this
// condition is checked before any allocation.
Result<std::vector<Vec3>> read_positions(const GltfAsset& asset, std::size_t accessor,
                                         std::size_t max_count);

// The kinds of components that an accessor may have, in any combination.
inline constexpr unsigned kGltfFloats = 1;
inline constexpr unsigned kGltfNormalizedSigned = 2;    // of 8 or 16 bits
inline constexpr unsigned kGltfNormalizedUnsigned = 4;  // of 8 or 16 bits
inline constexpr unsigned kGltfSigned = 8;              // of 8 or 16 bits, not normalised
inline constexpr unsigned kGltfUnsigned = 16;           // of 8 or 16 bits, not normalised

struct GltfNumberFormat {
  const char* type;     // "SCALAR", "VEC2", "VEC3", "VEC4" or "MAT4"
  unsigned components;  // the allowed kinds, a combination of the above
  const char* what;     // for messages: "weights of a skin"
};

// Returns an error if the accessor has another format.
std::optional<Error> check_number_format(const GltfAsset& asset, std::size_t accessor,
                                         const GltfNumberFormat& format);

// The components of the first `count` elements of an accessor, element by element. The components
// of a matrix are in the order of its columns. All values are finite. Returns an error if the
// accessor has fewer elements or another format. All elements of the accessor must lie in the
// buffer, but only the first `count` elements cost time and memory. If the accessor has no base
// view, its elements may be zeros. The file does not store such zeros, and kMaxGltfUnstored does
// not count them. The caller must therefore bound `count` by data that the file does store.
Result<std::vector<double>> read_numbers(const GltfAsset& asset, std::size_t accessor,
                                         const GltfNumberFormat& format, std::size_t count);

// The number of elements of an accessor. Returns an error if the elements are not unsigned integer
// scalars, if they are normalised, or if there are more than max_count elements.
Result<std::size_t> index_count(const GltfAsset& asset, std::size_t accessor,
                                std::size_t max_count);

// Reads all indices of the accessor.
std::optional<Error> read_indices(const GltfAsset& asset, std::size_t accessor,
                                  std::span<std::uint32_t> indices);

// The index that glTF reserves for primitive restart. It is the largest value of the accessor's
// type: 255, 65535 or 4294967295.
std::uint32_t restart_index(const GltfAsset& asset, std::size_t accessor);

}  // namespace palpate
