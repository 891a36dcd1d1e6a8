#pragma once

// Functions that read assets of GltfBuilder and expect a scene or an error.

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate::test {

inline SceneDescription read_glb(const GltfBuilder& asset, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  auto scene = read_gltf(asset.write_glb(folder), options);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return scene.ok() ? std::move(*scene) : SceneDescription{};
}

// Expects an error with this code that names the element and contains the text.
inline void expect_refused(const GltfBuilder& asset, ErrorCode code, const std::string& element,
                           const std::string& text = {}, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  const auto scene = read_gltf(asset.write_glb(folder), options);
  ASSERT_FALSE(scene.ok()) << "accepted; expected an error at " << element;
  const Error& error = scene.error();
  EXPECT_EQ(static_cast<int>(error.code), static_cast<int>(code)) << error.to_string();
  EXPECT_EQ(error.element, element) << error.to_string();
  EXPECT_NE(error.to_string().find(text), std::string::npos)
      << error.to_string() << "\nexpected: " << text;
}

inline void expect_invalid(const GltfBuilder& asset, const std::string& element,
                           const std::string& text = {}) {
  expect_refused(asset, ErrorCode::kInvalidContent, element, text);
}

constexpr std::size_t components_of(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
}

// An accessor of tightly packed components.
template <typename T>
std::size_t add_numbers(GltfBuilder& asset, const std::vector<T>& components, int component_type,
                        const std::string& type, bool normalized = false) {
  const std::size_t accessor =
      asset.add_accessor(asset.add_view(bytes_of(components)), component_type,
                         components.size() / components_of(type), type);
  if (normalized) asset.json["accessors"][accessor]["normalized"] = true;
  return accessor;
}

inline std::size_t add_floats(GltfBuilder& asset, const std::vector<float>& components,
                              const std::string& type) {
  return add_numbers(asset, components, GltfBuilder::kFloat, type);
}

}  // namespace palpate::test
