// Skins, morph targets, and poses: the rest pose, and one animation at one time.

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::add_floats;
using test::add_numbers;
using test::expect_invalid;
using test::expect_refused;
using test::GltfBuilder;
using test::kEpsilon;
using test::read_glb;

using LongMatrix = Eigen::Matrix<long double, 4, 4>;
using LongVector = Eigen::Matrix<long double, 4, 1>;

// --- Skins ---------------------------------------------------------------------------------------

LongMatrix matrix_of_trs(const Vec3& t, const Eigen::Vector4d& q, const Vec3& s) {
  Eigen::Quaternion<long double> rotation(q[3], q[0], q[1], q[2]);
  rotation.normalize();
  LongMatrix m = LongMatrix::Identity();
  m.topLeftCorner<3, 3>() =
      rotation.toRotationMatrix() * s.cast<long double>().asDiagonal().toDenseMatrix();
  m.topRightCorner<3, 1>() = t.cast<long double>();
  return m;
}

// The expected position of a vertex, and its tolerance for rounding.
struct Expected {
  LongVector position = LongVector::Zero();
  long double bound = 0.0L;
};

// A chain of joints below the root node 1, a mesh at node 0 of random vertices.
class RandomSkin {
 public:
  explicit RandomSkin(test::Random& random) : random_(random) {
    for (std::size_t i = 0; i < kVertices; ++i) {
      points_.push_back(random_.in_box(3.0).cast<float>());
    }
    const auto positions = asset.add_positions(points_);
    asset.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
    asset.add_node({{"mesh", 0}, {"skin", 0}, {"translation", {100, 200, 300}}});
    Json joints = Json::array();
    LongMatrix world = LongMatrix::Identity();
    long double norm = 1.0L;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const Vec3 t = random_.in_box(2.0);
      const Eigen::Vector4d q = random_.rotation().coeffs();
      const Vec3 s(random_.uniform(0.5, 2.0), -random_.uniform(0.5, 2.0), 1.0);
      Json node = {{"translation", {t[0], t[1], t[2]}},
                   {"rotation", {q[0], q[1], q[2], q[3]}},
                   {"scale", {s[0], s[1], s[2]}}};
      if (i + 1 < kJoints) node["children"] = {i + 2};
      if (i == 0) asset.add_node(node);
      if (i > 0) asset.add_child(node);
      world = world * matrix_of_trs(t, q, s);
      norm *= matrix_of_trs(t, q, s).norm();
      worlds_.push_back(world);
      norms_.push_back(norm);
      joints.push_back(i + 1);
    }
    asset.json["skins"] = {{{"joints", joints}}};
    binds_.assign(kJoints, LongMatrix::Identity());
  }

  void add_inverse_binds() {
    std::vector<float> numbers;
    for (std::size_t i = 0; i < kJoints; ++i) {
      Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
          m(row, column) = static_cast<float>(random_.uniform(-2.0, 2.0));
        }
      }
      binds_[i] = m.cast<long double>();
      numbers.insert(numbers.end(), m.data(), m.data() + 16);
    }
    asset.json["skins"][0]["inverseBindMatrices"] = add_floats(asset, numbers, "MAT4");
  }

  // One set of attributes JOINTS_n and WEIGHTS_n. largest: the integer for 1.
  template <typename Joint, typename Weight>
  void add_set(int joint_type, int weight_type, long double largest) {
    std::vector<Joint> joints;
    std::vector<Weight> weights;
    if (influences_.empty()) influences_.resize(kVertices);
    for (std::size_t i = 0; i < 4 * kVertices; ++i) {
      const auto joint = static_cast<Joint>(random_.index(kJoints));
      const auto weight = static_cast<Weight>(random_.uniform(0.05, 0.3) *
                                              (std::is_integral_v<Weight> ? largest : 1.0L));
      joints.push_back(joint);
      weights.push_back(weight);
      influences_[i / 4].push_back({joint, static_cast<long double>(weight) / largest});
    }
    Json& attributes = asset.json["meshes"][0]["primitives"][0]["attributes"];
    const std::string n = std::to_string(set_count_++);
    attributes["JOINTS_" + n] = add_numbers(asset, joints, joint_type, "VEC4");
    attributes["WEIGHTS_" + n] =
        add_numbers(asset, weights, weight_type, "VEC4", std::is_integral_v<Weight>);
  }

  Expected expected(std::size_t vertex) const {
    Expected result;
    LongVector p = LongVector::Ones();
    p.head<3>() = points_[vertex].cast<long double>();
    long double sum = 0.0L;
    for (const auto& [joint, weight] : influences_[vertex]) {
      result.position += weight * (worlds_[joint] * (binds_[joint] * p));
      result.bound += weight * norms_[joint] * binds_[joint].norm() * p.norm();
      sum += weight;
    }
    result.position /= sum;
    result.bound /= sum;
    return result;
  }

  void check() const {
    const SceneDescription scene = read_glb(asset);
    ASSERT_EQ(scene.nodes.size(), 1u);
    EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3::Identity());
    EXPECT_EQ(scene.nodes[0].translation_m, Vec3::Zero());
    ASSERT_EQ(scene.meshes[0].positions.size(), kVertices);
    // Products of up to kJoints + 1 matrices, each entry four products, and a sum of 8 vertices.
    constexpr long double kRoundings = 16.0L * (kJoints + 1) + 16.0L;
    for (std::size_t i = 0; i < kVertices; ++i) {
      const Expected e = expected(i);
      const Eigen::Matrix<long double, 3, 1> p = e.position.head<3>();
      EXPECT_LE((scene.meshes[0].positions[i].cast<long double>() - p).norm(),
                kRoundings * kEpsilon * e.bound);
    }
  }

  GltfBuilder asset;

 private:
  static constexpr std::size_t kVertices = 12;
  static constexpr std::size_t kJoints = 5;
  struct Influence {
    std::size_t joint = 0;
    long double weight = 0.0L;
  };

  test::Random& random_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<LongMatrix> worlds_;
  std::vector<LongMatrix> binds_;
  std::vector<long double> norms_;
  std::vector<std::vector<Influence>> influences_;
  int set_count_ = 0;
};

TEST(GltfSkin, MovesVerticesWithTheirJointsForAllComponentTypes) {
  test::Random random(11);
  for (int round = 0; round < 10; ++round) {
    for (int kind = 0; kind < 6; ++kind) {
      RandomSkin skin(random);
      const int joint_type =
          kind % 2 == 0 ? GltfBuilder::kUnsignedByte : GltfBuilder::kUnsignedShort;
      const auto add_set = [&](auto joint) {
        using Joint = decltype(joint);
        if (kind < 2) skin.add_set<Joint, float>(joint_type, GltfBuilder::kFloat, 1.0L);
        if (kind / 2 == 1) {
          skin.add_set<Joint, std::uint8_t>(joint_type, GltfBuilder::kUnsignedByte, 255.0L);
        }
        if (kind / 2 == 2) {
          skin.add_set<Joint, std::uint16_t>(joint_type, GltfBuilder::kUnsignedShort, 65535.0L);
        }
      };
      const std::size_t sets = 1 + random.index(2);
      for (std::size_t i = 0; i < sets; ++i) {
        if (kind % 2 == 0) add_set(std::uint8_t{});
        if (kind % 2 == 1) add_set(std::uint16_t{});
      }
      if (random.index(2) == 0) skin.add_inverse_binds();
      skin.check();
    }
  }
}

TEST(GltfSkin, PlacesJointsOutsideTheSceneByTheirAncestors) {
  test::Random random(12);
  RandomSkin skin(random);
  skin.add_set<std::uint8_t, float>(GltfBuilder::kUnsignedByte, GltfBuilder::kFloat, 1.0L);
  skin.asset.json["scenes"][0]["nodes"] = {0};
  skin.check();
}

// The triangle (0,0,0), (1,0,0), (0,1,0) at node 0, every vertex moved by joint 0 alone, which is
// node 1 at (0, 0, 5); joint 1 is node 2, below node 1.
GltfBuilder skinned_triangle() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  Json& attributes = asset.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] =
      add_numbers(asset, std::vector<std::uint8_t>(12, 0), GltfBuilder::kUnsignedByte, "VEC4");
  attributes["WEIGHTS_0"] = add_floats(asset, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  asset.json["nodes"][0]["skin"] = 0;
  asset.json["nodes"][0]["scale"] = {0, 0, 0};  // must have no effect
  asset.add_node({{"translation", {0, 0, 5}}, {"children", {2}}});
  asset.add_child({{"translation", {0, 0, 7}}});
  asset.json["skins"] = {{{"joints", {1, 2}}}};
  return asset;
}

// Accessors of skinned_triangle().
constexpr std::size_t kJointsAccessor = 2;
constexpr std::size_t kWeightsAccessor = 3;

void set_weights(GltfBuilder& asset, const std::vector<float>& weights) {
  asset.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
      add_floats(asset, weights, "VEC4");
}

void set_joints(GltfBuilder& asset, const std::vector<std::uint16_t>& joints) {
  asset.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
      add_numbers(asset, joints, GltfBuilder::kUnsignedShort, "VEC4");
}

TEST(GltfSkin, PosesInTheSceneFrameWhereverTheNodeIs) {
  const SceneDescription scene = read_glb(skinned_triangle());
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].positions, (std::vector<Vec3>{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}));
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3::Identity());
  EXPECT_EQ(scene.nodes[0].translation_m, Vec3::Zero());
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.notes, (std::vector<std::string>{"pose: at rest; 1 skinned mesh"}));
}

TEST(GltfSkin, KeepsEveryBitWhereTheJointsDoNotMoveAnything) {
  test::Random random(13);
  GltfBuilder asset = skinned_triangle();
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 3; ++i) points.push_back(random.in_box(10.0).cast<float>());
  asset.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = asset.add_positions(points);
  asset.json["nodes"][1].erase("translation");
  const SceneDescription scene = read_glb(asset);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.meshes[0].positions[i], points[i].cast<double>());
  }
}

TEST(GltfSkin, ReadsAMeshWithoutSkinWhereTheNodeIs) {
  GltfBuilder asset = skinned_triangle();
  asset.json["nodes"][0] = {{"mesh", 0}, {"translation", {1, 2, 3}}};
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(1, 0, 0));
  EXPECT_EQ(scene.nodes[0].translation_m, Vec3(1, 2, 3));
  EXPECT_TRUE(scene.notes.empty());
}

TEST(GltfSkin, SharesAMeshInTheSamePose) {
  GltfBuilder asset = skinned_triangle();
  asset.add_node({{"mesh", 0}, {"skin", 0}});
  asset.add_node({{"mesh", 0}});
  asset.json["skins"].push_back({{"joints", {2}}});
  asset.add_node({{"mesh", 0}, {"skin", 1}});
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 3u);
  ASSERT_EQ(scene.nodes.size(), 4u);
  EXPECT_EQ(scene.nodes[0].mesh, scene.nodes[1].mesh);
  EXPECT_EQ(scene.meshes[scene.nodes[0].mesh].positions[0], Vec3(0, 0, 5));
  EXPECT_EQ(scene.meshes[scene.nodes[2].mesh].positions[0], Vec3(0, 0, 0));
  EXPECT_EQ(scene.meshes[scene.nodes[3].mesh].positions[0], Vec3(0, 0, 12));
  EXPECT_EQ(scene.notes.at(0), "pose: at rest; 2 skinned meshes");
}

TEST(GltfSkin, KeepsPrimitivesApartThatShareOnlyTheirPositions) {
  GltfBuilder asset = skinned_triangle();
  Json& primitives = asset.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives.push_back(primitives[0]);
  const auto joints =
      add_numbers(asset, std::vector<std::uint8_t>(12, 1), GltfBuilder::kUnsignedByte, "VEC4");
  primitives[2]["attributes"]["JOINTS_0"] = joints;
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.meshes[0].positions.size(), 6u);
  EXPECT_EQ(scene.meshes[0].positions[2], Vec3(0, 1, 5));
  EXPECT_EQ(scene.meshes[0].positions[5], Vec3(0, 1, 12));
  EXPECT_EQ(scene.meshes[0].triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {3, 4, 5}}));
}

TEST(GltfSkin, TakesTheMeanOfItsJointsAndDividesByTheSumOfWeights) {
  GltfBuilder asset = skinned_triangle();
  set_joints(asset, {0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0});
  set_weights(asset, {0.5, 0.5, 0, 0, 0.25, 0.125, 0, 0, 2, 2, 0, 0});
  const SceneDescription scene = read_glb(asset);
  const double mixed = (0.25 * 5 + 0.125 * 12) / 0.375;
  EXPECT_EQ(scene.meshes[0].positions[0], Vec3(0, 0, 8.5));
  EXPECT_DOUBLE_EQ(scene.meshes[0].positions[1].x(), 1.0);
  EXPECT_DOUBLE_EQ(scene.meshes[0].positions[1].z(), mixed);
  EXPECT_EQ(scene.meshes[0].positions[2], Vec3(0, 1, 8.5));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("/meshes/0/primitives/0: the weights of 2 of 3"),
            std::string::npos);
}

TEST(GltfSkin, ToleratesTheRoundingOfStoredWeightsOnly) {
  const auto warnings_with = [](auto first, int type) {
    using Weight = decltype(first);
    GltfBuilder asset = skinned_triangle();
    std::vector<Weight> weights(12, Weight{0});
    weights[0] = weights[4] = weights[8] = first;
    asset.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
        add_numbers(asset, weights, type, "VEC4", std::is_integral_v<Weight>);
    return read_glb(asset).warnings.size();
  };
  EXPECT_EQ(warnings_with(std::uint8_t{253}, GltfBuilder::kUnsignedByte), 0u);
  EXPECT_EQ(warnings_with(std::uint8_t{252}, GltfBuilder::kUnsignedByte), 1u);
  EXPECT_EQ(warnings_with(std::uint16_t{65533}, GltfBuilder::kUnsignedShort), 0u);
  EXPECT_EQ(warnings_with(std::uint16_t{65532}, GltfBuilder::kUnsignedShort), 1u);
  EXPECT_EQ(warnings_with(1.0f + 0x1p-21f, GltfBuilder::kFloat), 0u);
  EXPECT_EQ(warnings_with(1.0f + 0x1p-20f, GltfBuilder::kFloat), 1u);
}

TEST(GltfSkin, IgnoresJointsOfWeightZero) {
  GltfBuilder asset = skinned_triangle();
  set_joints(asset, {0, 9, 999, 65535, 0, 0, 0, 2, 0, 2, 0, 0});
  EXPECT_EQ(read_glb(asset).meshes.at(0).positions[0], Vec3(0, 0, 5));
  set_weights(asset, {1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0});
  expect_invalid(asset, "/meshes/0/primitives/0/attributes/JOINTS_0", "vertex 2 names joint 2");
}

TEST(GltfSkin, AcceptsTheLastRowOfInverseBindMatricesWithinFloatRounding) {
  for (const float last : {1.0f, 1.0f + 0x1p-19f, 1.0f + 0x1p-18f, 0.0f}) {
    GltfBuilder asset = skinned_triangle();
    std::vector<float> matrices = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 1, 1, last,
                                   1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    asset.json["skins"][0]["inverseBindMatrices"] = add_floats(asset, matrices, "MAT4");
    if (std::abs(last - 1.0f) <= 0x1p-19f) {
      EXPECT_EQ(read_glb(asset).meshes.at(0).positions[1], Vec3(3, 1, 6));
    } else {
      expect_invalid(asset, "/skins/0/inverseBindMatrices", "matrix 0");
    }
  }
}

TEST(GltfSkin, RefusesBrokenSkins) {
  const auto expect_broken = [](const std::string& element, const auto& change) {
    GltfBuilder asset = skinned_triangle();
    change(asset);
    expect_invalid(asset, element);
  };
  const auto skin_with = [](const char* property, const Json& value) {
    return [=](GltfBuilder& asset) { asset.json["skins"][0][property] = value; };
  };
  expect_broken("/skins/0", [](GltfBuilder& a) { a.json["skins"][0] = "bones"; });
  expect_broken("/skins/0/joints", [](GltfBuilder& a) { a.json["skins"][0].erase("joints"); });
  expect_broken("/skins/0/joints", skin_with("joints", Json::array()));
  expect_broken("/skins/0/joints", skin_with("joints", 1));
  expect_broken("/skins/0/joints/1", skin_with("joints", {1, 3}));
  expect_broken("/skins/0/joints/0", skin_with("joints", {-1, 1}));
  expect_broken("/skins/0/joints/0", skin_with("joints", {"1"}));
  expect_broken("/skins/0/inverseBindMatrices", skin_with("inverseBindMatrices", 99));
  expect_broken("/accessors/0/type", skin_with("inverseBindMatrices", 0));
  expect_broken("/nodes/0/skin", [](GltfBuilder& a) { a.json["nodes"][0]["skin"] = 1; });
  expect_broken("/accessors/4/count", [](GltfBuilder& a) {
    a.json["skins"][0]["inverseBindMatrices"] =
        add_floats(a, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "MAT4");
  });
  expect_broken("/accessors/4", [](GltfBuilder& a) {
    std::vector<float> matrices(32, 0.0f);
    matrices[15] = matrices[31] = 1.0f;
    matrices[16] = std::numeric_limits<float>::infinity();
    a.json["skins"][0]["inverseBindMatrices"] = add_floats(a, matrices, "MAT4");
  });
  expect_broken("/nodes/3", [](GltfBuilder& a) {
    a.add_child({{"children", {4}}});
    a.add_child({{"children", {3}}});
    a.json["skins"][0]["joints"] = {1, 3};
  });
  expect_broken("/skins/0/joints/0", [](GltfBuilder& a) {
    std::vector<float> matrices(32, 1e30f);
    matrices[3] = matrices[7] = matrices[11] = 0.0f;
    matrices[19] = matrices[23] = matrices[27] = 0.0f;
    matrices[15] = matrices[31] = 1.0f;
    a.json["skins"][0]["inverseBindMatrices"] = add_floats(a, matrices, "MAT4");
    a.json["nodes"][1]["scale"] = {1e300, 1e300, 1e300};
  });
}

TEST(GltfSkin, RefusesBrokenJointsAndWeights) {
  const std::string attributes = "/meshes/0/primitives/0/attributes/";
  const auto expect_broken = [](const std::string& element, const auto& change) {
    GltfBuilder asset = skinned_triangle();
    change(asset);
    expect_invalid(asset, element);
  };
  const auto without = [](const char* name) {
    return [=](GltfBuilder& asset) {
      asset.json["meshes"][0]["primitives"][0]["attributes"].erase(name);
    };
  };
  const auto accessor_with = [](std::size_t id, const char* property, const Json& value) {
    return [=](GltfBuilder& asset) { asset.json["accessors"][id][property] = value; };
  };
  expect_broken(attributes + "JOINTS_0", without("JOINTS_0"));
  expect_broken(attributes + "WEIGHTS_0", without("WEIGHTS_0"));
  expect_broken(attributes + "WEIGHTS_1", [](GltfBuilder& a) {
    a.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = kJointsAccessor;
  });
  expect_broken(attributes + "JOINTS_1", [](GltfBuilder& a) {
    a.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_1"] = kWeightsAccessor;
  });
  expect_broken(attributes + "JOINTS_0", accessor_with(kJointsAccessor, "count", 2));
  expect_broken(attributes + "WEIGHTS_0", accessor_with(kWeightsAccessor, "count", 1ll << 40));
  expect_broken("/accessors/2/type", accessor_with(kJointsAccessor, "type", "VEC3"));
  expect_broken("/accessors/3/type", accessor_with(kWeightsAccessor, "type", "VEC3"));
  expect_broken("/accessors/2/componentType", accessor_with(kJointsAccessor, "normalized", true));
  expect_broken("/accessors/2/componentType",
                accessor_with(kJointsAccessor, "componentType", GltfBuilder::kFloat));
  expect_broken("/accessors/3/componentType",
                accessor_with(kWeightsAccessor, "componentType", GltfBuilder::kUnsignedShort));
  expect_broken("/accessors/3", accessor_with(kWeightsAccessor, "byteOffset", 4));
  expect_broken(attributes + "JOINTS_0", [](GltfBuilder& a) {
    set_weights(a, {1, 0, 0, 0, 1, -0.5, 0.5, 0, 1, 0, 0, 0});
  });
  expect_broken("/accessors/4", [](GltfBuilder& a) {
    set_weights(a, {1, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 1, 0, 0, 0});
  });
}

// Real files have such vertices, usually without a triangle.
TEST(GltfSkin, VerticesWithoutAWeightMoveWithTheFirstJoint) {
  GltfBuilder asset = skinned_triangle();
  set_weights(asset, {1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0});
  GltfBuilder bound = skinned_triangle();
  set_weights(bound, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("1 of 3 vertices have no weight"), std::string::npos);
  EXPECT_EQ(scene.meshes.at(0).positions, read_glb(bound).meshes.at(0).positions);
}

TEST(GltfSkin, BoundsTheJointsOfAllSkins) {
  GltfBuilder asset = skinned_triangle();
  asset.json["skins"][0]["joints"] = std::vector<int>(kMaxGltfJoints - 1, 1);
  asset.json["skins"].push_back({{"joints", {1, 2}}});
  EXPECT_EQ(read_glb(asset).meshes.size(), 1u);
  asset.add_node({{"mesh", 0}, {"skin", 1}});
  expect_refused(asset, ErrorCode::kLimitExceeded, "/skins/1/joints");
}

TEST(GltfSkin, BoundsTheWorkOfManyPosesOfManyPrimitives) {
  constexpr std::size_t kPrimitives = 1 << 11;
  constexpr std::size_t kPoses = kMaxGltfPoseWork / (16 * kPrimitives) + 1;
  GltfBuilder asset = skinned_triangle();
  Json& primitives = asset.json["meshes"][0]["primitives"];
  const Json points = {{"attributes", Json::object()}, {"mode", 0}};
  for (std::size_t i = 1; i < kPrimitives; ++i) primitives.push_back(points);
  EXPECT_EQ(read_glb(asset).meshes.size(), 1u);
  for (std::size_t i = 1; i < kPoses; ++i) {
    asset.json["skins"].push_back({{"joints", {1}}});
    asset.add_node({{"mesh", 0}, {"skin", i}});
  }
  expect_refused(asset, ErrorCode::kLimitExceeded, "/meshes/0", "has too many poses");
}

TEST(GltfSkin, WarnsOnceForAllPosesOfAMesh) {
  GltfBuilder asset = skinned_triangle();
  set_weights(asset, {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 0, 0, 0});
  asset.add_node({{"mesh", 0}});
  asset.json["skins"].push_back({{"joints", {2}}});
  asset.add_node({{"mesh", 0}, {"skin", 1}});
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

// --- Morph targets -------------------------------------------------------------------------------

// The triangle at node 0 with two targets: one lifts vertex 1 by 4, the other all by 1, 2 and 3.
GltfBuilder morphed_triangle() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto first = asset.add_positions({{0, 0, 0}, {0, 0, 4}, {0, 0, 0}});
  const auto second = asset.add_positions({{0, 0, 1}, {0, 0, 2}, {0, 0, 3}});
  asset.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", first}},
                                                         {{"POSITION", second}}};
  return asset;
}

std::vector<double> heights(const SceneDescription& scene, std::size_t mesh = 0) {
  std::vector<double> z;
  for (const Vec3& position : scene.meshes.at(mesh).positions) z.push_back(position.z());
  return z;
}

TEST(GltfMorph, AddsTargetsByTheWeightsOfNodeElseMeshElseNone) {
  GltfBuilder asset = morphed_triangle();
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{0, 0, 0}));
  EXPECT_TRUE(read_glb(asset).notes.empty());
  asset.json["meshes"][0]["weights"] = {0.5, 0};
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{0, 2, 0}));
  asset.json["nodes"][0]["weights"] = {-0.25, 2};
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(heights(scene), (std::vector<double>{2, 3, 6}));
  EXPECT_EQ(scene.notes, (std::vector<std::string>{"pose: at rest; 1 morphed mesh"}));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfMorph, AddsSparseAndIntegerTargets) {
  GltfBuilder asset = morphed_triangle();
  asset.json["meshes"][0]["weights"] = {0.5, 0.25};
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint16_t>{2}));
  const auto values = asset.add_view(test::bytes_of(std::vector<float>{0, 0, 8}));
  Json& sparse = asset.json["accessors"][2];
  sparse.erase("bufferView");
  sparse["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedShort}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{0.25, 0.5, 4.75}));
  const std::vector<std::int16_t> integers = {0, 0, -4, 0, 0, 32, 0, 0, 1};
  const auto target = add_numbers(asset, integers, GltfBuilder::kShort, "VEC3");
  asset.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = target;
  expect_invalid(asset, "/accessors/4/componentType", "KHR_mesh_quantization");
  asset.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{-1, 8, 4.25}));
}

TEST(GltfMorph, SharesAMeshOfTheSameWeights) {
  GltfBuilder asset = morphed_triangle();
  asset.json["meshes"][0]["weights"] = {1, 0};
  asset.add_node({{"mesh", 0}, {"weights", {1, 0}}});
  asset.add_node({{"mesh", 0}, {"weights", {0, 0}}});
  asset.add_node({{"mesh", 0}, {"weights", {0, 1}}});
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.nodes[0].mesh, scene.nodes[1].mesh);
  EXPECT_EQ(heights(scene, scene.nodes[2].mesh), (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(heights(scene, scene.nodes[3].mesh), (std::vector<double>{1, 2, 3}));
}

TEST(GltfMorph, MorphsBeforeTheSkinMoves) {
  GltfBuilder asset = skinned_triangle();
  asset.json["nodes"][1]["scale"] = {1, 1, 10};
  const auto target = asset.add_positions({{0, 0, 1}, {0, 0, 2}, {0, 0, 3}});
  asset.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  asset.json["nodes"][0]["weights"] = {1};
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(heights(scene), (std::vector<double>{15, 25, 35}));
  EXPECT_EQ(scene.notes.at(0), "pose: at rest; 1 skinned mesh; 1 morphed mesh");
}

TEST(GltfMorph, DoesNotReadTargetsThatDoNotMoveAnything) {
  GltfBuilder asset = morphed_triangle();
  asset.json["meshes"][0]["weights"] = {1, 0};
  asset.json["accessors"][3]["byteOffset"] = 1000;
  asset.json["meshes"][0]["primitives"][0]["targets"][0]["NORMAL"] = 3;
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{0, 4, 0}));
  asset.json["meshes"][0]["primitives"][0]["targets"][0].erase("POSITION");
  EXPECT_EQ(heights(read_glb(asset)), (std::vector<double>{0, 0, 0}));
}

TEST(GltfMorph, RefusesBrokenTargetsAndWeights) {
  const auto expect_broken = [](const std::string& element, const auto& change) {
    GltfBuilder asset = morphed_triangle();
    asset.json["meshes"][0]["weights"] = {1, 1};
    change(asset);
    expect_invalid(asset, element);
  };
  const auto weights = [](const Json& value) {
    return [=](GltfBuilder& asset) { asset.json["meshes"][0]["weights"] = value; };
  };
  expect_broken("/meshes/0/weights", weights({1}));
  expect_broken("/meshes/0/weights", weights({1, 1, 1}));
  expect_broken("/meshes/0/weights", weights(1));
  expect_broken("/meshes/0/weights/1", weights({1, "1"}));
  expect_broken("/nodes/0/weights", [](GltfBuilder& a) {
    a.json["nodes"][0]["weights"] = {1, 1, 1};
  });
  expect_broken("/meshes/0/primitives/0/targets/1/POSITION",
                [](GltfBuilder& a) { a.json["accessors"][3]["count"] = 2; });
  expect_broken("/meshes/0/primitives/0/targets/1/POSITION",
                [](GltfBuilder& a) { a.json["accessors"][3]["count"] = 1ll << 50; });
  expect_broken("/accessors/3/type",
                [](GltfBuilder& a) { a.json["accessors"][3]["type"] = "VEC2"; });
  expect_broken("/meshes/0/primitives/1/targets", [](GltfBuilder& a) {
    Json& primitives = a.json["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[1]["targets"].erase(1);
  });
  expect_broken("/meshes/0/primitives/0", weights({1e308, 1e308}));
}

// --- Animations ----------------------------------------------------------------------------------

// The asset in the pose of an animation.
SceneDescription read_posed(const GltfBuilder& asset, const std::string& pose) {
  ReadOptions options;
  options.pose = pose;
  return read_glb(asset, options);
}

void expect_invalid_posed(const GltfBuilder& asset, const std::string& pose,
                          const std::string& element, const std::string& text = {}) {
  ReadOptions options;
  options.pose = pose;
  expect_refused(asset, ErrorCode::kInvalidContent, element, text, options);
}

constexpr const char* kInterpolations[] = {"LINEAR", "STEP", "CUBICSPLINE"};

// Adds a channel to an animation; to a new one if animation equals the number of animations.
// values: of the first of two keyframes; the second is a half, four of which are a rotation.
void animate(GltfBuilder& asset, std::size_t animation, std::size_t node, const std::string& path,
             const std::vector<float>& values, const std::string& interpolation = "LINEAR",
             float first_time = 0.0f) {
  std::vector<float> output;
  const std::vector<float> other(values.size(), 0.5f);
  const bool cubic = interpolation == "CUBICSPLINE";
  for (const std::vector<float>& key : {values, other}) {
    if (cubic) output.insert(output.end(), values.size(), 55.0f);
    output.insert(output.end(), key.begin(), key.end());
    if (cubic) output.insert(output.end(), values.size(), 66.0f);
  }
  const std::string type = path == "weights" ? "SCALAR" : path == "rotation" ? "VEC4" : "VEC3";
  const auto out = add_floats(asset, output, type);
  const auto in = add_floats(asset, {first_time, first_time + 1.0f}, "SCALAR");
  Json& json = asset.json["animations"][animation];
  const std::size_t sampler = json["samplers"].size();
  json["samplers"].push_back({{"input", in}, {"output", out}, {"interpolation", interpolation}});
  json["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

TEST(GltfAnimation, TakesTheFirstKeyframeOfEveryInterpolation) {
  for (const char* interpolation : kInterpolations) {
    for (const float first_time : {0.0f, 2.5f}) {
      GltfBuilder asset = GltfBuilder::one_triangle();
      asset.json["nodes"][0]["translation"] = {9, 9, 9};
      asset.json["nodes"][0]["rotation"] = {1, 0, 0, 0};
      animate(asset, 0, 0, "translation", {1, 2, 3}, interpolation, first_time);
      animate(asset, 0, 0, "rotation", {0, 0, 0.7071068f, 0.7071068f}, interpolation, first_time);
      animate(asset, 0, 0, "scale", {2, 3, 4}, interpolation, first_time);
      asset.json["animations"][0]["name"] = "Walk";
      const SceneDescription scene = read_posed(asset, "Walk@0");
      Mat3 expected;
      expected << 0, -3, 0, 2, 0, 0, 0, 0, 4;
      EXPECT_EQ(scene.nodes.at(0).linear_scene_mesh, expected);
      EXPECT_EQ(scene.nodes[0].translation_m, Vec3(1, 2, 3));
      EXPECT_EQ(scene.tree.at(0).origin_m, Vec3(1, 2, 3));
      EXPECT_EQ(scene.notes, (std::vector<std::string>{"pose: animation #0 \"Walk\" at 0 s"}));
      EXPECT_TRUE(scene.warnings.empty());
    }
  }
}

TEST(GltfAnimation, KeepsValuesThatItDoesNotAnimate) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["translation"] = {9, 8, 7};
  asset.json["nodes"][0]["scale"] = {5, 5, 5};
  animate(asset, 0, 0, "scale", {2, 2, 2});
  const SceneDescription scene = read_posed(asset, "#0@0");
  EXPECT_EQ(scene.nodes.at(0).linear_scene_mesh, Mat3(2.0 * Mat3::Identity()));
  EXPECT_EQ(scene.nodes[0].translation_m, Vec3(9, 8, 7));
  EXPECT_EQ(scene.notes.at(0), "pose: animation #0 \"animation 0\" at 0 s");
}

template <typename T>
void check_normalized_rotation(int component_type) {
  const T half = std::numeric_limits<T>::max();
  GltfBuilder asset = GltfBuilder::one_triangle();
  animate(asset, 0, 0, "rotation", {0, 0, 0, 1});
  const std::vector<T> keys = {half, 0, 0, 0, 0, half, 0, 0};
  asset.json["animations"][0]["samplers"][0]["output"] =
      add_numbers(asset, keys, component_type, "VEC4", true);
  const Mat3 half_turn = Vec3(1, -1, -1).asDiagonal();
  EXPECT_EQ(read_posed(asset, "#0@0").nodes.at(0).linear_scene_mesh, half_turn);
  asset.json["accessors"].back().erase("normalized");
  expect_invalid_posed(asset, "#0@0", "/accessors/4/componentType", "animated rotations");
}

TEST(GltfAnimation, ReadsNormalisedIntegers) {
  check_normalized_rotation<std::int8_t>(GltfBuilder::kByte);
  check_normalized_rotation<std::uint8_t>(GltfBuilder::kUnsignedByte);
  check_normalized_rotation<std::int16_t>(GltfBuilder::kShort);
  check_normalized_rotation<std::uint16_t>(GltfBuilder::kUnsignedShort);
}

TEST(GltfAnimation, AppliesExactlyOneAnimation) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["scale"] = {5, 5, 5};
  animate(asset, 0, 0, "translation", {1, 2, 3});
  animate(asset, 1, 0, "scale", {2, 2, 2});
  animate(asset, 1, 0, "translation", {7, 7, 7});
  asset.json["animations"][0]["name"] = "Walk";
  SceneDescription scene = read_posed(asset, "Walk@0");
  EXPECT_EQ(scene.nodes.at(0).translation_m, Vec3(1, 2, 3));
  EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3(5.0 * Mat3::Identity()));
  scene = read_posed(asset, "#1@0");
  EXPECT_EQ(scene.nodes.at(0).translation_m, Vec3(7, 7, 7));
  EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3(2.0 * Mat3::Identity()));
  scene = read_glb(asset);
  EXPECT_EQ(scene.nodes.at(0).translation_m, Vec3::Zero());
  EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3(5.0 * Mat3::Identity()));
  EXPECT_FALSE(scene.pose);
  EXPECT_EQ(scene.notes, (std::vector<std::string>{"pose: at rest"}));
}

TEST(GltfAnimation, MovesAncestorsAndJoints) {
  GltfBuilder asset = skinned_triangle();
  asset.add_node({{"children", {4}}});
  asset.add_child({{"mesh", 0}});
  animate(asset, 0, 3, "translation", {1, 2, 3});
  animate(asset, 0, 1, "translation", {0, 0, 6});
  const SceneDescription scene = read_posed(asset, "#0@0");
  EXPECT_EQ(scene.meshes.at(0).positions[0], Vec3(0, 0, 6));
  EXPECT_EQ(scene.nodes.at(1).translation_m, Vec3(1, 2, 3));
}

TEST(GltfAnimation, SetsMorphWeights) {
  for (const char* interpolation : kInterpolations) {
    GltfBuilder asset = morphed_triangle();
    asset.json["nodes"][0]["weights"] = {1, 1};
    asset.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    animate(asset, 0, 0, "weights", {0.25, 2}, interpolation);
    const SceneDescription scene = read_posed(asset, "#0@0");
    EXPECT_EQ(heights(scene), (std::vector<double>{2, 5, 6}));
    EXPECT_EQ(scene.notes.at(0), "pose: animation #0 \"animation 0\" at 0 s; 1 morphed mesh");
  }
  GltfBuilder asset = GltfBuilder::one_triangle();
  animate(asset, 0, 0, "weights", {0.25, 2});
  expect_invalid_posed(asset, "#0@0", "/animations/0/channels/0/target", "without morph targets");
}

TEST(GltfAnimation, IgnoresChannelsWithoutANodeOrWithAnotherPath) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (int i = 0; i < 5; ++i) animate(asset, 0, 0, "translation", {1, 2, 3});
  Json& channels = asset.json["animations"][0]["channels"];
  channels[0]["target"].erase("node");
  channels[1]["target"]["path"] = "pointer";
  channels[2].erase("target");
  channels[3] = 5;
  channels[4]["target"]["path"] = 7;
  asset.json["animations"].push_back("none");
  const SceneDescription scene = read_posed(asset, "#0@0");
  EXPECT_EQ(scene.nodes.at(0).translation_m, Vec3::Zero());
  EXPECT_TRUE(scene.warnings.empty());
  expect_invalid_posed(asset, "#1@0", "/animations/1", "channels");
  asset.json["animations"] = "none";
  const SceneDescription at_rest = read_glb(asset);
  ASSERT_EQ(at_rest.warnings.size(), 1u);
  EXPECT_TRUE(at_rest.warnings[0].starts_with("/animations: ")) << at_rest.warnings[0];
}

TEST(GltfAnimation, RejectsBrokenAnimationsOnlyIfChosen) {
  const auto expect_broken = [](const std::string& element, const auto& change) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    animate(asset, 0, 0, "rotation", {0, 0, 0, 1});
    change(asset, asset.json["animations"][0]);
    expect_invalid_posed(asset, "#0@0", element);
    // The same file is valid if the animation is not chosen.
    EXPECT_EQ(read_glb(asset).nodes.size(), 1u) << element;
    asset.add_node({{"mesh", 0}});
    animate(asset, 1, 1, "translation", {1, 2, 3});
    EXPECT_EQ(read_posed(asset, "#1@0").nodes.at(1).translation_m, Vec3(1, 2, 3)) << element;
  };
  const auto sampler_with = [](const char* property, const Json& value) {
    return [=](GltfBuilder&, Json& a) { a["samplers"][0][property] = value; };
  };
  const auto accessor_with = [](std::size_t id, const char* property, const Json& value) {
    return [=](GltfBuilder& asset, Json&) { asset.json["accessors"][id][property] = value; };
  };
  const std::string sampler = "/animations/0/samplers/0";
  expect_broken("/animations/0/channels/0/target/node", [](GltfBuilder& asset, Json&) {
    asset.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  });
  expect_broken("/animations/0/channels/1/target",
                [](GltfBuilder&, Json& a) { a["channels"].push_back(a["channels"][0]); });
  expect_broken("/animations/0/channels/0/sampler",
                [](GltfBuilder&, Json& a) { a["channels"][0]["sampler"] = 1; });
  expect_broken("/animations/0/channels/0/sampler",
                [](GltfBuilder&, Json& a) { a["channels"][0].erase("sampler"); });
  expect_broken("/animations/0/samplers", [](GltfBuilder&, Json& a) { a["samplers"] = "none"; });
  expect_broken("/animations/0/samplers", [](GltfBuilder&, Json& a) { a.erase("samplers"); });
  expect_broken(sampler, [](GltfBuilder&, Json& a) { a["samplers"][0] = 3; });
  expect_broken(sampler + "/input", sampler_with("input", 99));
  expect_broken(sampler + "/output", sampler_with("output", -1));
  expect_broken(sampler + "/output", sampler_with("interpolation", "CUBICSPLINE"));
  expect_broken(sampler + "/interpolation", sampler_with("interpolation", "QUADRATIC"));
  expect_broken(sampler + "/interpolation", sampler_with("interpolation", nullptr));
  expect_broken("/accessors/2/type", accessor_with(2, "type", "VEC3"));
  expect_broken("/accessors/2/componentType",
                accessor_with(2, "componentType", GltfBuilder::kUnsignedInt));
  expect_broken("/accessors/3/componentType",
                accessor_with(3, "componentType", GltfBuilder::kUnsignedInt));
  expect_broken("/accessors/2", accessor_with(2, "byteOffset", 4));
  expect_broken(sampler + "/output", accessor_with(2, "count", 1ll << 50));
  expect_broken("/accessors/3", [](GltfBuilder& asset, Json&) {
    asset.json["accessors"][2]["count"] = 1ll << 50;
    asset.json["accessors"][3]["count"] = 1ll << 50;
  });
  expect_broken(sampler + "/output", [](GltfBuilder& asset, Json& a) {
    a["samplers"][0]["output"] = add_floats(asset, {0, 0, 0, 1.1f, 0, 0, 0, 1}, "VEC4");
  });
  expect_broken("/accessors/4", [](GltfBuilder& asset, Json& a) {
    a["samplers"][0]["output"] =
        add_floats(asset, {0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 1}, "VEC4");
  });
  // All keys must be valid, not only those used.
  expect_broken(sampler + "/output", [](GltfBuilder& asset, Json& a) {
    a["samplers"][0]["output"] = add_floats(asset, {0, 0, 0, 1, 0, 0, 0, 1.1f}, "VEC4");
  });
  expect_broken("/animations/0/samplers/1/output", [](GltfBuilder& asset, Json& a) {
    a["channels"].push_back(a["channels"][0]);
    a["channels"][1]["target"]["path"] = "scale";
    a["channels"][1]["sampler"] = 1;
    a["samplers"].push_back(a["samplers"][0]);
    a["samplers"][1]["output"] = add_floats(asset, {1, 1, 1}, "VEC3");
  });
  expect_broken("/accessors/4", [](GltfBuilder& asset, Json& a) {
    a["samplers"][0]["input"] =
        add_floats(asset, {0, std::numeric_limits<float>::infinity()}, "SCALAR");
  });
  expect_broken(sampler + "/input", [](GltfBuilder& asset, Json& a) {
    a["samplers"][0]["input"] = add_floats(asset, {-0.5f, 1}, "SCALAR");
  });
}

TEST(GltfAnimation, RejectsTargetsThatAreNotNodes) {
  for (const Json& id : {Json(1), Json(-1), Json("0")}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    animate(asset, 0, 0, "translation", {1, 2, 3});
    asset.json["animations"][0]["channels"][0]["target"]["node"] = id;
    expect_invalid_posed(asset, "#0@0", "/animations/0/channels/0/target/node");
  }
}

TEST(GltfAnimation, RefusesSparseElementsInWrongOrder) {
  GltfBuilder asset = morphed_triangle();
  animate(asset, 0, 0, "weights", {0.25, 2});
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint8_t>{1, 1}));
  const auto values = asset.add_view(test::bytes_of(std::vector<float>{1, 2}));
  asset.json["accessors"][4]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedByte}}},
      {"values", {{"bufferView", values}}}};
  expect_invalid_posed(asset, "#0@0", "/accessors/4/sparse/indices");
  asset.json["accessors"][4]["sparse"]["count"] = 1;
  EXPECT_EQ(heights(read_posed(asset, "#0@0")), (std::vector<double>{1, 3, 3}));
}

TEST(GltfAnimation, AllocatesNoMemoryForKeyframesThatAreNotStored) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  animate(asset, 0, 0, "translation", {1, 2, 3});
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint32_t>{0, 1u << 31}));
  for (const std::size_t id : {2, 3}) {  // zeros, except for two keyframes
    Json& accessor = asset.json["accessors"][id];
    accessor["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedInt}}},
        {"values", {{"bufferView", accessor["bufferView"]}}}};
    accessor.erase("bufferView");
    accessor["count"] = 1ll << 50;
  }
  EXPECT_EQ(read_glb(asset).nodes.at(0).translation_m, Vec3::Zero());
  ReadOptions options;
  options.pose = "#0@0";
  expect_refused(asset, ErrorCode::kLimitExceeded, "/animations/0/samplers/0/input", "", options);
}

}  // namespace
}  // namespace palpate
