#include "io/gltf/instancing.h"

#include <string>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

// From the extension's table of attributes.
constexpr GltfNumberFormat kInstanceTranslations{"VEC3", kGltfFloats, "translations of instances"};
constexpr GltfNumberFormat kInstanceRotations{"VEC4", kGltfFloats | kGltfNormalizedSigned,
                                              "rotations of instances"};
constexpr GltfNumberFormat kInstanceScales{"VEC3", kGltfFloats, "scales of instances"};

// Reads one of the three lists into numbers if the file has it; the first list sets the count.
std::optional<Error> read_list(const GltfAsset& asset, const Json& attributes,
                               const std::string& element, const char* name,
                               const GltfNumberFormat& format, std::size_t max_count,
                               std::size_t& count, std::vector<double>& numbers) {
  const auto accessor =
      optional_id(attributes, element, name, "/accessors", asset.model.accessors.size());
  if (!accessor) return accessor.error();
  if (!*accessor) return std::nullopt;
  const std::size_t length = asset.model.accessors[**accessor].count;
  if (length > max_count) {
    return gltf_error(ErrorCode::kLimitExceeded, element + "/" + name,
                      "raises the number of instances to more than " +
                          std::to_string(kMaxGltfInstances) + ", the limit");
  }
  if (count != 0 && length != count) {
    return gltf_invalid(element + "/" + name, "accessor " + std::to_string(**accessor) + " has " +
                                                  std::to_string(length) +
                                                  " elements, but others of the node have " +
                                                  std::to_string(count));
  }
  if (asset.model.accessors[**accessor].bufferView < 0) {
    return gltf_error(ErrorCode::kUnsupported, element + "/" + name,
                      "accessor " + std::to_string(**accessor) +
                          " has no bufferView, so most instances would be identical");
  }
  auto read = read_numbers(asset, **accessor, format, length);
  if (!read) return read.error();
  count = length;
  numbers = std::move(*read);
  return std::nullopt;
}

}  // namespace

AffineTransform GltfInstances::T_node_instance(std::size_t index) const {
  GltfTrs trs;
  if (!translations_m.empty()) trs.translation_m = Vec3(translations_m.data() + 3 * index);
  if (!rotations.empty()) trs.rotation = Eigen::Vector4d(rotations.data() + 4 * index);
  if (!scales.empty()) trs.scale = Vec3(scales.data() + 3 * index);
  return transform_of(trs);
}

Result<std::optional<GltfInstances>> read_instances(const GltfAsset& asset, std::size_t node,
                                                    std::size_t max_count) {
  const std::string parent = gltf_element("nodes", node);
  const auto extension = find_extension(asset.json["nodes"][node], parent, kInstancing);
  if (!extension) return extension.error();
  if (!*extension) return std::optional<GltfInstances>();
  const std::string element = parent + "/extensions/" + kInstancing + "/attributes";
  const auto attributes = (*extension)->find("attributes");
  if (attributes == (*extension)->end() || !attributes->is_object()) {
    return gltf_invalid(element, "is missing, or not an object");
  }
  GltfInstances instances;
  const auto read = [&](const char* name, const GltfNumberFormat& format,
                        std::vector<double>& numbers) {
    return read_list(asset, *attributes, element, name, format, max_count, instances.count,
                     numbers);
  };
  if (auto error = read("TRANSLATION", kInstanceTranslations, instances.translations_m))
    return *error;
  if (auto error = read("ROTATION", kInstanceRotations, instances.rotations)) return *error;
  if (auto error = read("SCALE", kInstanceScales, instances.scales)) return *error;
  if (instances.count == 0) {
    return gltf_invalid(element, "has none of TRANSLATION, ROTATION and SCALE");
  }
  for (std::size_t i = 0; i < instances.rotations.size() / 4; ++i) {
    const Eigen::Vector4d rotation(instances.rotations.data() + 4 * i);
    if (auto error = check_rotation(rotation, element + "/ROTATION")) {
      error->problem = "instance " + std::to_string(i) + " " + error->problem;
      return *error;
    }
  }
  return std::optional(std::move(instances));
}

}  // namespace palpate
