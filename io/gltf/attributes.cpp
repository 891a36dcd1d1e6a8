#include "io/gltf/attributes.h"

#include <cmath>
#include <utility>

#include "io/gltf/error.h"
#include "io/gltf/tinygltf.h"

namespace palpate {

Result<std::size_t> attribute_accessor(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                       const DracoPrimitive* compressed, const std::string& element,
                                       const std::string& name, std::size_t vertex_count,
                                       const char* wanted_by) {
  const std::string path = element + "/attributes/" + name;
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) {
    return gltf_invalid(path, std::string("is missing, but ") + wanted_by);
  }
  const auto accessor = static_cast<std::size_t>(found->second);
  const std::size_t count = asset.model.accessors[accessor].count;
  const bool is_compressed =
      compressed && compressed->has(name);  // has the same length as the others then
  if (!is_compressed && count != vertex_count) {
    return gltf_invalid(path, "accessor " + std::to_string(accessor) + " has " +
                                  std::to_string(count) + " elements, but the primitive has " +
                                  std::to_string(vertex_count) + " vertices");
  }
  return accessor;
}

Result<std::vector<double>> attribute_numbers(const GltfAsset& asset,
                                              const DracoPrimitive* compressed,
                                              const std::string& name, std::size_t accessor,
                                              const GltfNumberFormat& format,
                                              std::size_t vertex_count) {
  if (!compressed || !compressed->has(name)) {
    return read_numbers(asset, accessor, format, vertex_count);
  }
  if (auto error = check_number_format(asset, accessor, format)) return *error;
  auto attribute = compressed->attribute(name);
  if (!attribute) return attribute.error();
  for (std::size_t i = 0; i < attribute->values.size(); ++i) {
    if (!std::isfinite(attribute->values[i])) {
      return gltf_invalid(
          gltf_element("accessors", accessor),
          "element " + std::to_string(i / attribute->components) + " is not finite");
    }
  }
  return std::move(attribute->values);
}

Result<std::vector<std::array<double, 2>>> read_texture_coordinates(
    const GltfAsset& asset, const tinygltf::Primitive& primitive, const DracoPrimitive* compressed,
    const std::string& element, const TextureReference& map, std::size_t vertex_count) {
  constexpr unsigned kAlways = kGltfFloats | kGltfNormalizedUnsigned;
  constexpr unsigned kQuantized = kAlways | kGltfNormalizedSigned | kGltfSigned | kGltfUnsigned;
  const GltfNumberFormat format{"VEC2", asset.mesh_quantization ? kQuantized : kAlways,
                                "texture coordinates"};
  const std::string name = "TEXCOORD_" + std::to_string(map.tex_coord);
  const auto accessor = attribute_accessor(asset, primitive, compressed, element, name,
                                           vertex_count, "a texture map requires it");
  if (!accessor) return accessor.error();
  const auto numbers = attribute_numbers(asset, compressed, name, *accessor, format, vertex_count);
  if (!numbers) return numbers.error();
  // The matrix of KHR_texture_transform, translation * rotation * scale, rotates from v towards u
  // for a positive angle: counter-clockwise if v points down.
  const double c = std::cos(map.uv_rotation_rad);
  const double s = std::sin(map.uv_rotation_rad);
  std::vector<std::array<double, 2>> coordinates(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const double u = map.uv_scale[0] * (*numbers)[2 * i];
    const double v = map.uv_scale[1] * (*numbers)[2 * i + 1];
    coordinates[i] = {map.uv_offset[0] + c * u + s * v, map.uv_offset[1] - s * u + c * v};
    if (!std::isfinite(coordinates[i][0]) || !std::isfinite(coordinates[i][1])) {
      return gltf_invalid(element + "/attributes/" + name,
                          "element " + std::to_string(i) + ", transformed for its map, overflows");
    }
  }
  return coordinates;
}

}  // namespace palpate
