#include "io/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include "geometry/base/parallel.h"
#include "io/gltf/error.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kWorthAThread = 100000;  // elements: a millisecond of work

// Elements of equal size at equal distances. All of them lie within `first`.
struct ElementRange {
  Bytes first;  // begins at the first byte of element 0
  std::size_t stride = 0;
  std::size_t count = 0;
};

// The components of one element of an accessor.
struct ElementLayout {
  int component_type = 0;  // TINYGLTF_COMPONENT_TYPE_...
  std::size_t components = 1;
  bool normalized = false;

  std::size_t bytes() const {
    return components * static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(
                            static_cast<std::uint32_t>(component_type)));
  }
};

std::string name_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return "signed 8-bit integers";
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return "unsigned 8-bit integers";
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return "signed 16-bit integers";
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return "unsigned 16-bit integers";
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return "unsigned 32-bit integers";
    default:
      return "32-bit floats";
  }
}

struct ViewContent {
  Bytes bytes;
  std::size_t encoded_stride = 0;  // distance of the elements that a codec wrote; 0: no codec
};

// The content of a buffer view, decoded if it is compressed.
Result<ViewContent> view_content(const GltfAsset& asset, std::size_t view_id) {
  const auto decoded = asset.compressed_views.decoded(view_id);
  if (!decoded) return decoded.error();
  if (*decoded != nullptr) return ViewContent{(*decoded)->bytes, (*decoded)->stride};
  const tinygltf::BufferView& view = asset.model.bufferViews[view_id];
  const auto bytes = asset.buffers.part(static_cast<std::size_t>(view.buffer), view.byteOffset,
                                        view.byteLength, gltf_element("bufferViews", view_id));
  if (!bytes) return bytes.error();
  return ViewContent{*bytes};
}

// count elements of element_bytes each, from byte_offset of the view on. count and element_bytes
// are at least 1. element: for messages.
Result<ElementRange> range_in_view(const GltfAsset& asset, std::size_t view_id,
                                   std::size_t byte_offset, std::size_t count,
                                   std::size_t element_bytes, const std::string& element) {
  const auto content = view_content(asset, view_id);
  if (!content) return content.error();
  const Bytes view = content->bytes;
  const std::size_t declared_stride = asset.model.bufferViews[view_id].byteStride;
  const std::size_t stride = declared_stride == 0 ? element_bytes : declared_stride;
  // A codec writes whole elements; read at another stride they would be meaningless.
  if (content->encoded_stride != 0 && content->encoded_stride != stride) {
    return gltf_invalid(element, "has elements " + std::to_string(stride) +
                                     " bytes apart, but the compressed bufferView " +
                                     std::to_string(view_id) + " holds some of " +
                                     std::to_string(content->encoded_stride) + " bytes");
  }
  if (stride < element_bytes) {
    return gltf_invalid(gltf_element("bufferViews", view_id, "byteStride"),
                        "is " + std::to_string(stride) + ", but an element of " + element +
                            " has " + std::to_string(element_bytes) + " bytes");
  }
  // Only divisions and differences are used, because sums and products may overflow.
  const bool fits = byte_offset <= view.size() && element_bytes <= view.size() - byte_offset &&
                    count - 1 <= (view.size() - byte_offset - element_bytes) / stride;
  if (!fits) {
    return gltf_invalid(
        element, std::to_string(count) + " elements of " + std::to_string(element_bytes) +
                     " bytes at stride " + std::to_string(stride) + " from byteOffset " +
                     std::to_string(byte_offset) + " reach beyond bufferView " +
                     std::to_string(view_id) + " of " + std::to_string(view.size()) + " bytes");
  }
  if (content->encoded_stride == 0) {
    const tinygltf::BufferView& stored = asset.model.bufferViews[view_id];
    asset.buffers.note_mesh_data(static_cast<std::size_t>(stored.buffer),
                                 stored.byteOffset + byte_offset,
                                 (count - 1) * stride + element_bytes, false);
  }
  return ElementRange{view.subspan(byte_offset), stride, count};
}

// Sections 3.7.2.1 and 3.6.2.3: indices are tightly packed. Readers treat a stride differently, so
// the triangles of such a file are ambiguous.
std::optional<Error> check_no_stride(const GltfAsset& asset, int view_id) {
  const auto view = static_cast<std::size_t>(view_id);
  if (asset.model.bufferViews[view].byteStride == 0) return std::nullopt;
  return gltf_invalid(gltf_element("bufferViews", view, "byteStride"),
                      "is present; indices must not have it");
}

template <typename Component, typename Out>
Out decoded(Component stored, bool normalized) {
  if constexpr (std::is_integral_v<Component> && std::is_floating_point_v<Out>) {
    // Section 3.6.2.2: c / max, and for signed types not below -1.
    constexpr Out kLargest = std::numeric_limits<Component>::max();
    if (normalized) return std::max(static_cast<Out>(stored) / kLargest, Out{-1});
  }
  return static_cast<Out>(stored);
}

// Element i of the range goes to element target(i) of out.
template <typename Component, typename Out, typename Target>
void decode_as(const ElementRange& range, const ElementLayout& layout, const Target& target,
               Out* out) {
  for (std::size_t i = 0; i < range.count; ++i) {
    const std::uint8_t* element = range.first.data() + i * range.stride;
    Out* destination = out + target(i) * layout.components;
    for (std::size_t c = 0; c < layout.components; ++c) {
      Component stored;
      std::memcpy(&stored, element + c * sizeof stored, sizeof stored);
      destination[c] = decoded<Component, Out>(stored, layout.normalized);
    }
  }
}

template <typename Out, typename Target>
void decode(const ElementRange& range, const ElementLayout& layout, const Target& target,
            Out* out) {
  switch (layout.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return decode_as<std::int8_t>(range, layout, target, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return decode_as<std::uint8_t>(range, layout, target, out);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return decode_as<std::int16_t>(range, layout, target, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return decode_as<std::uint16_t>(range, layout, target, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return decode_as<std::uint32_t>(range, layout, target, out);
    default:
      // Indices are decoded to integers and are never floats, whose conversion could overflow.
      if constexpr (std::is_floating_point_v<Out>) decode_as<float>(range, layout, target, out);
  }
}

bool is_index_type(int component_type) {
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// The indices of the replaced elements among the wanted ones. The indices increase, so that later
// ones need not be read.
Result<std::vector<std::uint32_t>> sparse_targets(const GltfAsset& asset,
                                                  const tinygltf::Accessor& accessor,
                                                  const std::string& element, std::size_t wanted) {
  const auto& sparse = accessor.sparse;
  const ElementLayout layout{sparse.indices.componentType, 1, false};
  if (!is_index_type(layout.component_type)) {
    return gltf_invalid(
        element + "/sparse/indices/componentType",
        "denotes " + name_of(layout.component_type) + "; expected unsigned integers");
  }
  if (auto error = check_no_stride(asset, sparse.indices.bufferView)) return *error;
  auto range = range_in_view(asset, static_cast<std::size_t>(sparse.indices.bufferView),
                             static_cast<std::size_t>(sparse.indices.byteOffset),
                             static_cast<std::size_t>(sparse.count), layout.bytes(),
                             element + "/sparse/indices");
  if (!range) return range.error();
  range->count = std::min(range->count, wanted);
  std::vector<std::uint32_t> targets(range->count);
  decode(
      *range, layout, [](std::size_t i) { return i; }, targets.data());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] >= accessor.count || (i > 0 && targets[i] <= targets[i - 1])) {
      return gltf_invalid(element + "/sparse/indices",
                          "element " + std::to_string(i) + " is " + std::to_string(targets[i]) +
                              "; expected rising values below " + std::to_string(accessor.count));
    }
  }
  targets.erase(std::lower_bound(targets.begin(), targets.end(), wanted), targets.end());
  return targets;
}

template <typename Out>
std::optional<Error> apply_sparse(const GltfAsset& asset, const tinygltf::Accessor& accessor,
                                  const ElementLayout& layout, const std::string& element,
                                  std::size_t wanted, Out* out) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 1 || static_cast<std::size_t>(sparse.count) > accessor.count) {
    return gltf_invalid(element + "/sparse/count",
                        "is " + std::to_string(sparse.count) + "; expected 1 to " +
                            std::to_string(accessor.count) + ", the count of the accessor");
  }
  const auto targets = sparse_targets(asset, accessor, element, wanted);
  if (!targets) return targets.error();
  auto values = range_in_view(asset, static_cast<std::size_t>(sparse.values.bufferView),
                              static_cast<std::size_t>(sparse.values.byteOffset),
                              static_cast<std::size_t>(sparse.count), layout.bytes(),
                              element + "/sparse/values");
  if (!values) return values.error();
  values->count = targets->size();
  decode(
      *values, layout, [&](std::size_t i) { return (*targets)[i]; }, out);
  return std::nullopt;
}

ElementLayout layout_of(const tinygltf::Accessor& accessor) {
  return {accessor.componentType,
          static_cast<std::size_t>(
              tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type))),
          accessor.normalized};
}

// All elements of an accessor that has a buffer view and is not empty.
Result<ElementRange> base_range(const GltfAsset& asset, std::size_t accessor_id) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  return range_in_view(asset, static_cast<std::size_t>(accessor.bufferView), accessor.byteOffset,
                       accessor.count, layout_of(accessor).bytes(),
                       gltf_element("accessors", accessor_id));
}

// Checks the data of all elements and writes the first of them to out. out: zeros, as many as the
// wanted elements have components.
template <typename Out>
std::optional<Error> decode_accessor(const GltfAsset& asset, std::size_t accessor_id,
                                     std::size_t wanted, Out* out) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  const ElementLayout layout = layout_of(accessor);
  if (accessor.bufferView >= 0) {
    auto range = base_range(asset, accessor_id);
    if (!range) return range.error();
    run_ranges(wanted, kWorthAThread, [&](std::size_t begin, std::size_t end) {
      decode(
          ElementRange{range->first.subspan(begin * range->stride), range->stride, end - begin},
          layout, [](std::size_t i) { return i; }, out + begin * layout.components);
    });
  }
  if (!accessor.sparse.isSparse) return std::nullopt;
  return apply_sparse(asset, accessor, layout, gltf_element("accessors", accessor_id), wanted, out);
}

// The checks common to all accessors. They must precede any allocation by sizes of the file.
std::optional<Error> check_data_and_count(const GltfAsset& asset, std::size_t accessor_id,
                                          std::size_t max_count) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (accessor.bufferView < 0 && !accessor.sparse.isSparse) {
    return gltf_error(ErrorCode::kUnsupported, gltf_element("accessors", accessor_id),
                      "has neither bufferView nor sparse, so no data",
                      "only the accessors of a compressed primitive may lack both");
  }
  if (accessor.count == 0) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "count"),
                        "is 0; expected 1 or more");
  }
  if (accessor.count > max_count) {
    return gltf_error(ErrorCode::kLimitExceeded, gltf_element("accessors", accessor_id, "count"),
                      "is " + std::to_string(accessor.count) + "; at most " +
                          std::to_string(max_count) + " can still be read");
  }
  if (accessor.bufferView < 0) return std::nullopt;
  const auto range = base_range(asset, accessor_id);
  return range ? std::nullopt : std::optional<Error>(range.error());
}

// An accessor of zeros with sparse values may have any size in a tiny file.
std::optional<Error> check_unstored(const GltfAsset& asset, const tinygltf::Accessor& accessor,
                                    std::size_t accessor_id) {
  if (accessor.bufferView >= 0 || asset.buffers.take_unstored(accessor.count)) return std::nullopt;
  return gltf_error(ErrorCode::kLimitExceeded, gltf_element("accessors", accessor_id, "count"),
                    "raises the number of elements without a bufferView to more than " +
                        std::to_string(kMaxGltfUnstored) + ", the limit",
                    "store the zeros as well");
}

// The kind of the components of an accessor; 0 if GltfNumberFormat has no such kind.
unsigned kind_of_components(const tinygltf::Accessor& accessor) {
  switch (accessor.componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return accessor.normalized ? kGltfNormalizedSigned : kGltfSigned;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return accessor.normalized ? kGltfNormalizedUnsigned : kGltfUnsigned;
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return accessor.normalized ? 0 : kGltfFloats;
    default:
      return 0;
  }
}

int type_named(const std::string& name) {
  if (name == "SCALAR") return TINYGLTF_TYPE_SCALAR;
  if (name == "VEC2") return TINYGLTF_TYPE_VEC2;
  if (name == "VEC3") return TINYGLTF_TYPE_VEC3;
  return name == "VEC4" ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_MAT4;
}

}  // namespace

Result<std::span<const std::uint8_t>> view_bytes(const GltfAsset& asset, std::size_t view_id) {
  const auto content = view_content(asset, view_id);
  if (!content) return content.error();
  return content->bytes;
}

std::optional<Error> check_position_type(const GltfAsset& asset, std::size_t accessor_id) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (accessor.type != TINYGLTF_TYPE_VEC3) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "type"),
                        "is not VEC3, as positions must be");
  }
  const int type = accessor.componentType;
  if (type == TINYGLTF_COMPONENT_TYPE_FLOAT) {
    if (!accessor.normalized) return std::nullopt;
    return gltf_invalid(gltf_element("accessors", accessor_id, "normalized"),
                        "is true for floats; expected integers");
  }
  if (asset.mesh_quantization && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) return std::nullopt;
  return gltf_invalid(gltf_element("accessors", accessor_id, "componentType"),
                      "denotes " + name_of(type) + "; expected 32-bit floats for positions",
                      asset.mesh_quantization
                          ? "KHR_mesh_quantization allows 8-bit and 16-bit integers"
                          : "integers need KHR_mesh_quantization in extensionsUsed");
}

std::optional<Error> check_index_type(const GltfAsset& asset, std::size_t accessor_id) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (accessor.type != TINYGLTF_TYPE_SCALAR) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "type"),
                        "is not SCALAR, as indices must be");
  }
  if (!is_index_type(accessor.componentType)) {
    return gltf_invalid(
        gltf_element("accessors", accessor_id, "componentType"),
        "denotes " + name_of(accessor.componentType) + "; expected unsigned integers");
  }
  if (accessor.normalized) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "normalized"),
                        "is true; expected false for indices");
  }
  return std::nullopt;
}

std::optional<Error> check_number_format(const GltfAsset& asset, std::size_t accessor_id,
                                         const GltfNumberFormat& format) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (accessor.type != type_named(format.type)) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "type"),
                        std::string("is not ") + format.type + ", as " + format.what + " must be");
  }
  if ((kind_of_components(accessor) & format.components) != 0) return std::nullopt;
  std::string expected;
  for (const auto& [kind, name] :
       {std::pair(kGltfFloats, "32-bit floats"),
        std::pair(kGltfNormalizedSigned, "normalised signed"),
        std::pair(kGltfNormalizedUnsigned, "normalised unsigned"), std::pair(kGltfSigned, "signed"),
        std::pair(kGltfUnsigned, "unsigned")}) {
    if ((format.components & kind) == 0) continue;
    expected += std::string(expected.empty() ? "" : " or ") + name;
    if (kind != kGltfFloats) expected += " integers of 8 or 16 bits";
  }
  return gltf_invalid(gltf_element("accessors", accessor_id, "componentType"),
                      "denotes " + name_of(accessor.componentType) +
                          (accessor.normalized ? ", normalised" : "") + "; expected " + expected +
                          " for " + format.what);
}

void append_components(const tinygltf::Accessor& accessor, const std::uint8_t* element,
                       std::vector<double>& values) {
  const ElementLayout layout = layout_of(accessor);
  values.resize(values.size() + layout.components);
  decode(
      ElementRange{Bytes(element, layout.bytes()), layout.bytes(), 1}, layout,
      [](std::size_t i) { return i; }, values.data() + values.size() - layout.components);
}

Result<std::vector<Vec3>> read_positions(const GltfAsset& asset, std::size_t accessor_id,
                                         std::size_t max_count) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (auto error = check_position_type(asset, accessor_id)) return *error;
  if (auto error = check_data_and_count(asset, accessor_id, max_count)) return *error;
  if (auto error = check_unstored(asset, accessor, accessor_id)) return *error;
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const std::uint64_t bytes = sizeof(Vec3) * std::uint64_t{accessor.count};
  if (auto error =
          asset.buffers.take_memory({bytes, bytes}, gltf_element("accessors", accessor_id))) {
    return *error;
  }
  std::vector<Vec3> positions(accessor.count);  // uninitialised
  if (accessor.bufferView < 0) std::fill(positions.begin(), positions.end(), Vec3::Zero());
  if (auto error =
          decode_accessor(asset, accessor_id, positions.size(), positions.front().data())) {
    return *error;
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!positions[i].allFinite()) {
      return gltf_invalid(gltf_element("accessors", accessor_id),
                          "position " + std::to_string(i) + " is not finite");
    }
  }
  return positions;
}

Result<std::vector<double>> read_numbers(const GltfAsset& asset, std::size_t accessor_id,
                                         const GltfNumberFormat& format, std::size_t count) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (auto error = check_number_format(asset, accessor_id, format)) return *error;
  if (auto error = check_data_and_count(asset, accessor_id, accessor.count)) return *error;
  if (accessor.count < count) {
    return gltf_invalid(gltf_element("accessors", accessor_id, "count"),
                        "is " + std::to_string(accessor.count) + "; expected " +
                            std::to_string(count) + " " + format.what);
  }
  const std::size_t components = layout_of(accessor).components;
  if (auto error = asset.buffers.take_memory({0, sizeof(double) * components * count},
                                             gltf_element("accessors", accessor_id))) {
    return *error;
  }
  std::vector<double> numbers(count * components);
  if (auto error = decode_accessor(asset, accessor_id, count, numbers.data())) return *error;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i])) {
      return gltf_invalid(gltf_element("accessors", accessor_id),
                          "element " + std::to_string(i / components) + " is not finite");
    }
  }
  return numbers;
}

std::uint32_t restart_index(const GltfAsset& asset, std::size_t accessor_id) {
  const int component_type = asset.model.accessors[accessor_id].componentType;
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return 0xffu;
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 0xffffu : 0xffffffffu;
}

Result<std::size_t> index_count(const GltfAsset& asset, std::size_t accessor_id,
                                std::size_t max_count) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (auto error = check_index_type(asset, accessor_id)) return *error;
  if (accessor.bufferView >= 0) {
    if (auto error = check_no_stride(asset, accessor.bufferView)) return *error;
  }
  if (auto error = check_data_and_count(asset, accessor_id, max_count)) return *error;
  if (auto error = check_unstored(asset, accessor, accessor_id)) return *error;
  const std::uint64_t bytes = sizeof(std::uint32_t) * std::uint64_t{accessor.count};
  if (auto error =
          asset.buffers.take_memory({bytes, bytes}, gltf_element("accessors", accessor_id))) {
    return *error;
  }
  return accessor.count;
}

std::optional<Error> read_indices(const GltfAsset& asset, std::size_t accessor_id,
                                  std::span<std::uint32_t> indices) {
  return decode_accessor(asset, accessor_id, indices.size(), indices.data());
}

}  // namespace palpate
