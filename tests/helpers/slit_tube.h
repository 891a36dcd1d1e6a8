#pragma once

// A file whose surface has a gap, wider than rounding explains.

#include <cstdint>
#include <vector>

#include "tests/helpers/gltf_builder.h"

namespace palpate::test {

inline constexpr double kSlit_m = 0.002;

// A tube around the z axis with a square section of 80 mm; one of its walls has a slit along z. The
// section is an open contour. One mesh and one node, "tube".
inline GltfBuilder slit_tube() {
  const auto half = static_cast<float>(0.5 * kSlit_m);
  const std::vector<Eigen::Vector2f> section{{0.04f, half},    {0.04f, 0.04f},  {-0.04f, 0.04f},
                                             {-0.04f, -0.04f}, {0.04f, -0.04f}, {0.04f, -half}};
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector2f& p : section) {
    for (const float z : {-0.02f, 0.02f}) positions.emplace_back(p.x(), p.y(), z);
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i + 1 < section.size(); ++i) {
    const std::uint32_t low = 2 * i, high = low + 1, next = low + 2, next_high = low + 3;
    indices.insert(indices.end(), {low, next, next_high, low, next_high, high});
  }
  GltfBuilder gltf;
  const auto position = gltf.add_positions(positions);
  const auto index = gltf.add_indices(indices);
  const auto mesh = gltf.add_mesh({{{"attributes", {{"POSITION", position}}}, {"indices", index}}});
  gltf.add_node({{"mesh", mesh}, {"name", "tube"}});
  return gltf;
}

}  // namespace palpate::test
