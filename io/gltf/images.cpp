#include "io/gltf/images.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/image_decoder.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

}  // namespace

std::optional<Error> GltfImages::decode(TextureReference& reference, const std::string& wanted_by) {
  const auto with_caller = [&](Error error) {
    error.hint += (error.hint.empty() ? "" : "; ") + ("the image is required by " + wanted_by);
    return error;
  };
  if (!reference.image) {
    return with_caller(gltf_error(ErrorCode::kUnsupported,
                                  gltf_element("textures", reference.texture, "source"),
                                  "is missing; expected an image",
                                  "save the image as PNG or JPEG, without a texture extension"));
  }
  const auto [known, is_new] =
      indices_.emplace(*reference.image, static_cast<std::uint32_t>(images_.size()));
  if (is_new) {
    auto image = decoded(*reference.image);
    if (!image) return with_caller(image.error());
    pixels_left_ -= std::uint64_t{image->width} * image->height;
    const std::uint64_t bytes = image->rgb.size() * sizeof(image->rgb.front());
    if (auto error =
            asset_.buffers.take_memory({bytes, bytes}, gltf_element("images", *reference.image))) {
      return with_caller(*error);
    }
    images_.push_back(std::move(*image));
  }
  reference.pixels = known->second;
  return std::nullopt;
}

Result<ImageDescription> GltfImages::decoded(std::size_t id) {
  FileBytes storage;
  const auto bytes = encoded(id, storage);
  if (!bytes) return bytes.error();
  const std::string element = gltf_element("images", id);
  const auto admit = [&](std::uint64_t needed) {
    return asset_.buffers.take_memory({0, needed}, element);
  };
  auto image = decode_image(*bytes, {pixels_left_, admit});
  if (image) return image;
  Error error = image.error();
  error.element = element;
  return error;
}

// The encoded bytes of the image; in `storage` unless a buffer or the JSON contains them.
Result<std::span<const std::uint8_t>> GltfImages::encoded(std::size_t id, FileBytes& storage) {
  const std::string element = gltf_element("images", id);
  const Json& image = asset_.json["images"][id];
  const auto view =
      optional_id(image, element, "bufferView", "/bufferViews", asset_.model.bufferViews.size());
  if (!view) return view.error();
  if (*view && image.contains("uri")) {
    return gltf_invalid(element, "has both uri and bufferView; expected one or the other");
  }
  if (*view) return view_bytes(asset_, **view);
  if (!image.contains("uri")) {
    return gltf_invalid(element, "has neither uri nor bufferView, so no data");
  }
  std::string uri;
  if (auto error = read_text(image, element, "uri", uri)) return *error;
  auto loaded = asset_.buffers.read_uri(uri, kMaxGltfImageBytes);
  if (!loaded) {
    Error error = loaded.error();
    error.element = element + "/uri";
    return error;
  }
  storage = std::move(loaded->storage);
  return loaded->bytes;
}

}  // namespace palpate
