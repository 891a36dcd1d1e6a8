#pragma once

// What the tests of the reader share: random assets, and checks of scenes and of errors.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"

namespace palpate::test {

inline SceneDescription read_or_fail(const std::string& path) {
  auto scene = read_gltf(path);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return scene.ok() ? std::move(*scene) : SceneDescription{};
}

// The file must be refused with this code and an error that names the element, the file and,
// somewhere, the text.
inline void expect_file_refused(const std::string& path, ErrorCode code, const std::string& element,
                                const std::string& text = {}) {
  const auto scene = read_gltf(path);
  ASSERT_FALSE(scene.ok()) << "accepted; expected an error at " << element;
  const Error& error = scene.error();
  EXPECT_EQ(static_cast<int>(error.code), static_cast<int>(code)) << error.to_string();
  EXPECT_EQ(error.element, element) << error.to_string();
  EXPECT_EQ(error.path, path);
  EXPECT_FALSE(error.problem.empty());
  EXPECT_NE(error.to_string().find(text), std::string::npos)
      << error.to_string() << "\nexpected: " << text;
}

inline void expect_file_refused(const GltfBuilder& asset, ErrorCode code,
                                const std::string& element, const std::string& text = {}) {
  const TemporaryFolder folder;
  expect_file_refused(asset.write_glb(folder), code, element, text);
}

inline void expect_file_invalid(const GltfBuilder& asset, const std::string& element,
                                const std::string& text = {}) {
  expect_file_refused(asset, ErrorCode::kInvalidContent, element, text);
}

inline std::vector<Eigen::Vector3f> random_points(Random& random, std::size_t count) {
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(random.in_box(10.0).cast<float>());
  return points;
}

inline nlohmann::json primitive_of(std::size_t positions, std::size_t indices, int mode = 4) {
  return {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}};
}

// A scene of one node and one mesh of one primitive.
inline GltfBuilder asset_of(const std::vector<Eigen::Vector3f>& points,
                            const std::vector<std::uint32_t>& indices,
                            int component_type = GltfBuilder::kUnsignedShort, int mode = 4) {
  GltfBuilder asset;
  const auto positions = asset.add_positions(points);
  const auto index_accessor = asset.add_indices(indices, component_type);
  asset.add_node({{"mesh", asset.add_mesh(nlohmann::json::array(
                               {primitive_of(positions, index_accessor, mode)}))}});
  return asset;
}

inline void expect_same_geometry(const SceneDescription& a, const SceneDescription& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].name, b.meshes[i].name);
    EXPECT_EQ(a.meshes[i].positions, b.meshes[i].positions);
    EXPECT_EQ(a.meshes[i].triangles, b.meshes[i].triangles);
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
    EXPECT_EQ(a.nodes[i].mesh, b.nodes[i].mesh);
    EXPECT_EQ(a.nodes[i].linear_scene_mesh, b.nodes[i].linear_scene_mesh);
    EXPECT_EQ(a.nodes[i].translation_m, b.nodes[i].translation_m);
  }
}

}  // namespace palpate::test
