#include "io/gltf/morph.h"

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Weights = std::vector<double>;

constexpr GltfNumberFormat kOffsets{"VEC3", kGltfFloats,
                                    "positions of morph targets without KHR_mesh_quantization"};
constexpr GltfNumberFormat kQuantizedOffsets{
    "VEC3", kGltfFloats | kGltfSigned | kGltfNormalizedSigned, "positions of morph targets"};

// The array "weights" of a node or a mesh; an error unless it has `count` numbers.
Result<std::optional<Weights>> weights_in(const Json& object, const std::string& parent,
                                          std::size_t count) {
  const auto found = object.find("weights");
  if (found == object.end()) return std::optional<Weights>();
  const std::string element = parent + "/weights";
  if (!found->is_array()) return gltf_expected(element, *found, "an array");
  if (found->size() != count) {
    return gltf_invalid(element, "has " + std::to_string(found->size()) + " elements; expected " +
                                     std::to_string(count) +
                                     ", the number of the mesh's morph targets");
  }
  Weights weights;
  for (const Json& weight : *found) {
    if (!weight.is_number() || !std::isfinite(weight.get<double>())) {
      return gltf_expected(element + "/" + std::to_string(weights.size()), weight,
                           "a finite number");
    }
    weights.push_back(weight.get<double>());
  }
  return std::optional(std::move(weights));
}

std::optional<Error> check_target(const GltfAsset& asset, std::size_t accessor,
                                  const std::string& element, std::size_t vertex_count,
                                  std::size_t pose_work) {
  const std::size_t count = asset.model.accessors[accessor].count;
  if (count != vertex_count) {
    return gltf_invalid(element, "accessor " + std::to_string(accessor) + " has " +
                                     std::to_string(count) + " elements, but the primitive has " +
                                     std::to_string(vertex_count) + " vertices");
  }
  if (count > pose_work) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      "raises the number of vertices to pose to more than " +
                          std::to_string(kMaxGltfPoseWork) + ", the limit");
  }
  return std::nullopt;
}

}  // namespace

std::size_t morph_target_count(const GltfAsset& asset, std::size_t mesh) {
  const auto& primitives = asset.model.meshes[mesh].primitives;
  return primitives.empty() ? 0 : primitives.front().targets.size();
}

Result<std::optional<Weights>> own_morph_weights(const GltfAsset& asset, std::size_t node,
                                                 const GltfPose& pose) {
  if (const Weights* weights = pose.weights_of(node)) return std::optional(*weights);
  const std::size_t count =
      morph_target_count(asset, static_cast<std::size_t>(asset.model.nodes[node].mesh));
  return weights_in(asset.json["nodes"][node], gltf_element("nodes", node), count);
}

Result<std::optional<Weights>> default_morph_weights(const GltfAsset& asset, std::size_t mesh) {
  return weights_in(asset.json["meshes"][mesh], gltf_element("meshes", mesh),
                    morph_target_count(asset, mesh));
}

std::optional<Error> add_morph_targets(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                       const std::string& element, std::span<const double> weights,
                                       std::size_t& pose_work, std::span<Vec3> positions) {
  if (primitive.targets.size() != weights.size()) {
    return gltf_invalid(element + "/targets",
                        "has " + std::to_string(primitive.targets.size()) +
                            " elements, but the first primitive of the mesh has " +
                            std::to_string(weights.size()));
  }
  for (std::size_t t = 0; t < weights.size(); ++t) {
    const auto position = primitive.targets[t].find("POSITION");
    if (weights[t] == 0.0 || position == primitive.targets[t].end()) continue;
    const auto accessor = static_cast<std::size_t>(position->second);
    const std::string path = element + "/targets/" + std::to_string(t) + "/POSITION";
    auto error = check_target(asset, accessor, path, positions.size(), pose_work);
    if (error) return error;
    const auto offsets = read_numbers(
        asset, accessor, asset.mesh_quantization ? kQuantizedOffsets : kOffsets, positions.size());
    if (!offsets) return offsets.error();
    pose_work -= positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] += weights[t] * Vec3(offsets->data() + 3 * i);
    }
  }
  return std::nullopt;
}

}  // namespace palpate
