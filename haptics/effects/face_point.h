#pragma once

// A point on a triangle that is touched, and what a surface keeps of its triangles for effects.

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/crease_normals.h"
#include "geometry/triangle.h"
#include "haptics/contact_world.h"

namespace palpate {

// Texture coordinates of the three corners: u to the right, v down, 1 is the whole image.
using CornerCoordinates = std::array<std::array<double, 2>, 3>;

// What effects want to know of the triangles of one surface, by slot of its index. Each is empty if
// no effect asks for it.
struct SurfaceAttributes {
  std::vector<std::uint16_t> part;  // of the mesh: those of one material; all 0 if empty
  std::vector<CornerNormals> corner_normals;
  std::vector<CornerCoordinates> texture_uv;
  std::vector<CornerCoordinates> friction_uv;

  std::uint16_t part_of(std::uint32_t slot) const { return part.empty() ? 0 : part[slot]; }
};

// A point of a touched triangle. Safe on the haptic thread.
struct FacePoint {
  const ContactBody* body = nullptr;
  const SurfaceAttributes* attributes = nullptr;
  std::uint32_t slot = 0;
  Vec3 point_body = Vec3::Zero();  // body frame, m

  const TriangleGeometry& triangle() const { return body->index->triangle(slot); }

  // Weights of the corners, >= 0, sum 1: those of the point itself where it lies over the triangle.
  std::array<double, 3> barycentric() const noexcept {
    const TriangleGeometry& t = triangle();
    const Vec3 a = t.a - point_body;
    const Vec3 b = t.b - point_body;
    const Vec3 c = t.c - point_body;
    std::array<double, 3> w = {std::max(0.0, triple_product(t.normal, b, c)),
                               std::max(0.0, triple_product(t.normal, c, a)),
                               std::max(0.0, triple_product(t.normal, a, b))};
    const double sum = w[0] + w[1] + w[2];
    if (!(sum > 0.0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};  // a sliver, seen from its end
    for (double& weight : w) weight /= sum;
    return w;
  }

  std::array<double, 2> coordinates(const CornerCoordinates& corners) const noexcept {
    const auto w = barycentric();
    return {w[0] * corners[0][0] + w[1] * corners[1][0] + w[2] * corners[2][0],
            w[0] * corners[0][1] + w[1] * corners[1][1] + w[2] * corners[2][1]};
  }
};

}  // namespace palpate
