#pragma once

// Watertight bodies made of several nodes, and a judge that knows only where their surface is meant
// to be.

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

// A closed surface in nodes. Its vertices are meant to be where they are here; what a file says of
// a node puts them there, exactly but for the rounding of its doubles.
struct SeamBody {
  std::string kind;
  std::vector<Wide3> vertices_m;       // scene frame
  std::vector<Triangle> triangles;     // front sides out
  std::vector<std::uint32_t> node_of;  // by triangle: 0 to node_count - 1
  std::uint32_t node_count = 0;
  Wide3 middle_m;  // inside
  double size_m = 0.0;

  // One of these says it.
  SceneDescription description;
  GltfBuilder gltf;
  bool is_gltf = false;
};

SeamBody random_seam_body(Random& random);

// Edges between triangles of different nodes, and vertices at their ends.
std::vector<std::array<std::uint32_t, 2>> seam_edges(const SeamBody& body);
std::vector<std::uint32_t> seam_vertices(const SeamBody& body);

// Whether a point is inside, by the parity of the triangles between it and far away, in long
// double. Where a sign is within rounding it tries another direction, and at last the sum of the
// solid angles. For points that are not nearer to the surface than 1e-15 of its size.
class SeamJudge {
 public:
  // origin_m: of the points that are asked about, scene frame.
  SeamJudge(const SeamBody& body, const Vec3& origin_m);

  bool is_inside(const Vec3& p_m) const;

 private:
  enum class Answer : std::uint8_t { kOutside, kInside, kDoubtful };
  struct Face {
    Wide3 a, b, c;
    Vec3 low, high;  // around it, and a little more
  };

  Answer by_parity(const Wide3& p, const Vec3& rounded, int axis, double side) const;
  bool by_solid_angle(const Wide3& p) const;

  std::vector<Face> faces_;
  // What rounding can make of products of two and of three coordinates: sums of up to six products,
  // of coordinates up to 20 sizes off the origin of the scene, each good to 2^-64.
  long double doubt_m2_ = 0;
  long double doubt_m3_ = 0;
};

}  // namespace palpate::test
