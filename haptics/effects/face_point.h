#pragma once

// A point on a touched triangle, and the triangle attributes that effects use.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/exact/triangle.h"
#include "geometry/index/crease_normals.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {

// Texture coordinates (u, v) of the three corners: u to the right, v down; 1 is the whole image.
using CornerCoordinates = std::array<std::array<double, 2>, 3>;

// Texture coordinates as a function of a point: linear over the triangle and beyond its edges.
struct UvMap {
  Vec3 origin = Vec3::Zero();  // body frame
  std::array<double, 2> at_origin{};
  std::array<Vec3, 2> gradient{Vec3::Zero(), Vec3::Zero()};  // body frame, along the triangle

  std::array<double, 2> at(const Vec3& p_body) const noexcept {
    const Vec3 from_origin = p_body - origin;
    return {at_origin[0] + gradient[0].dot(from_origin),
            at_origin[1] + gradient[1].dot(from_origin)};
  }

  // The map of a triangle; constant if rounding leaves the triangle no area.
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

// The attributes of one surface's triangles, by slot of its index. A vector is empty if no effect
// needs it.
struct SurfaceAttributes {
  std::vector<std::uint16_t> part;  // the triangle's part of the mesh; empty: all are part 0
  std::vector<CornerNormals> corner_normals;
  std::vector<UvMap> texture_uv;
  std::vector<UvMap> friction_uv;

  std::uint16_t part_of(std::uint32_t slot) const { return part.empty() ? 0 : part[slot]; }
};

// A point of a touched triangle. Thread-safe; safe on the haptic thread.
struct FacePoint {
  const ContactBody* body = nullptr;
  const SurfaceAttributes* attributes = nullptr;
  std::uint32_t slot = 0;
  Vec3 point_body = Vec3::Zero();

  // The triangle in the body frame. The result refers to the index or, for a stretched body, to
  // `storage`, which this function fills.
  const TriangleGeometry& triangle(TriangleGeometry& storage) const {
    return body->triangle(slot, storage);
  }

  // Weights of the corners, each >= 0, with sum 1. If the point lies over the triangle, they are
  // its barycentric coordinates; elsewhere, negative coordinates are set to 0 before normalisation.
  std::array<double, 3> barycentric(const TriangleGeometry& t) const noexcept {
    const Vec3 a = t.a - point_body;
    const Vec3 b = t.b - point_body;
    const Vec3 c = t.c - point_body;
    std::array<double, 3> w = {std::max(0.0, triple_product(t.normal, b, c)),
                               std::max(0.0, triple_product(t.normal, c, a)),
                               std::max(0.0, triple_product(t.normal, a, b))};
    const double sum = w[0] + w[1] + w[2];
    if (!(sum > 0.0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};  // a degenerate triangle
    for (double& weight : w) weight /= sum;
    return w;
  }
};

}  // namespace palpate
