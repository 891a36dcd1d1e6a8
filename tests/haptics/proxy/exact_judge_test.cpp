#include "tests/helpers/exact_judge.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::Corners;
using test::ExactJudge;
using test::has_no_area;
using test::orientation;
using test::Random;
using test::segment_meets_triangle;
using test::Soup;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A triangle in the plane z = 0.1. The double nearest to 0.1 is not exactly a tenth, so only exact
// arithmetic finds that points lie in this plane.
const Corners kFlat{{0.0, 0.0, 0.1}, {1.0, 0.0, 0.1}, {0.0, 1.0, 0.1}};

std::vector<Corners> corners_of(const Soup& soup) {
  std::vector<Corners> triangles;
  for (const Triangle& t : soup.triangles) {
    triangles.push_back({soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]});
  }
  return triangles;
}

// Tests a segment in every order of the corners and of the ends; all results must be equal.
bool meets(const Vec3& p, const Vec3& q, const Corners& t) {
  const bool answer = segment_meets_triangle(p, q, t);
  for (const Corners& turned : {t, Corners{t.b, t.c, t.a}, Corners{t.a, t.c, t.b}}) {
    EXPECT_EQ(segment_meets_triangle(p, q, turned), answer);
    EXPECT_EQ(segment_meets_triangle(q, p, turned), answer);
  }
  return answer;
}

double above(double x) {
  return std::nextafter(x, kInfinity);
}
double below(double x) {
  return std::nextafter(x, -kInfinity);
}

TEST(ExactJudge, DetectsACrossingAndAMiss) {
  EXPECT_TRUE(meets({0.2, 0.2, 1.0}, {0.3, 0.2, -1.0}, kFlat));
  EXPECT_FALSE(meets({0.2, 0.2, 1.0}, {0.3, 0.2, 0.5}, kFlat));
  EXPECT_FALSE(meets({0.7, 0.7, 1.0}, {0.7, 0.7, -1.0}, kFlat));
}

TEST(ExactJudge, DistinguishesATouchFromAMissByOneUlp) {
  EXPECT_TRUE(meets({0.2, 0.2, 1.0}, {0.2, 0.3, 0.1}, kFlat));
  EXPECT_FALSE(meets({0.2, 0.2, 1.0}, {0.2, 0.3, above(0.1)}, kFlat));
  EXPECT_TRUE(meets({0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}, kFlat)) << "through a vertex";
  EXPECT_TRUE(meets({0.0, 0.0, 1.0}, {0.0, 0.0, 0.1}, kFlat)) << "ending at a vertex";
  EXPECT_TRUE(meets({0.5, 0.5, 1.0}, {0.5, 0.5, -1.0}, kFlat)) << "through an edge";
  EXPECT_FALSE(meets({0.5, above(0.5), 1.0}, {0.5, above(0.5), -1.0}, kFlat));
  EXPECT_FALSE(meets({0.5, -5e-324, 1.0}, {0.5, -5e-324, -1.0}, kFlat));
}

TEST(ExactJudge, JudgesSegmentsInThePlaneOfTheTriangle) {
  EXPECT_TRUE(meets({-1.0, 0.5, 0.1}, {1.0, 0.5, 0.1}, kFlat)) << "across";
  EXPECT_TRUE(meets({0.2, 0.2, 0.1}, {0.3, 0.3, 0.1}, kFlat)) << "within";
  EXPECT_TRUE(meets({-1.0, 0.0, 0.1}, {2.0, 0.0, 0.1}, kFlat)) << "along an edge";
  EXPECT_TRUE(meets({-1.0, 0.0, 0.1}, {0.0, 0.0, 0.1}, kFlat)) << "along an edge, to its end";
  EXPECT_FALSE(meets({-1.0, 0.0, 0.1}, {-5e-324, 0.0, 0.1}, kFlat));
  EXPECT_TRUE(meets({-1.0, 2.0, 0.1}, {2.0, -1.0, 0.1}, kFlat)) << "along the long edge";
  EXPECT_TRUE(meets({1.0, 1.0, 0.1}, {0.5, 0.5, 0.1}, kFlat)) << "to the long edge";
  EXPECT_FALSE(meets({1.0, 1.0, 0.1}, {0.5, above(0.5), 0.1}, kFlat));
}

TEST(ExactJudge, TreatsAPointAsASegmentOfLengthZero) {
  EXPECT_TRUE(meets({0.2, 0.2, 0.1}, {0.2, 0.2, 0.1}, kFlat));
  EXPECT_TRUE(meets({1.0, 0.0, 0.1}, {1.0, 0.0, 0.1}, kFlat));
  EXPECT_FALSE(meets({0.2, 0.2, below(0.1)}, {0.2, 0.2, below(0.1)}, kFlat));
  EXPECT_FALSE(meets({above(1.0), 0.0, 0.1}, {above(1.0), 0.0, 0.1}, kFlat));
}

// Points on a plane x + y + z = const with short integers times 2^-60 as coordinates. The points
// are exactly coplanar, and a step of one unit decides the sign, which is within the rounding of
// the double filter.
TEST(ExactJudge, OrientsExactlyWhereDoubleCannot) {
  Random random(61);
  const auto integer = [&] { return static_cast<double>(random.index(1u << 20)); };
  for (int trial = 0; trial < 20000; ++trial) {
    Vec3 points[4];
    for (Vec3& p : points) {
      const double x = integer();
      const double y = integer();
      p = Vec3(x, y, 0x1p30 - x - y) * 0x1p-60;
    }
    const auto& [a, b, c, d] = points;
    ASSERT_EQ(orientation(a, b, c, d), 0);
    const double turn = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    const int expected = turn > 0.0 ? -1 : turn < 0.0 ? 1 : 0;
    const Vec3 lifted = d + Vec3(0.0, 0.0, 0x1p-82);  // the last bit of d.z() or less
    if (lifted == d) continue;
    ASSERT_EQ(orientation(a, b, c, lifted), expected);
  }
}

TEST(ExactJudge, FindsThePieceAndTheTriangleThatTouch) {
  const ExactJudge judge({{{5, 5, 5}, {6, 6, 6}, {7, 7, 7}}, kFlat});
  ASSERT_EQ(judge.triangles().size(), 1u) << "a triangle without area is no obstacle";
  EXPECT_TRUE(has_no_area({{5, 5, 5}, {6, 6, 6}, {7, 7, 7}}));
  const std::vector<Vec3> free = {{0.2, 0.2, 1.0}, {0.2, 0.2, 0.2}, {5.0, 0.2, 0.2}};
  EXPECT_FALSE(judge.touch_of_point(free));
  std::vector<Vec3> leaking = free;
  leaking.insert(leaking.end(), {{0.3, 0.2, 0.2}, {0.2, 0.2, 0.0}, {-1.0, 0.0, 0.0}});
  const auto violation = judge.touch_of_point(leaking);
  ASSERT_TRUE(violation);
  EXPECT_EQ(violation->piece, 3u);
  EXPECT_EQ(violation->triangle, 0u);
}

TEST(ExactJudge, MeasuresTheDistanceOfASphereFromATriangle) {
  const ExactJudge judge({kFlat});
  const double z = 0.1 + 0x1p-10;
  const std::vector<Vec3> grazing = {{-1.0, 0.2, z}, {1.0, 0.2, z}};
  EXPECT_FALSE(judge.touch_of_sphere(grazing, z - 0.1));
  EXPECT_TRUE(judge.touch_of_sphere(grazing, above(z - 0.1)));
  // A piece past the vertex at (1, 0, 0.1), nearest in its middle.
  const std::vector<Vec3> past = {{1.25, -1.0, 0.1}, {1.25, 1.0, 0.1}};
  EXPECT_FALSE(judge.touch_of_sphere(past, 0.25));
  EXPECT_TRUE(judge.touch_of_sphere(past, above(0.25)));
  // A piece skew to an edge, separated from it only in z.
  const std::vector<Vec3> over = {{0.25, -0.5, 0.6}, {0.75, 0.5, 0.6}};
  EXPECT_FALSE(judge.touch_of_sphere(over, 0.5));
  EXPECT_TRUE(judge.touch_of_sphere(over, above(0.5)));
  const std::vector<Vec3> through = {{0.2, 0.2, 5.0}, {0.2, 0.2, -5.0}};
  const auto violation = judge.touch_of_sphere(through, 1e-6);
  ASSERT_TRUE(violation) << "however far its corners are";
  EXPECT_EQ(violation->distance_m, 0.0);
}

// The distance to random triangles, including needles, equals the result of a search by nested
// sections: the distance between two convex sets has a single minimum.
TEST(ExactJudge, MeasuresDistancesOfSegmentsToThinTriangles) {
  Random random(62);
  for (int trial = 0; trial < 300; ++trial) {
    const double width = std::pow(10.0, random.uniform(-9.0, -1.0));
    const Vec3 a = random.in_box(0.1);
    const Vec3 b = random.in_box(0.1);
    const Corners t{a, b, a + random.uniform(0.0, 1.0) * (b - a) + width * random.unit_vector()};
    const ExactJudge judge({t});
    const Vec3 p = random.in_box(0.2);
    const Vec3 q = random.in_box(0.2);
    const double distance = judge.distance_m(p, q, 0);
    double sampled = kInfinity;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const Vec3 x = t.a + (t.b - t.a) * i / kSteps + (t.c - t.a) * j / kSteps;
        const double at = std::clamp((x - p).dot(q - p) / (q - p).squaredNorm(), 0.0, 1.0);
        sampled = std::min(sampled, (p + at * (q - p) - x).norm());
      }
    }
    const double spacing = ((t.b - t.a).norm() + (t.c - t.a).norm()) / kSteps;
    ASSERT_LE(distance, sampled + 1e-15) << "trial " << trial;
    ASSERT_GE(distance, sampled - spacing) << "trial " << trial;
  }
}

TEST(ExactJudge, DistinguishesInsideFromOutside) {
  Random random(63);
  const Vec3 half_extent(0.1, 0.2, 0.05);
  const ExactJudge judge(corners_of(box_soup(half_extent)));
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec3 p = random.in_box(0.25);
    ASSERT_EQ(judge.is_inside(p), (p.cwiseAbs() - half_extent).maxCoeff() < 0.0);
  }
  EXPECT_TRUE(judge.is_inside(Vec3::Zero()));
  EXPECT_TRUE(judge.is_inside({below(0.1), 0.0, 0.0}));
  EXPECT_FALSE(judge.is_inside({above(0.1), 0.0, 0.0}));
}

}  // namespace
}  // namespace palpate
