// extras.palpate_contour of nodes.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::add_floats;
using test::expect_refused;
using test::GltfBuilder;
using test::Random;
using test::read_glb;

using PreciseAffine = Eigen::Transform<long double, 3, Eigen::Affine>;
using LongVec3 = Eigen::Matrix<long double, 3, 1>;

Json list_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Json contour_of(const Json& start, const Json& end) {
  return {{"palpate_contour", {{"start_m", start}, {"end_m", end}}}};
}

Json some_contour() {
  return contour_of({1, 2, 3}, {4, 5, 6});
}

// A node's transform in a file, its exact value, and bounds on how much it lengthens vectors.
struct FileTransform {
  Json node;
  PreciseAffine T_parent_node;
  double lengthening = 0.0;
  double translation_m = 0.0;
};

double random_scale(Random& random) {
  return (random.index(2) == 0 ? -1.0 : 1.0) * std::exp(random.uniform(-2.0, 2.0));
}

FileTransform random_trs(Random& random) {
  const Vec3 translation_m = random.in_box(10.0);
  const Quat rotation = random.rotation();
  const Vec3 scale(random_scale(random), random_scale(random), random_scale(random));
  const Json q = {rotation.x(), rotation.y(), rotation.z(), rotation.w()};
  return {{{"translation", list_of(translation_m)}, {"rotation", q}, {"scale", list_of(scale)}},
          Eigen::Translation<long double, 3>(translation_m.cast<long double>()) *
              rotation.cast<long double>().normalized() *
              Eigen::Scaling(LongVec3(scale.cast<long double>())),
          scale.cwiseAbs().maxCoeff(),
          translation_m.norm()};
}

// With shear; every second matrix is a mirror.
FileTransform random_matrix(Random& random) {
  Json numbers = Json::array();
  FileTransform transform;
  transform.T_parent_node.setIdentity();
  Mat3 linear;
  const Vec3 translation_m = random.in_box(10.0);
  for (int column = 0; column < 3; ++column) {
    linear.col(column) = random.in_box(2.0);
    for (const double x : linear.col(column)) numbers.push_back(x);
    numbers.push_back(0);
  }
  for (const double x : translation_m) numbers.push_back(x);
  numbers.push_back(1);
  transform.node["matrix"] = numbers;
  transform.T_parent_node.linear() = linear.cast<long double>();
  transform.T_parent_node.translation() = translation_m.cast<long double>();
  transform.lengthening = linear.norm();
  transform.translation_m = translation_m.norm();
  return transform;
}

TEST(GltfContours, AreInTheFrameOfTheNode) {
  Random random(31);
  // Rounding of a rotation matrix is at most 16 epsilon, and that of a product is less.
  constexpr double kRoundingPerNode = 32.0 * std::numeric_limits<double>::epsilon();
  for (int round = 0; round < 200; ++round) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    const Vec3 start_m = random.in_box(1.0);
    const Vec3 end_m = random.in_box(1.0);
    PreciseAffine T_scene_node = PreciseAffine::Identity();
    double length_m = std::max(start_m.norm(), end_m.norm());
    const std::size_t depth = 1 + random.index(4);
    Json node = {{"name", "object"}, {"extras", contour_of(list_of(start_m), list_of(end_m))}};
    std::size_t id = 0;
    for (std::size_t level = 0; level < depth; ++level) {
      const FileTransform own = random.index(2) == 0 ? random_trs(random) : random_matrix(random);
      node.update(own.node);
      T_scene_node = own.T_parent_node * T_scene_node;
      length_m = own.lengthening * length_m + own.translation_m;
      id = level + 1 < depth ? asset.add_child(node) : asset.add_node(node);
      node = {{"children", {id}}};
    }
    const SceneDescription scene = read_glb(asset);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.contours.size(), 1u);
    const ContourDescription& contour = scene.contours[0];
    EXPECT_EQ(contour.node, "object");
    EXPECT_EQ(contour.element, "/nodes/1/extras/palpate_contour");
    EXPECT_EQ(scene.tree.at(contour.tree_node).file_index, 1u);
    EXPECT_EQ(contour.problem + contour.hint, "");
    const double tolerance_m = kRoundingPerNode * static_cast<double>(depth) * length_m;
    const auto expect_at = [&](const Vec3& actual_m, const Vec3& p_node_m) {
      const LongVec3 expected_m = T_scene_node * LongVec3(p_node_m.cast<long double>());
      EXPECT_LE((actual_m - expected_m.cast<double>()).norm(), tolerance_m) << "round " << round;
    };
    expect_at(contour.start_scene_m, start_m);
    expect_at(contour.end_scene_m, end_m);
  }
}

TEST(GltfContours, FollowThePoseOfTheFile) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["extras"] = some_contour();
  const auto times = add_floats(asset, {0, 1}, "SCALAR");
  const auto places = add_floats(asset, {0, 0, 0, 8, 0, -4}, "VEC3");
  asset.json["animations"] = {
      {{"samplers", {{{"input", times}, {"output", places}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  EXPECT_EQ(read_glb(asset).contours.at(0).start_scene_m, Vec3(1, 2, 3));
  ReadOptions half_way;
  half_way.pose = "#0@0.5";
  const SceneDescription scene = read_glb(asset, half_way);
  EXPECT_EQ(scene.contours.at(0).start_scene_m, Vec3(5, 2, 1));
  EXPECT_EQ(scene.contours.at(0).end_scene_m, Vec3(8, 5, 4));
}

TEST(GltfContours, AreThoseOfTheSceneReadInDepthFirstOrder) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto named = [](const char* name) {
    return Json{{"name", name}, {"extras", some_contour()}};
  };
  const auto below = asset.add_child(named("below"));
  asset.add_child(named("outside"));
  Json first = named("first");
  first["children"] = {below};
  asset.add_node(first);
  asset.add_node(named("last"));
  const SceneDescription scene = read_glb(asset);
  std::vector<std::string> nodes;
  for (const ContourDescription& contour : scene.contours) nodes.push_back(contour.node);
  EXPECT_EQ(nodes, (std::vector<std::string>{"first", "below", "last"}));
  asset.json["scenes"].push_back({{"nodes", {0, 2}}});
  asset.json["scene"] = 1;
  const SceneDescription other = read_glb(asset);
  ASSERT_EQ(other.contours.size(), 1u);
  EXPECT_EQ(other.contours[0].node, "outside");
  EXPECT_EQ(other.contours[0].element, "/nodes/2/extras/palpate_contour");
}

TEST(GltfContours, AreNotRepeatedByInstances) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  Json& node = asset.json["nodes"][0];
  node["translation"] = {10, 0, 0};
  node["extras"] = some_contour();
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      add_floats(asset, {0, 0, 5, 0, 0, 10, 0, 0, 20}, "VEC3");
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.nodes.size(), 3u);
  ASSERT_EQ(scene.contours.size(), 1u);
  EXPECT_EQ(scene.contours[0].start_scene_m, Vec3(11, 2, 3));
}

TEST(GltfContours, PointsMayDifferByOneBit) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const double next = std::nextafter(2.0, 3.0);
  asset.json["nodes"][0]["extras"] = contour_of({1, 2, 3}, {1, next, 3});
  const SceneDescription scene = read_glb(asset);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.contours.at(0).end_scene_m, Vec3(1, next, 3));
}

// Expects that node 0 has a contour with this problem and node 1 a valid one, and that the only
// effect is one warning.
void expect_problem(const GltfBuilder& asset, const std::string& element_end,
                    const std::string& problem) {
  SCOPED_TRACE(asset.json["nodes"][0].dump().substr(0, 300));
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.nodes.size(), 1u);
  ASSERT_EQ(scene.contours.size(), 2u);
  const ContourDescription& wrong = scene.contours[0];
  EXPECT_EQ(wrong.element, "/nodes/0/extras/palpate_contour" + element_end);
  EXPECT_EQ(wrong.problem, problem);
  EXPECT_FALSE(wrong.hint.empty());
  EXPECT_EQ(wrong.start_scene_m, Vec3::Zero());
  EXPECT_EQ(wrong.end_scene_m, Vec3::Zero());
  EXPECT_EQ(wrong.node, "star");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], wrong.element + ": " + problem +
                                   "; the contour of \"star\" is ignored (" + wrong.hint + ")");
  EXPECT_EQ(scene.contours[1].problem, "");
  EXPECT_EQ(scene.contours[1].end_scene_m, Vec3(4, 5, 6));
}

GltfBuilder asset_with_contour(const Json& contour) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["name"] = "star";
  asset.json["nodes"][0]["extras"]["palpate_contour"] = contour;
  asset.add_node({{"extras", some_contour()}});
  return asset;
}

TEST(GltfContours, AnotherFormIsAWarning) {
  const Json point = {1, 2, 3};
  const auto expect = [](const Json& contour, const std::string& element_end,
                         const std::string& problem) {
    expect_problem(asset_with_contour(contour), element_end, problem);
  };
  const std::string object = "; expected an object with start_m and end_m";
  expect(3, "", "is 3" + object);
  expect(nullptr, "", "is null" + object);
  expect("round", "", "is \"round\"" + object);
  expect(Json::array({point, point}), "", "is an array" + object);
  expect(Json::object(), "/start_m", "is missing; expected three numbers");
  expect({{"start_m", point}}, "/end_m", "is missing; expected three numbers");
  expect({{"start", point}, {"end_m", point}}, "",
         "has the unknown member \"start\"; expected only start_m and end_m");
  expect({{"start_m", point}, {"end_m", {0, 0, 0}}, {"note", ""}}, "",
         "has the unknown member \"note\"; expected only start_m and end_m");
  const auto expect_of_start = [&](const Json& start, const std::string& element_end,
                                   const std::string& problem) {
    expect({{"start_m", start}, {"end_m", point}}, "/start_m" + element_end, problem);
    expect({{"start_m", point}, {"end_m", start}}, "/end_m" + element_end, problem);
  };
  expect_of_start(5, "", "is 5; expected a list of three numbers");
  expect_of_start({{"x", 1}, {"y", 2}, {"z", 3}}, "",
                  "is an object; expected a list of three numbers");
  expect_of_start(Json::array(), "", "has 0 elements; expected 3 numbers");
  expect_of_start({1, 2}, "", "has 2 elements; expected 3 numbers");
  expect_of_start({1, 2, 3, 4}, "", "has 4 elements; expected 3 numbers");
  expect_of_start({1, "2", 3}, "/1", "is \"2\"; expected a number");
  expect_of_start({true, 2, 3}, "/0", "is true; expected a number");
  expect_of_start({1, 2, {3}}, "/2", "is an array; expected a number");
}

TEST(GltfContours, EqualPointsAreAWarning) {
  const std::string equal = "has equal points in the scene frame; expected two different points";
  expect_problem(asset_with_contour({{"start_m", {1, -0.0, 3}}, {"end_m", {1, 0, 3}}}), "", equal);
  // The node flattens the direction in which the points differ.
  GltfBuilder flat = asset_with_contour({{"start_m", {1, 2, 3}}, {"end_m", {1, 2, 5}}});
  flat.add_node({{"mesh", 0}});
  Json& wrong = flat.json["nodes"][0];
  wrong.erase("mesh");
  wrong["scale"] = {1, 1, 0};
  expect_problem(flat, "", equal);
}

TEST(GltfContours, PointsThatOverflowAreAWarning) {
  const std::string overflow =
      "has a point that is not finite in the scene frame; expected finite numbers";
  GltfBuilder asset = asset_with_contour({{"start_m", {0, 0, 0}}, {"end_m", {1e300, 0, 0}}});
  asset.json["nodes"][0]["scale"] = {1e10, 1, 1};
  expect_problem(asset, "", overflow);
}

TEST(GltfContours, LongNamesAreShortenedInWarnings) {
  const std::string lengthy(100000, 'n');
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["name"] = lengthy;
  for (const Json& contour : {Json{{lengthy, 1}}, Json(lengthy), Json{{"start_m", lengthy}}}) {
    asset.json["nodes"][0]["extras"]["palpate_contour"] = contour;
    const SceneDescription scene = read_glb(asset);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_LT(scene.warnings[0].size(), 1000u);
  }
}

TEST(GltfContours, DoNotExplainAnEmptyScene) {
  GltfBuilder asset = asset_with_contour(3);
  asset.json["nodes"][0].erase("mesh");
  const test::TemporaryFolder folder;
  const auto scene = read_gltf(asset.write_glb(folder));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kEmptyScene);
  EXPECT_EQ(scene.error().hint, "");
}

TEST(GltfContours, AreBounded) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (std::size_t i = 0; i < kMaxGltfContours; ++i) asset.add_node({{"extras", some_contour()}});
  EXPECT_EQ(read_glb(asset).contours.size(), kMaxGltfContours);
  asset.add_node({{"extras", {{"palpate_contour", 0}}}});
  expect_refused(asset, ErrorCode::kLimitExceeded,
                 "/nodes/" + std::to_string(kMaxGltfContours + 1) + "/extras/palpate_contour",
                 std::to_string(kMaxGltfContours));
}

}  // namespace
}  // namespace palpate
