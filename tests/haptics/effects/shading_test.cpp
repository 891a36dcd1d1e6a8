// Shading smooths facets, keeps creases, and does not change other properties of the contact.

#include "haptics/effects/shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/crease_normals.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/floating_point.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::box_soup;
using test::effect_entry;
using test::effect_number;
using test::hand_settings;
using test::kEpsilon;
using test::Random;
using test::Soup;

SurfaceAttributes with_normals(const Soup& soup, const SurfaceIndex& index, double crease_deg) {
  const SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
  const std::vector<CornerNormals> of_face =
      crease_normals(mesh, {}, crease_deg * std::numbers::pi / 180.0);
  SurfaceAttributes attributes;
  test::for_each_slot(index, [&](std::uint32_t slot) {
    attributes.corner_normals.push_back(of_face[index.face(slot)]);
  });
  return attributes;
}

using Entries = std::vector<EffectProgramBuilder::Entry>;

BodyHand shaded(const Soup& soup, double crease_deg, const RigidTransform& pose,
                Entries others = {}) {
  BodyHand hand({soup}, pose);
  others.push_back(effect_entry<ShadingEffect>({crease_deg}));
  hand.effects.add_body(others, with_normals(soup, hand.index(), crease_deg));
  return hand;
}

BodyHand faceted(const Soup& soup, const RigidTransform& pose, const Entries& others = {}) {
  BodyHand hand({soup}, pose);
  if (!others.empty()) hand.effects.add_body(others);
  return hand;
}

struct Ripple {
  double most_rad = 0.0;     // largest deviation from the radial direction
  double largest_rad = 0.0;  // largest change between ticks, beyond the turn of the path itself
};

// A path along a great circle at a constant depth.
Ripple ripple_along(BodyHand& hand, const Vec3& u, const Vec3& v, double radius_m, double depth_m) {
  Ripple ripple;
  constexpr int kTicks = 3000;
  hand.go_to(1.1 * radius_m * u);
  Vec3 last = Vec3::Zero();
  for (int tick = 0; tick <= kTicks; ++tick) {
    const double angle = 2 * std::numbers::pi * tick / kTicks;
    const Vec3 radial = std::cos(angle) * u + std::sin(angle) * v;
    hand.go_to((radius_m - depth_m) * radial);
    const Vec3 off = hand.force().normalized() - radial;
    ripple.most_rad = std::max(ripple.most_rad, off.norm());
    if (tick > 0) ripple.largest_rad = std::max(ripple.largest_rad, (off - last).norm());
    last = off;
  }
  return ripple;
}

TEST(Shading, ReducesTheRippleOfFacetsToATenthOrLess) {
  Random random(6801);
  constexpr double kRadius_m = 0.05;
  constexpr double kDepth_m = 0.001;
  for (const int subdivisions : {2, 3, 4}) {
    const Soup soup = test::soup_of(icosphere(subdivisions, kRadius_m));
    Ripple smooth;
    Ripple rough;
    for (int run = 0; run < 10; ++run) {
      const RigidTransform pose = random.pose(0.3);
      const Vec3 u = random.unit_vector();
      const Vec3 v = u.cross(random.unit_vector()).normalized();
      BodyHand with = shaded(soup, 60.0, pose);
      with.begin(hand_settings());
      BodyHand without = faceted(soup, pose);
      without.begin(hand_settings());
      const Ripple a = ripple_along(with, u, v, kRadius_m, kDepth_m);
      const Ripple b = ripple_along(without, u, v, kRadius_m, kDepth_m);
      EXPECT_LT(a.most_rad, 0.1 * b.most_rad) << subdivisions;
      EXPECT_LT(a.largest_rad, 0.1 * b.largest_rad) << subdivisions;
      smooth = {std::max(smooth.most_rad, a.most_rad), std::max(smooth.largest_rad, a.largest_rad)};
      rough = {std::max(rough.most_rad, b.most_rad), std::max(rough.largest_rad, b.largest_rad)};
    }
    std::printf(
        "%d facets: off radial %.4f instead of %.4f rad, largest step %.4f instead of %.4f\n",
        20 << 2 * subdivisions, smooth.most_rad, rough.most_rad, smooth.largest_rad,
        rough.largest_rad);
  }
}

TEST(Shading, TurnsTheForceAndKeepsItsMagnitude) {
  Random random(6802);
  const Soup ring = test::soup_of(torus(0.05, 0.02, 2));
  for (int run = 0; run < 10; ++run) {
    const RigidTransform pose = random.pose(0.3);
    BodyHand with = shaded(ring, 60.0, pose);
    with.begin(hand_settings(1000.0, 1.0));
    BodyHand without = faceted(ring, pose);
    without.begin(hand_settings(1000.0, 1.0));
    constexpr double kLargest_N = 10.0;  // of forces that are removed completely
    Vec3 goal(0.08, 0, 0);
    int turned = 0;
    for (int tick = 0; tick < 3000; ++tick) {
      // Paths towards the core of the ring, from all sides.
      const Vec3 core = 0.05 * Vec3(goal.x(), goal.y(), 0).normalized();
      goal += 5e-4 * random.unit_vector() +
              0.02 * (0.018 - (goal - core).norm()) * (goal - core).normalized();
      with.go_to(goal);
      without.go_to(goal);
      ASSERT_EQ(vec3(with.record().proxy_scene_m), vec3(without.record().proxy_scene_m));
      ASSERT_EQ(with.record().contact, without.record().contact);
      const double size = without.force().norm();
      ASSERT_NEAR(with.force().norm(), size, 16 * kEpsilon * (size + kLargest_N)) << tick;
      if (!with.record().contact) continue;
      // The reported normal is that of the force.
      const double cosine = without.force().normalized().dot(without.normal());
      ASSERT_NEAR(with.force().normalized().dot(with.normal()), cosine, size > 1e-6 ? 1e-9 : 1.0);
      turned += (with.normal() - without.normal()).norm() > 0.01;
    }
    EXPECT_GT(turned, 300);
  }
}

// At a crease angle of 40 degrees, all edges of a box are creases: the box is rendered as without
// shading, to the bit, in any orientation of its axes.
TEST(Shading, DoesNotChangeCreasesAndFlatFaces) {
  Random random(6803);
  int contacts = 0;
  for (int run = 0; run < 20; ++run) {
    Soup soup = box_soup({0.04, 0.03, 0.02});
    if (run % 2) {
      const Quat turn = random.rotation();
      for (Vec3& p : soup.positions) p = turn * p;
    }
    const RigidTransform pose = run % 4 < 2 ? RigidTransform{} : random.pose(0.3);
    BodyHand with = shaded(soup, 40.0, pose);
    with.begin(hand_settings(1000.0, 1.0));
    BodyHand without = faceted(soup, pose);
    without.begin(hand_settings(1000.0, 1.0));
    Vec3 goal(0.06, 0, 0);
    for (int tick = 0; tick < 3000; ++tick) {
      goal += 1e-3 * random.unit_vector() + 0.02 * (0.035 - goal.norm()) * goal.normalized();
      with.go_to(goal);
      without.go_to(goal);
      ASSERT_EQ(vec3(with.record().force_device_N), vec3(without.record().force_device_N)) << tick;
      ASSERT_EQ(vec3(with.record().proxy_scene_m), vec3(without.record().proxy_scene_m));
      ASSERT_EQ(vec3(with.record().normal_scene), vec3(without.record().normal_scene));
      contacts += with.record().contact;
    }
  }
  EXPECT_GT(contacts, 5000);
}

// A cylinder with few facets: its side is smooth, its rims are creases.
TEST(Shading, SmoothsTheSideOfAPrismAndKeepsItsRims) {
  constexpr int kSides = 16;
  constexpr double kRadius_m = 0.03;
  Contour contour;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    contour.push_back({kRadius_m * std::cos(angle), kRadius_m * std::sin(angle)});
  }
  const Soup soup = test::soup_of(prism(contour, -0.02, 0.02).value());
  BodyHand hand = shaded(soup, 40.0, {});
  hand.begin(hand_settings());
  hand.go_to({0, 0, 0.03});
  hand.go_to({0.01, 0.002, 0.019});  // the lid
  EXPECT_LE((hand.normal() - Vec3(0, 0, 1)).norm(), 1e-6);
  hand.go_to({0, 0, 0.03});
  hand.go_to({0.05, 0, 0.03});
  hand.go_to({0.05, 0, 0.001});
  double rough = 0.0;
  double smooth = 0.0;
  for (int tick = 0; tick < 2000; ++tick) {
    const double angle = 2 * std::numbers::pi * tick / 2000;
    const Vec3 radial(std::cos(angle), std::sin(angle), 0);
    hand.go_to((0.95 * kRadius_m) * radial + Vec3(0, 0, 0.003));
    if (!hand.record().contact) continue;
    const Vec3 facet = (hand.proxy() - hand.goal()).normalized();
    rough = std::max(rough, (facet - radial).norm());
    smooth = std::max(smooth, (hand.normal() - radial).norm());
  }
  EXPECT_GT(rough, 0.15);
  EXPECT_LT(smooth, 0.1 * rough);
}

TEST(Shading, KeepsTheRatioOfFriction) {
  Random random(6805);
  const Soup soup = test::soup_of(icosphere(3, 0.05));
  for (int run = 0; run < 10; ++run) {
    const double mu = random.uniform(0.1, 1.0);
    const RigidTransform pose = random.pose(0.3);
    const Entries friction = {effect_entry<FrictionEffect>({mu, mu, nullptr})};
    BodyHand with = shaded(soup, 60.0, pose, friction);
    with.begin(hand_settings());
    BodyHand without = faceted(soup, pose, friction);
    without.begin(hand_settings());
    const Vec3 u = random.unit_vector();
    const Vec3 v = u.cross(random.unit_vector()).normalized();
    with.go_to(0.06 * u);
    without.go_to(0.06 * u);
    for (int tick = 0; tick < 2000; ++tick) {
      const double angle = 0.002 * tick;
      const Vec3 goal = 0.048 * (std::cos(angle) * u + std::sin(angle) * v);
      with.go_to(goal);
      without.go_to(goal);
      ASSERT_EQ(vec3(with.record().proxy_scene_m), vec3(without.record().proxy_scene_m));
      const double press = with.force().dot(with.normal());
      const double side = (with.force() - press * with.normal()).norm();
      const double faceted_press = without.force().dot(without.normal());
      const double faceted_side = (without.force() - faceted_press * without.normal()).norm();
      ASSERT_NEAR(press, faceted_press, 1e-12 + 1e-12 * press);
      ASSERT_NEAR(side, faceted_side, 1e-11 + 1e-11 * press);
      // At edges between facets, the proxy has more than one plane and a lag along both.
      ASSERT_TRUE(tick < 500 || side <= mu * press * (1 + 1e-9));
    }
  }
}

}  // namespace
}  // namespace palpate
