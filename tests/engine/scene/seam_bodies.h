#pragma once

// Watertight bodies made of several nodes, and an inside test that uses only the intended positions
// of their surface.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "io/scene_description.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"

namespace palpate::test {

using Wide3 = Eigen::Matrix<long double, 3, 1>;
using WideMat3 = Eigen::Matrix<long double, 3, 3>;

// A closed surface, divided into nodes. vertices_m are the intended positions. The transforms in
// the file produce these positions, except for rounding in double.
struct SeamBody {
  std::string kind;
  std::vector<Wide3> vertices_m;       // scene frame
  std::vector<Triangle> triangles;     // front sides out
  std::vector<std::uint32_t> node_of;  // node of each triangle: 0 to node_count - 1
  std::uint32_t node_count = 0;
  Wide3 middle_m;  // a point inside
  double size_m = 0.0;

  // The body in one of two forms, selected by is_gltf.
  SceneDescription description;
  GltfBuilder gltf;
  bool is_gltf = false;
};

SeamBody random_seam_body(Random& random);

// Edges between triangles of different nodes, and vertices at their ends.
std::vector<std::array<std::uint32_t, 2>> seam_edges(const SeamBody& body);
std::vector<std::uint32_t> seam_vertices(const SeamBody& body);

// Decides in long double whether a point is inside, by the parity of the triangles on a ray from
// the point. If rounding could change a sign, it tries another direction, and finally the sum of
// the solid angles. Decides correctly for points whose distance from the surface is at least 1e-15
// of the size of the body.
class SeamJudge {
 public:
  // origin_m: the origin of the tested points, scene frame.
  SeamJudge(const SeamBody& body, const Vec3& origin_m);

  bool is_inside(const Vec3& p_m) const;

 private:
  enum class Answer : std::uint8_t { kOutside, kInside, kDoubtful };
  struct Face {
    Wide3 a, b, c;
    Vec3 low, high;  // its bounding box, slightly enlarged
  };

  Answer by_parity(const Wide3& p, const Vec3& rounded, int axis, double side) const;
  bool by_solid_angle(const Wide3& p) const;

  std::vector<Face> faces_;
  // Bounds on the rounding errors of sums of up to six products, each with two coordinates (m2) or
  // three (m3). Coordinates are at most 20 sizes from the origin of the scene, and each product is
  // accurate to 2^-64.
  long double doubt_m2_ = 0;
  long double doubt_m3_ = 0;
};

}  // namespace palpate::test
