#include "io/gltf/skin.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include <nlohmann/json.hpp>

#include "io/gltf/attributes.h"
#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr GltfNumberFormat kInverseBindMatrices{"MAT4", kGltfFloats, "inverse bind matrices"};
constexpr GltfNumberFormat kJoints{"VEC4", kGltfUnsigned, "joints of vertices"};
constexpr GltfNumberFormat kJointWeights{"VEC4", kGltfFloats | kGltfNormalizedUnsigned,
                                         "weights of joints"};
constexpr std::size_t kJointsPerSet = 4;

// The largest error of the sum of a vertex's weights from rounding: half a step for each integer; a
// few half steps for a float, which is a quotient of rounded numbers.
double rounding_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 0.5 * kJointsPerSet / std::numeric_limits<std::uint8_t>::max();
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 0.5 * kJointsPerSet / std::numeric_limits<std::uint16_t>::max();
    default:
      return kJointsPerSet * std::numeric_limits<float>::epsilon();
  }
}

// m: by columns
Result<AffineTransform> inverse_bind(const double* m, std::size_t skin, std::size_t joint) {
  const double distance =
      std::max({std::abs(m[3]), std::abs(m[7]), std::abs(m[11]), std::abs(m[15] - 1.0)});
  if (!(distance <= kAffineRowTolerance)) {
    return gltf_invalid(gltf_element("skins", skin, "inverseBindMatrices"),
                        "the last row of matrix " + std::to_string(joint) + " is not 0 0 0 1");
  }
  Mat3 linear;
  linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
  return AffineTransform::given(linear, Vec3(m[12], m[13], m[14]));
}

Result<std::vector<std::size_t>> read_joints(const GltfAsset& asset, std::size_t skin,
                                             std::size_t max_joints) {
  const Json& object = asset.json["skins"][skin];
  const std::string element = gltf_element("skins", skin);
  if (!object.is_object()) return gltf_expected(element, object, "an object");
  const auto list = object.find("joints");
  if (list == object.end() || !list->is_array() || list->empty()) {
    return gltf_invalid(element + "/joints", "is missing, empty or not an array");
  }
  if (list->size() > max_joints) {
    return gltf_error(ErrorCode::kLimitExceeded, element + "/joints",
                      "raises the number of joints to more than " + std::to_string(kMaxGltfJoints) +
                          ", the limit");
  }
  std::vector<std::size_t> joints;
  for (const Json& joint : *list) {
    const auto id = whole_number(joint);
    if (!id || *id >= asset.model.nodes.size()) {
      return gltf_expected(element + "/joints/" + std::to_string(joints.size()), joint,
                           "an index into /nodes, which has " +
                               std::to_string(asset.model.nodes.size()) + " elements");
    }
    joints.push_back(*id);
  }
  return joints;
}

std::string named_node(const GltfAsset& asset, std::size_t node) {
  const std::string& name = asset.model.nodes[node].name;
  return "node " + std::to_string(node) + (name.empty() ? "" : " (" + in_quotes(name) + ")");
}

// Each of the joints of a node is used with its own inverse bind matrix.
void warn_of_duplicates(const GltfAsset& asset, std::size_t skin,
                        const std::vector<std::size_t>& joints,
                        std::vector<std::string>& warnings) {
  std::map<std::size_t, std::size_t> joint_of_node;
  std::size_t others = 0;
  std::string first;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto [known, is_new] = joint_of_node.emplace(joints[i], i);
    if (is_new || ++others > 1) continue;
    first = named_node(asset, joints[i]) + " is joint " + std::to_string(known->second) +
            " and joint " + std::to_string(i);
  }
  if (others == 0) return;
  warnings.push_back(
      gltf_element("skins", skin, "joints") + ": " + first +
      "; expected each node once. All its joints are used" +
      (others > 1 ? "; further repeated joints: " + std::to_string(others - 1) : ""));
}

Error joint_out_of_range(const GltfAsset& asset, std::size_t skin, std::size_t joint,
                         std::size_t node, const Mat3& linear_scene_joint,
                         const Mat3& linear_scene_mesh) {
  const std::string element = gltf_element("skins", skin, "joints/" + std::to_string(joint));
  const std::string what = named_node(asset, node);
  if (linear_scene_mesh.allFinite()) {
    if (auto error = check_scale(linear_scene_joint, element, what)) return *error;
    const std::string with_bind = what + " with its inverse bind matrix";
    if (auto error = check_scale(linear_scene_mesh, element, with_bind)) return *error;
  }
  return gltf_invalid(element, "the transform of " + what + ", scaled by " +
                                   gltf_number(lengthening(linear_scene_joint)) +
                                   ", with its inverse bind matrix, overflows");
}

// 16 numbers for each joint; empty if the skin has no inverse bind matrices.
Result<std::vector<double>> read_inverse_binds(const GltfAsset& asset, std::size_t skin,
                                               std::size_t joint_count) {
  const auto accessor =
      optional_id(asset.json["skins"][skin], gltf_element("skins", skin), "inverseBindMatrices",
                  "/accessors", asset.model.accessors.size());
  if (!accessor) return accessor.error();
  if (!*accessor) return std::vector<double>();
  return read_numbers(asset, **accessor, kInverseBindMatrices, joint_count);
}

// One set of a primitive: the joints that move each vertex, and their weights.
struct InfluenceSet {
  std::string element;         // of JOINTS_n
  std::vector<double> joints;  // kJointsPerSet for each vertex
  std::vector<double> weights;
};

// The number of values in a set for one vertex.
constexpr std::size_t kWorkPerVertex = 8;

// Accumulates the weighted joint transforms, set by set.
class Skinning {
 public:
  Skinning(const GltfSkin& skin, std::span<Vec3> positions)
      : skin_(skin),
        positions_(positions),
        sums_(positions.size(), Vec3::Zero()),
        weights_(positions.size(), 0.0) {}

  std::optional<Error> add(const InfluenceSet& set) {
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      for (std::size_t k = kJointsPerSet * i; k < kJointsPerSet * (i + 1); ++k) {
        const double weight = set.weights[k];
        if (weight == 0.0) continue;
        const auto joint = static_cast<std::size_t>(set.joints[k]);
        if (auto error = check(set, i, joint, weight)) return error;
        const AffineTransform& T_scene_mesh = skin_.T_scene_mesh[joint];
        sums_[i] += weight * (T_scene_mesh.linear * positions_[i] + T_scene_mesh.translation_m);
        weights_[i] += weight;
      }
    }
    return std::nullopt;
  }

  // rounding: the tolerated difference between 1 and the sum of a vertex's weights.
  std::optional<Error> finish(const std::string& element, double rounding,
                              std::vector<std::string>& warnings) {
    std::size_t off = 0;
    std::size_t unbound = 0;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      if (weights_[i] == 0.0) {
        // Other engines do the same; many files have such vertices, usually without a triangle.
        const AffineTransform& T_scene_mesh = skin_.T_scene_mesh.front();
        positions_[i] = T_scene_mesh.linear * positions_[i] + T_scene_mesh.translation_m;
        ++unbound;
        continue;
      }
      off += std::abs(weights_[i] - 1.0) > rounding ? 1 : 0;
      positions_[i] = sums_[i] / weights_[i];
    }
    if (unbound > 0) {
      warnings.push_back(element + ": " + std::to_string(unbound) + " of " +
                         std::to_string(positions_.size()) +
                         " vertices have no weight; they move with the first joint of the skin");
    }
    if (off > 0) {
      warnings.push_back(element + ": the weights of " + std::to_string(off) + " of " +
                         std::to_string(positions_.size()) +
                         " vertices do not add up to 1; they are divided by their sum");
    }
    return std::nullopt;
  }

 private:
  std::optional<Error> check(const InfluenceSet& set, std::size_t vertex, std::size_t joint,
                             double weight) const {
    const std::string name = "vertex " + std::to_string(vertex);
    if (weight < 0.0) {
      return gltf_invalid(
          set.element, name + " has the weight " + std::to_string(weight) + "; expected 0 or more");
    }
    if (joint < skin_.T_scene_mesh.size()) return std::nullopt;
    return gltf_invalid(set.element, name + " names joint " + std::to_string(joint) +
                                         ", but skin " + std::to_string(skin_.id) + " has " +
                                         std::to_string(skin_.T_scene_mesh.size()));
  }

  const GltfSkin& skin_;
  std::span<Vec3> positions_;
  std::vector<Vec3> sums_;
  std::vector<double> weights_;
};

}  // namespace

Result<GltfSkin> read_skin(const GltfAsset& asset, std::size_t skin_id, std::size_t max_joints,
                           const std::function<Result<AffineTransform>(std::size_t)>& place,
                           std::vector<std::string>& warnings) {
  const auto joints = read_joints(asset, skin_id, max_joints);
  if (!joints) return joints.error();
  warn_of_duplicates(asset, skin_id, *joints, warnings);
  const auto matrices = read_inverse_binds(asset, skin_id, joints->size());
  if (!matrices) return matrices.error();
  GltfSkin skin{skin_id, {}};
  skin.T_scene_mesh.reserve(joints->size());
  for (std::size_t i = 0; i < joints->size(); ++i) {
    const auto T_scene_joint = place((*joints)[i]);
    if (!T_scene_joint) return T_scene_joint.error();
    skin.T_scene_mesh.push_back(*T_scene_joint);
    if (!matrices->empty()) {
      const auto T_joint_mesh = inverse_bind(matrices->data() + 16 * i, skin_id, i);
      if (!T_joint_mesh) return T_joint_mesh.error();
      skin.T_scene_mesh.back() = *T_scene_joint * *T_joint_mesh;
    }
    const Mat3& linear = skin.T_scene_mesh.back().linear;
    if (!skin.T_scene_mesh.back().all_finite() || !(lengthening(linear) <= kMaxGltfScale)) {
      return joint_out_of_range(asset, skin_id, i, (*joints)[i], T_scene_joint->linear, linear);
    }
  }
  return skin;
}

std::optional<Error> apply_skin(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                const DracoPrimitive* compressed, const std::string& element,
                                const GltfSkin& skin, std::size_t& pose_work,
                                std::span<Vec3> positions, std::vector<std::string>& warnings) {
  constexpr const char* kWantedBy = "a node gives the mesh a skin";
  Skinning skinning(skin, positions);
  double rounding = 0.0;
  for (std::size_t n = 0;; ++n) {
    const std::string joints_name = "JOINTS_" + std::to_string(n);
    const std::string weights_name = "WEIGHTS_" + std::to_string(n);
    if (n > 0 && !primitive.attributes.contains(joints_name) &&
        !primitive.attributes.contains(weights_name)) {
      break;
    }
    const auto joints = attribute_accessor(asset, primitive, compressed, element, joints_name,
                                           positions.size(), kWantedBy);
    if (!joints) return joints.error();
    const auto weights = attribute_accessor(asset, primitive, compressed, element, weights_name,
                                            positions.size(), kWantedBy);
    if (!weights) return weights.error();
    const std::size_t work = kWorkPerVertex * positions.size();
    if (work > pose_work) {
      return gltf_error(ErrorCode::kLimitExceeded, element,
                        "raises the number of values to pose to more than " +
                            std::to_string(kMaxGltfPoseWork) + ", the limit");
    }
    pose_work -= work;
    auto joint_numbers =
        attribute_numbers(asset, compressed, joints_name, *joints, kJoints, positions.size());
    if (!joint_numbers) return joint_numbers.error();
    auto weight_numbers = attribute_numbers(asset, compressed, weights_name, *weights,
                                            kJointWeights, positions.size());
    if (!weight_numbers) return weight_numbers.error();
    rounding += rounding_of(asset.model.accessors[*weights].componentType);
    const InfluenceSet set{element + "/attributes/" + joints_name, std::move(*joint_numbers),
                           std::move(*weight_numbers)};
    if (auto error = skinning.add(set)) return error;
  }
  return skinning.finish(element, rounding, warnings);
}

}  // namespace palpate
