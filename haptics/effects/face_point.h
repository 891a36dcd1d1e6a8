#pragma once

// A point on a triangle that is touched, and what a surface keeps of its triangles for effects.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/exact/triangle.h"
#include "geometry/index/crease_normals.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {

// Texture coordinates of the three corners: u to the right, v down, 1 is the whole image.
using CornerCoordinates = std::array<std::array<double, 2>, 3>;

// Texture coordinates over a triangle: linear in the point, and beyond its edges as well.
struct UvMap {
  Vec3 origin = Vec3::Zero();  // body frame
  std::array<double, 2> at_origin{};
  std::array<Vec3, 2> gradient{Vec3::Zero(), Vec3::Zero()};  // body frame, along the triangle

  std::array<double, 2> at(const Vec3& p_body) const noexcept {
    const Vec3 from_origin = p_body - origin;
    return {at_origin[0] + gradient[0].dot(from_origin),
            at_origin[1] + gradient[1].dot(from_origin)};
  }

  // Constant on a triangle whose area is lost to rounding.
  static UvMap over(const TriangleGeometry& t, const CornerCoordinates& corners) noexcept {
    UvMap map{t.a, corners[0]};
    const Vec3 ab = t.b - t.a;
    const Vec3 ac = t.c - t.a;
    const double twice_area = triple_product(t.normal, ab, ac);
    if (!(twice_area > 0.0)) return map;
    for (std::size_t i = 0; i < 2; ++i) {
      const double along_ab = corners[1][i] - corners[0][i];
      const double along_ac = corners[2][i] - corners[0][i];
      map.gradient[i] =
          (along_ab * ac.cross(t.normal) + along_ac * t.normal.cross(ab)) / twice_area;
    }
    return map;
  }
};

// What effects want to know of the triangles of one surface, by slot of its index. Each is empty if
// no effect asks for it.
struct SurfaceAttributes {
  std::vector<std::uint16_t> part;  // of the mesh: those of one material; all 0 if empty
  std::vector<CornerNormals> corner_normals;
  std::vector<UvMap> texture_uv;
  std::vector<UvMap> friction_uv;

  std::uint16_t part_of(std::uint32_t slot) const { return part.empty() ? 0 : part[slot]; }
};

// A point of a touched triangle. Safe on the haptic thread.
struct FacePoint {
  const ContactBody* body = nullptr;
  const SurfaceAttributes* attributes = nullptr;
  std::uint32_t slot = 0;
  Vec3 point_body = Vec3::Zero();

  // Body frame: where it is, or made in `room`.
  const TriangleGeometry& triangle(TriangleGeometry& room) const {
    return body->triangle(slot, room);
  }

  // Weights of the corners, >= 0, sum 1: those of the point itself where it lies over the triangle.
  std::array<double, 3> barycentric(const TriangleGeometry& t) const noexcept {
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
};

}  // namespace palpate
