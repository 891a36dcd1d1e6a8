// The proxy never passes through a closed surface, for any motion of the device. The test uses the
// winding number of the surface round the proxy (solid angles of all triangles by Van Oosterom &
// Strackee), independently of the code under test.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "models/primitives.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::OwnedWorld;
using test::Random;
using test::Soup;

double winding_number(const Soup& soup, const Vec3& p) {
  double angle = 0.0;
  for (const Triangle& t : soup.triangles) {
    const Vec3 a = soup.positions[t[0]] - p;
    const Vec3 b = soup.positions[t[1]] - p;
    const Vec3 c = soup.positions[t[2]] - p;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

struct LeakCase {
  const char* name;
  TriangleMesh mesh;
  Vec3 squeeze;     // scale of each axis, to make slivers and thin sheets
  double jitter_m;  // random displacement of each vertex
};

void PrintTo(const LeakCase& c, std::ostream* out) {
  *out << c.name;
}

Soup soup_of(const LeakCase& c, Random& random) {
  Soup soup;
  for (const Vec3& p : c.mesh.positions_m) {
    soup.positions.push_back(p.cwiseProduct(c.squeeze) + random.in_box(c.jitter_m));
  }
  soup.triangles = c.mesh.triangles;
  return soup;
}

Vec3 start_in(const Soup& soup, bool inside, const Vec3& squeeze, Random& random) {
  for (;;) {
    const Vec3 p = random.in_box(0.15).cwiseProduct(inside ? squeeze : Vec3(Vec3::Ones()));
    if ((winding_number(soup, p) > 0.5) == inside) return p;
  }
}

// A step from 1 um to 50 mm, sometimes a jump, and sometimes exactly a vertex.
Vec3 next_goal(const Soup& soup, const Vec3& at, Random& random) {
  if (random.index(1000) == 0) return soup.positions[random.index(soup.positions.size())];
  const double step = random.index(500) == 0 ? 0.3 : std::pow(10.0, random.uniform(-6.0, -1.3));
  return (at + step * random.unit_vector()).cwiseMin(0.2).cwiseMax(-0.2);
}

class ClosedSurface : public testing::TestWithParam<LeakCase> {};

TEST_P(ClosedSurface, KeepsThePointOnItsSide) {
  const int ticks = test::in_soak_or_else(200000, 20000);
  Random random(51);
  const Soup soup = soup_of(GetParam(), random);
  const OwnedWorld world(soup);
  for (const bool inside : {true, false}) {
    auto god_object = test::made(GodObject::create(world.world(), {}));
    Vec3 at = start_in(soup, inside, GetParam().squeeze, random);
    Vec3 proxy = world.world().to_solver(at);
    god_object.place(proxy);
    for (int tick = 0; tick < ticks; ++tick) {
      at = next_goal(soup, at, random);
      const Vec3 goal = world.world().to_solver(at);
      const ProxyState state = god_object.move_to(goal);
      const double winding = winding_number(soup, world.world().to_scene(state.proxy));
      ASSERT_EQ(winding > 0.5, inside) << "tick " << tick << ", winding number " << winding;
      ASSERT_LE((state.proxy - goal).norm(), (proxy - goal).norm() * (1 + 1e-14));
      proxy = state.proxy;
    }
  }
}

const Vec3 kRound = Vec3::Ones();

INSTANTIATE_TEST_SUITE_P(
    Shapes, ClosedSurface,
    testing::Values(LeakCase{"box", box(Vec3::Constant(0.2)), kRound, 0.0},
                    LeakCase{"jittered box", box(Vec3::Constant(0.2)), kRound, 2e-3},
                    LeakCase{"sphere", icosphere(2, 0.1), kRound, 0.0},
                    LeakCase{"sheet of slivers", icosphere(2, 0.1), Vec3(1, 1, 1e-3), 0.0},
                    LeakCase{"jittered sheet", icosphere(2, 0.1), Vec3(1e-2, 1, 1), 1e-5},
                    LeakCase{"bumpy sphere", bumpy_sphere(3, 0.1, 0.03, 5), kRound, 0.0},
                    LeakCase{"torus", torus(0.1, 0.03, 1), kRound, 0.0},
                    LeakCase{"jittered torus", torus(0.1, 0.03, 1), kRound, 1e-3}),
    [](const auto& shape) {
      std::string name = shape.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

}  // namespace
}  // namespace palpate
