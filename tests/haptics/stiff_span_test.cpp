// The directions in which a contact is stiff.

#include "haptics/stiff_span.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

Vec3 random_vector(Random& random) {
  return {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
}

TEST(StiffSpan, IsTheNormalOfAWall) {
  Random random(1);
  std::cout << "seed " << random.seed() << "\n";
  for (int run = 0; run < 100; ++run) {
    const Vec3 normal = random_vector(random).normalized();
    StiffSpan span;
    EXPECT_EQ(span.part(normal), Vec3(Vec3::Zero()));
    for (int n = 0; n < 30; ++n) span.add(random.uniform(-1.0, 1.0) * normal);
    const Vec3 v = random_vector(random);
    EXPECT_LE((span.part(v) - v.dot(normal) * normal).norm(), 1e-14);
    span.add(Vec3::Zero());
    EXPECT_LE((span.part(v) - v.dot(normal) * normal).norm(), 1e-14);
  }
}

// A part is a damper's velocity: it must not push, and not exceed the velocity.
TEST(StiffSpan, APartIsNoLongerThanTheVectorAndNotAgainstIt) {
  Random random(2);
  std::cout << "seed " << random.seed() << "\n";
  for (int run = 0; run < 1000; ++run) {
    StiffSpan span;
    const int changes = 1 + static_cast<int>(random.index(20));
    for (int n = 0; n < changes; ++n) span.add(random.uniform(0.0, 3.0) * random_vector(random));
    const Vec3 v = random_vector(random);
    EXPECT_GE(span.part(v).dot(v), -1e-14);
    EXPECT_LE(span.part(v).norm(), v.norm() * (1.0 + 1e-14));
  }
}

TEST(StiffSpan, AxesThatStepInTurnSpanTheirPlane) {
  StiffSpan span;
  for (int n = 0; n < 60; ++n) span.add(n % 2 == 0 ? Vec3::UnitX() : Vec3::UnitY());
  for (const double angle : {0.0, 0.7, 1.6, 3.0}) {
    const Vec3 v(std::cos(angle), std::sin(angle), 0.0);
    EXPECT_NEAR((span.part(v) - v).norm(), 0.0, StiffSpan::kForget) << angle;
  }
  EXPECT_EQ(span.part(Vec3::UnitZ()), Vec3(Vec3::Zero()));
  span.clear();
  EXPECT_EQ(span.part(Vec3::UnitX()), Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace palpate
