#pragma once

// Closed triangle meshes of simple shapes, for models, benchmarks and tests.
//
// Every mesh is indexed without duplicate vertices, watertight, and counter-clockwise from outside.
// Every coordinate is a float value, so that writing a mesh to glTF and reading it does not change
// the mesh. The results are identical on every IEEE platform: the code uses only +, -, *, / and
// sqrt, never sin or cos. Frame: the shape's own, with its centre at the origin (for a prism, the
// contour determines the position); metres. Not for the haptic thread. Thread-safe.

#include <vector>

#include <Eigen/Core>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

using Point2 = Eigen::Matrix<double, 2, 1, Eigen::DontAlign>;

// A closed polygon, counter-clockwise; its last vertex is joined to its first. Metres.
using Contour = std::vector<Point2>;

struct TriangleMesh {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
};

// Rounds to the nearest float.
inline double to_float(double x) {
  return static_cast<double>(static_cast<float>(x));
}

// An icosahedron whose triangles are split into four, `subdivisions` times. The vertices are
// projected to the sphere. The mesh has 20 * 4^subdivisions triangles (5 subdivisions: 20,480; 6:
// 81,920; 7: 327,680; 8: 1,310,720; 9: 5,242,880). Requires radius_m > 0 and 0 <= subdivisions <=
// 12.
TriangleMesh icosphere(int subdivisions, double radius_m);

// An icosphere whose vertices lie at radius_m + bump_height_m * T(x) T(y) T(z), where (x, y, z) is
// the direction and T the Chebyshev polynomial of degree `waves`: T(cos a) = cos(waves * a), so
// that a turn about each axis has `waves` waves. Requires radius_m > bump_height_m >= 0, waves >= 1
// and the requirements of icosphere().
TriangleMesh bumpy_sphere(int subdivisions, double radius_m, double bump_height_m, int waves);

// A box with faces perpendicular to the axes; 12 triangles. Requires every component of size_m > 0.
TriangleMesh box(const Vec3& size_m);

// A torus about the z axis with 8 * 2^subdivisions points around the ring and 4 * 2^subdivisions
// around the tube: 64 * 4^subdivisions triangles. Vertices lie on the true torus. Requires 0 <=
// subdivisions <= 10 and major_radius_m > minor_radius_m > 0.
TriangleMesh torus(double major_radius_m, double minor_radius_m, int subdivisions);

// The solid between z_low_m and z_high_m over a contour of n vertices: 4 n - 4 triangles. Vertex i
// is contour[i] at z_low_m, and vertex n + i is contour[i] at z_high_m; both are rounded to float.
// The caps are triangulated by ear clipping with an exact orientation predicate. Returns
// kInvalidArgument if a number is not finite, z_low_m >= z_high_m, or the rounded contour is not a
// simple, counter-clockwise polygon.
Result<TriangleMesh> prism(const Contour& contour_m, double z_low_m, double z_high_m);

}  // namespace palpate
