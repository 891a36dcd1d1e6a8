// The hard cases of god-object rendering with thin and sharp surfaces. JudgedProxy judges each
// tick: finite, passive, and with a path that touches no triangle in exact arithmetic.

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/haptics/proxy/hard_case_proxy.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::JudgedProxy;
using test::kDeg;
using test::kRelativeAccuracy;
using test::kTick_s;
using test::on_lattice;
using test::OwnedWorld;
using test::posed;
using test::radius_name;
using test::Random;
using test::Soup;
using test::trials;

// ---- 1 plunge through a sheet ------------------------------------------------------------------

class HardCase01_PlungeThroughASheet : public testing::TestWithParam<double> {
 protected:
  // Moves the hand along `velocity` from 2 cm in front of the sheet to 5 cm behind it. In every
  // tick, the proxy must be on top of the sheet.
  static void plunge(JudgedProxy& proxy, const RigidTransform& pose, double top_m, double radius_m,
                     const Vec3& velocity_m_per_s, const Vec3& aim_m) {
    const double front = 0.02 + radius_m + top_m;
    Vec3 at = aim_m + velocity_m_per_s * (front / velocity_m_per_s.z());
    proxy.place(pose.point(at));
    while (at.z() > -0.05) {
      at += kTick_s * velocity_m_per_s;
      const ProxyState state = proxy.move_to(pose.point(at));
      const Vec3 expected(at.x(), at.y(), std::max(at.z(), top_m + radius_m));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size_m());
    }
  }
};

TEST_P(HardCase01_PlungeThroughASheet, StopsOnTopHoweverFastAndThin) {
  const double radius = GetParam();
  Random random(101);
  struct Sheet {
    double thickness_m;  // 0: a single layer
    double speed_m_per_s;
  };
  for (const Sheet sheet : {Sheet{1e-3, 10.0}, Sheet{0.0, 10.0}, Sheet{1e-4, 5.0}}) {
    const Vec3 half(0.2, 0.2, 0.5 * sheet.thickness_m);
    const Soup soup =
        sheet.thickness_m > 0.0 ? test::box_soup(half) : test::sheet_soup(half.x(), half.y());
    for (int trial = 0; trial < trials(200); ++trial) {
      const RigidTransform pose = random.pose(1.0);
      const OwnedWorld world(posed(soup, pose), {}, radius);
      JudgedProxy proxy(world, radius);
      Vec3 direction = random.unit_vector();
      direction.z() = -std::abs(direction.z()) - 1.0;  // 45 deg or steeper
      const Vec3 aim = random.in_box(0.1).cwiseProduct(Vec3(1, 1, 0));
      const Vec3 velocity = sheet.speed_m_per_s * direction.normalized();
      ASSERT_NO_FATAL_FAILURE(plunge(proxy, pose, half.z(), radius, velocity, aim));
      ASSERT_EQ(proxy.verdict(), "") << "trial " << trial;
    }
  }
}

TEST_P(HardCase01_PlungeThroughASheet, StopsInFrontOfThePapersObjects) {
  const double radius = GetParam();
  Random random(102);
  for (const PaperObject& object : paper_objects()) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::paper_object_soup(object), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    for (int trial = 0; trial < trials(200); ++trial) {
      const Vec3 out = 0.2 * random.unit_vector();
      proxy.place(pose.point(out));
      for (int tick = 1; tick <= 40; ++tick) {
        proxy.move_to(pose.point(out - tick * kTick_s * 10.0 * out.normalized()));
      }
      ASSERT_EQ(proxy.verdict(), "") << object.name << " trial " << trial;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase01_PlungeThroughASheet, testing::Values(0.0, 2e-4, 5e-3),
                         radius_name);

// ---- 2 steps exactly through edges and vertices ------------------------------------------------

class HardCase02_RayThroughAnEdgeOrVertex : public testing::TestWithParam<double> {
 protected:
  // Corners, aims, starts and goals are multiples of small powers of two, so that each ray passes
  // exactly through a vertex or a point of an edge, in any pose in which the surface was rounded.
  // Returns the number of rays that were stopped.
  static int aim_exactly(const Soup& soup, double radius_m, double longest_m, int rays,
                         Random& random) {
    const OwnedWorld world(soup, {}, radius_m);
    JudgedProxy proxy(world, radius_m);
    int stopped = 0;
    for (int shot = 0; shot < rays;) {
      const Triangle& t = soup.triangles[random.index(soup.triangles.size())];
      const Vec3& a = soup.positions[t[0]];
      const Vec3& b = soup.positions[t[1]];
      const double part = 0x1p-8 * static_cast<double>(random.index(256));  // 0: the vertex
      const Vec3 aim = a + part * (b - a);
      const Vec3 front = (b - a).cross(soup.positions[t[2]] - a).normalized();
      const Vec3 way = (front + 0.9 * random.unit_vector()).normalized();
      const double length = random.uniform(0.2, 1.0) * longest_m;
      const Vec3 start = aim + on_lattice(length * way + 2 * radius_m * front);
      if (radius_m > 0.0 &&
          world.index().closest_point(world.world().to_solver(start), 1.01 * radius_m)) {
        continue;  // the start touches another face
      }
      proxy.place(start);
      const ProxyState state = proxy.move_to(2 * aim - start);
      stopped += state.in_contact;
      ++shot;
      EXPECT_EQ(proxy.verdict(), "") << "ray " << shot;
      if (!proxy.verdict().empty()) break;
    }
    return stopped;
  }
};

TEST_P(HardCase02_RayThroughAnEdgeOrVertex, FindsNoGap) {
  const double radius = GetParam();
  const int per_pose = 1000;
  const int poses = trials(radius == 0.0 ? 1000 : 100);
  Random random(103);
  int stopped = 0;
  for (int n = 0; n < poses && !HasFailure(); ++n) {
    const Soup soup = on_lattice(posed(test::soup_of(icosphere(1, 0.1)), random.pose(0.5)));
    stopped += aim_exactly(soup, radius, 0.05, per_pose, random);
  }
  // The other rays slid round the sphere to a goal on its far side.
  EXPECT_GT(stopped, poses * per_pose / 2);
}

TEST_P(HardCase02_RayThroughAnEdgeOrVertex, FindsNoGapInThePapersObjects) {
  const double radius = GetParam();
  Random random(116);
  for (const PaperObject& object : paper_objects()) {
    const int poses = trials(20);
    int stopped = 0;
    for (int n = 0; n < poses && !HasFailure(); ++n) {
      const Soup soup = on_lattice(posed(test::paper_object_soup(object), random.pose(0.5)));
      stopped += aim_exactly(soup, radius, 5e-3, 1000, random);
    }
    EXPECT_GT(stopped, poses * 1000 / 4) << object.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase02_RayThroughAnEdgeOrVertex, testing::Values(0.0, 2e-3),
                         radius_name);

// ---- 3 a corner of three planes ----------------------------------------------------------------

class HardCase03_ThreePlaneCorner : public testing::TestWithParam<double> {};

// Three edges from the origin that are far from coplanar, and the faces between them.
struct Corner {
  Mat3 edges;    // columns: unit, right-handed
  Mat3 normals;  // rows: unit, into the corner; row i faces column i
};

Corner random_corner(Random& random) {
  for (;;) {
    Corner corner;
    for (int i = 0; i < 3; ++i) corner.edges.col(i) = random.unit_vector();
    if (corner.edges.determinant() < 0.0) corner.edges.col(0).swap(corner.edges.col(1));
    if (corner.edges.determinant() < 0.05) continue;
    for (int i = 0; i < 3; ++i) {
      corner.normals.row(i) =
          corner.edges.col((i + 1) % 3).cross(corner.edges.col((i + 2) % 3)).normalized();
    }
    return corner;
  }
}

Soup soup_of(const Corner& corner, double length) {
  Soup soup;
  for (int i = 0; i < 3; ++i) {
    soup.add(Vec3::Zero(), length * corner.edges.col(i), length * corner.edges.col((i + 1) % 3));
  }
  return soup;
}

// The point of { s : N s >= d } nearest to g. Among the projections on all sets of planes, it is
// the one that violates no plane and whose multipliers G^-1 (d - N g), G = N N^T, are not negative.
Vec3 nearest_in(const Mat3& normals, const Vec3& offsets, const Vec3& g) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Vec3 best = Vec3::Zero();
  long double least_violation = std::numeric_limits<long double>::infinity();
  for (unsigned set = 0; set < 8; ++set) {
    std::vector<int> rows;
    for (int i = 0; i < 3; ++i) {
      if (set >> i & 1u) rows.push_back(i);
    }
    Matrix n(rows.size(), 3);
    Matrix lack(rows.size(), 1);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      n.row(row) = normals.row(rows[k]).cast<long double>();
      lack(row, 0) = offsets[rows[k]] - normals.row(rows[k]).dot(g);
    }
    Matrix push = rows.empty() ? Matrix(0, 1) : Matrix((n * n.transpose()).inverse() * lack);
    const Matrix s = g.cast<long double>() + n.transpose() * push;
    long double violation = 0;
    for (int i = 0; i < 3; ++i) {
      violation = std::max<long double>(
          violation, offsets[i] - (normals.row(i).cast<long double>() * s)(0, 0));
    }
    for (Eigen::Index k = 0; k < push.rows(); ++k) violation = std::max(violation, -push(k, 0));
    if (violation < least_violation) {
      least_violation = violation;
      best = s.cast<double>();
    }
  }
  return best;
}

TEST_P(HardCase03_ThreePlaneCorner, IsSolvedInOneTick) {
  const double radius = GetParam();
  Random random(104);
  int in_the_apex = 0;
  for (int n = 0; n < trials(400); ++n) {
    const Corner corner = random_corner(random);
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(soup_of(corner, 20.0), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    const Vec3 offsets = Vec3::Constant(radius);
    const Vec3 apex =
        corner.normals.inverse() * offsets;  // centre of a proxy that touches all three
    const Vec3 start = apex + 0.5 * corner.edges.rowwise().sum().normalized();
    for (int trial = 0; trial < 20; ++trial) {
      proxy.place(pose.point(start));
      // Half of the goals are within the cone of the normals, where the solution is the corner.
      Vec3 goal = apex + random.in_box(0.3);
      const bool beyond_apex = trial % 2 == 0;
      if (beyond_apex) {
        const Vec3 weights = 0.1 * random.in_box(1.0).cwiseAbs();
        goal = apex - corner.normals.transpose() * weights;
        ++in_the_apex;
      }
      const Vec3 expected = nearest_in(corner.normals, offsets, goal);
      const ProxyState state = proxy.move_to(pose.point(goal));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size_m());
      ASSERT_FALSE(state.capped);
      if (beyond_apex) {
        ASSERT_EQ(state.active_planes, 3);
      }
      ASSERT_EQ(proxy.verdict(), "") << "corner " << n << " trial " << trial;
    }
  }
  EXPECT_GT(in_the_apex, 0);
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase03_ThreePlaneCorner, testing::Values(0.0, 0.02),
                         radius_name);

// ---- 4 wedges ----------------------------------------------------------------------------------

struct WedgeCase {
  double solid_deg;  // angle within the solid; a valley if more than 180
  double radius_m;
};

void PrintTo(const WedgeCase& c, std::ostream* out) {
  *out << c.solid_deg << " deg, radius " << c.radius_m;
}

class HardCase04_Wedge : public testing::TestWithParam<WedgeCase> {
 protected:
  double solid_rad() const { return GetParam().solid_deg * kDeg; }
  // The required accuracy: 1e-8 of the size divided by the sine of the dihedral angle.
  double allowed_m(const JudgedProxy& proxy) const {
    return 1e-8 / std::abs(std::sin(solid_rad())) * proxy.size_m();
  }
};

// The exact position of the centre on the offset of the ridge: straight along one side, then round
// or over the ridge, then along the other side. The goal moves across the ridge at a constant
// depth, which is large compared with the step and small compared with the faces.
Vec3 over_the_ridge(double solid_rad, double radius, const Vec3& goal, double from_side) {
  for (const double side : {from_side, -from_side}) {
    const Vec3 normal = test::wedge_normal(solid_rad, side);
    const double height = normal.dot(goal);
    const Vec3 on_face = goal + std::max(0.0, radius - height) * normal;
    const bool over_face = test::wedge_slope(solid_rad, side).dot(goal) >= 0.0;
    if (over_face) return on_face;
  }
  Vec3 from_ridge = goal - Vec3(goal.x(), 0, 0);
  const double distance = from_ridge.norm();
  return goal + std::max(0.0, radius / distance - 1.0) * from_ridge;
}

class HardCase04_Ridge : public HardCase04_Wedge {};

TEST_P(HardCase04_Ridge, IsCrossedOnTheExactOffset) {
  const double radius = GetParam().radius_m;
  Random random(105);
  for (int n = 0; n < trials(100); ++n) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::wedge_soup(solid_rad()), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    const double from_side = n % 2 == 0 ? 1.0 : -1.0;
    const Vec3 slope = test::wedge_slope(solid_rad(), from_side);
    const Vec3 normal = test::wedge_normal(solid_rad(), from_side);
    const double depth = random.uniform(1e-5, 2e-3);
    // The start is half a step off, so that no goal is at the ridge to within rounding.
    Vec3 goal = 0.0505 * slope + (radius + 0.01) * normal;
    proxy.place(pose.point(goal));
    goal -= (0.01 + depth) * normal;
    proxy.move_to(pose.point(goal));
    for (int tick = 0; tick < 100; ++tick) {
      // The goal moves along the face and beyond its end, with a component along the ridge.
      goal += Vec3(1e-4, 0, 0) - 1e-3 * slope;
      const ProxyState state = proxy.move_to(pose.point(goal));
      const Vec3 expected = over_the_ridge(solid_rad(), radius, goal, from_side);
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), allowed_m(proxy))
          << "tick " << tick << " depth " << depth;
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " tick " << tick;
    }
  }
}

class HardCase04_Valley : public HardCase04_Wedge {};

TEST_P(HardCase04_Valley, HoldsAtTheBottomInOneTick) {
  const double radius = GetParam().radius_m;
  const double half_opening = std::numbers::pi - 0.5 * solid_rad();
  const double bottom = radius / std::sin(half_opening);
  Random random(106);
  for (int n = 0; n < trials(100); ++n) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::wedge_soup(solid_rad()), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    for (int trial = 0; trial < 20; ++trial) {
      proxy.place(pose.point({0.0, 0.0, bottom + 0.2}));
      const Vec3 goal(random.uniform(-0.5, 0.5), 0.0, bottom - random.uniform(0.01, 0.3));
      const ProxyState state = proxy.move_to(pose.point(goal));
      const Vec3 expected(goal.x(), 0.0, bottom);
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), allowed_m(proxy));
      ASSERT_FALSE(state.capped);
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " trial " << trial;
    }
  }
}

std::string wedge_name(const testing::TestParamInfo<WedgeCase>& wedge) {
  return "Solid" + std::to_string(std::lround(10 * wedge.param.solid_deg)) + "TenthDeg_" +
         (wedge.param.radius_m == 0.0 ? "Point" : "Sphere");
}
INSTANTIATE_TEST_SUITE_P(Angles, HardCase04_Ridge,
                         testing::Values(WedgeCase{1, 0}, WedgeCase{5, 0}, WedgeCase{90, 0},
                                         WedgeCase{179.9, 0}, WedgeCase{1, 5e-3},
                                         WedgeCase{5, 5e-3}, WedgeCase{90, 5e-3},
                                         WedgeCase{179.9, 5e-3}),
                         wedge_name);
INSTANTIATE_TEST_SUITE_P(Angles, HardCase04_Valley,
                         testing::Values(WedgeCase{359, 0}, WedgeCase{355, 0}, WedgeCase{270, 0},
                                         WedgeCase{180.1, 0}, WedgeCase{359, 1e-3},
                                         WedgeCase{355, 5e-3}, WedgeCase{270, 5e-3},
                                         WedgeCase{180.1, 5e-3}),
                         wedge_name);

}  // namespace
}  // namespace palpate
