// The closed parts of a surface.

#include "geometry/mesh/closed_parts.h"

#include <gtest/gtest.h>

#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using Faces = std::vector<Triangle>;

// A tetrahedron over four vertices.
Faces tetrahedron(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
}

Faces joined(Faces faces, const Faces& more) {
  faces.insert(faces.end(), more.begin(), more.end());
  return faces;
}

TEST(ClosedParts, AClosedSurfaceIsOneWholePart) {
  const ClosedParts parts = closed_parts(tetrahedron(0, 1, 2, 3));
  EXPECT_EQ(parts.count, 1u);
  EXPECT_TRUE(parts.is_whole());
  EXPECT_EQ(parts.part(2), 0u);
}

TEST(ClosedParts, AnOpenSurfaceHasNone) {
  Faces faces = tetrahedron(0, 1, 2, 3);
  faces.pop_back();
  EXPECT_EQ(closed_parts(faces).count, 0u);
  EXPECT_EQ(closed_parts({}).count, 0u);
}

TEST(ClosedParts, OrientationHasNoEffect) {
  Faces faces = tetrahedron(0, 1, 2, 3);
  std::swap(faces[1][0], faces[1][1]);
  EXPECT_TRUE(closed_parts(faces).is_whole());
}

TEST(ClosedParts, AnOpenPartLeavesTheOthersClosed) {
  // The open triangle comes first, between two closed parts in the order of vertices.
  const Faces faces =
      joined(joined({{4, 5, 6}}, tetrahedron(7, 8, 9, 10)), tetrahedron(0, 1, 2, 3));
  const ClosedParts parts = closed_parts(faces);
  EXPECT_EQ(parts.count, 2u);
  EXPECT_FALSE(parts.is_whole());
  EXPECT_EQ(parts.part(0), ClosedParts::kOpen);
  for (std::uint32_t f = 1; f < 5; ++f) EXPECT_EQ(parts.part(f), parts.part(1));
  for (std::uint32_t f = 5; f < 9; ++f) EXPECT_EQ(parts.part(f), parts.part(5));
  EXPECT_NE(parts.part(1), parts.part(5));
}

TEST(ClosedParts, PartsThatShareAVertexAreTwoAndAnEdgeJoinsThem) {
  EXPECT_EQ(closed_parts(joined(tetrahedron(0, 1, 2, 3), tetrahedron(3, 4, 5, 6))).count, 2u);
  // The common edge has four faces.
  EXPECT_TRUE(closed_parts(joined(tetrahedron(0, 1, 2, 3), tetrahedron(2, 3, 4, 5))).is_whole());
  // A fin at a vertex is open and leaves the tetrahedron closed; at an edge it opens it.
  EXPECT_EQ(closed_parts(joined(tetrahedron(0, 1, 2, 3), {{3, 4, 5}})).count, 1u);
  EXPECT_EQ(closed_parts(joined(tetrahedron(0, 1, 2, 3), {{2, 3, 4}})).count, 0u);
}

}  // namespace
}  // namespace palpate
