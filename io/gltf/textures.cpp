#include "io/gltf/textures.h"

#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

std::size_t section_size(const Json& root, const char* name) {
  const auto section = root.find(name);
  return section == root.end() || !section->is_array() ? 0 : section->size();
}

MaybeError read_tex_coord(const Json& object, const std::string& element, std::uint32_t& value) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
  const auto found = object.find("texCoord");
  if (found == object.end()) return std::nullopt;
  const auto number = whole_number(*found);
  if (!number || *number > kMax) {
    return gltf_expected(element + "/texCoord", *found,
                         "a whole number from 0 to " + std::to_string(kMax));
  }
  value = static_cast<std::uint32_t>(*number);
  return std::nullopt;
}

MaybeError read_pair(const Json& object, const std::string& element, const char* name,
                     std::array<double, 2>& pair) {
  const auto found = object.find(name);
  if (found == object.end()) return std::nullopt;
  if (!found->is_array() || found->size() != 2 || !(*found)[0].is_number() ||
      !(*found)[1].is_number()) {
    return gltf_expected(element + "/" + name, *found, "two numbers");
  }
  pair = {(*found)[0].get<double>(), (*found)[1].get<double>()};
  return std::nullopt;
}

MaybeError read_transform(const Json& info, const std::string& info_element,
                          TextureReference& reference) {
  constexpr const char* kName = "KHR_texture_transform";
  const auto transform = find_extension(info, info_element, kName);
  if (!transform) return transform.error();
  if (!*transform) return std::nullopt;
  const Json& object = **transform;
  const std::string element = info_element + "/extensions/" + kName;
  if (auto error = read_pair(object, element, "offset", reference.uv_offset)) return error;
  if (auto error = read_pair(object, element, "scale", reference.uv_scale)) return error;
  if (auto error = read_number(object, element, "rotation", reference.uv_rotation_rad)) {
    return error;
  }
  return read_tex_coord(object, element, reference.tex_coord);
}

MaybeError read_wrap(const Json& sampler, const std::string& element, const char* name,
                     TextureWrap& wrap) {
  constexpr std::pair<std::uint64_t, TextureWrap> kWraps[] = {
      {10497, TextureWrap::kRepeat}, {33071, TextureWrap::kClamp}, {33648, TextureWrap::kMirror}};
  const auto found = sampler.find(name);
  if (found == sampler.end()) return std::nullopt;
  for (const auto& [number, value] : kWraps) {
    if (whole_number(*found) != number) continue;
    wrap = value;
    return std::nullopt;
  }
  return gltf_expected(element + "/" + name, *found,
                       "10497 (repeat), 33071 (clamp) or 33648 (mirror)");
}

// Reads the sampler of a texture, if any.
MaybeError read_sampler(const Json& root, const Json& texture, const std::string& texture_element,
                        TextureReference& reference) {
  const auto id =
      optional_id(texture, texture_element, "sampler", "/samplers", section_size(root, "samplers"));
  if (!id) return id.error();
  if (!*id) return std::nullopt;
  const std::string element = gltf_element("samplers", **id);
  const Json& sampler = root["samplers"][**id];
  if (!sampler.is_object()) return gltf_expected(element, sampler, "an object");
  if (auto error = read_wrap(sampler, element, "wrapS", reference.wrap_u)) return error;
  return read_wrap(sampler, element, "wrapT", reference.wrap_v);
}

}  // namespace

Result<TextureReference> read_texture_reference(const Json& root, const Json& info,
                                                const std::string& element) {
  if (!info.is_object()) return gltf_expected(element, info, "an object");
  const auto texture_id =
      required_id(info, element, "index", "/textures", section_size(root, "textures"));
  if (!texture_id) return texture_id.error();
  const std::string texture_element = gltf_element("textures", *texture_id);
  const Json& texture = root["textures"][*texture_id];
  if (!texture.is_object()) return gltf_expected(texture_element, texture, "an object");
  const auto image_id =
      optional_id(texture, texture_element, "source", "/images", section_size(root, "images"));
  if (!image_id) return image_id.error();

  TextureReference reference;
  reference.texture = static_cast<std::uint32_t>(*texture_id);
  if (*image_id) {
    const Json& image = root["images"][**image_id];
    if (!image.is_object()) {
      return gltf_expected(gltf_element("images", **image_id), image, "an object");
    }
    reference.image = static_cast<std::uint32_t>(**image_id);
  }
  if (auto error = read_sampler(root, texture, texture_element, reference)) return *error;
  if (auto error = read_tex_coord(info, element, reference.tex_coord)) return *error;
  if (auto error = read_transform(info, element, reference)) return *error;
  return reference;
}

}  // namespace palpate
