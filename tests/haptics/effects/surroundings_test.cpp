// Effects that act off contact, too: media, magnets and gravity. Compared with closed forms, in
// random poses.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/effects/gravity.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/stiffness.h"
#include "haptics/effects/viscosity.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::box_soup;
using test::effect_entry;
using test::hand_settings;
using test::kEpsilon;
using test::kTick_s;
using test::OwnedBodies;
using test::Random;
using test::SmoothLoop;
using test::Soup;
using test::square_soup;

// A tiny body far from everything, because a world needs a body.
Soup speck() {
  Soup soup;
  soup.add({0.5, 0.5, 0.5}, {0.51, 0.5, 0.5}, {0.5, 0.51, 0.5});
  soup.add({-0.5, -0.5, -0.5}, {-0.51, -0.5, -0.5}, {-0.5, -0.51, -0.5});
  return soup;
}

AffineMap inverse_of(const RigidTransform& pose) {
  return {pose.rotation.conjugate().toRotationMatrix(),
          pose.rotation.conjugate() * Vec3(-pose.translation_m)};
}

// ---- viscosity ---------------------------------------------------------------------------------

// A medium in the hand's frame, away from all surfaces.
class Medium {
 public:
  Medium(const MediumRegion& region, double viscosity, const RigidTransform& pose)
      : hand({speck()}, pose), viscosity_(viscosity) {
    EffectProgram& program = hand.effects.builder.program;
    program.media.push_back(region);
    program.media.back().p_region_solver = inverse_of(pose);
    hand.effects.builder.add_surroundings(
        effect_entry<ViscosityEffect>({viscosity, &program.media.back()}));
    hand.effects.add_body_without_effects();
    hand.begin(hand_settings());
  }

  // True if the force is the drag of the whole motion since last_m, or zero outside. Region frame.
  testing::AssertionResult drags(const Vec3& last_m, const Vec3& p_m, bool expected,
                                 double dt_s = kTick_s) const {
    const Vec3 drag = expected ? Vec3(-viscosity_ * (p_m - last_m) / dt_s) : Vec3(Vec3::Zero());
    const double rounding =
        viscosity_ / dt_s * 16 * kEpsilon * (hand.pose().translation_m.norm() + 1);
    if ((hand.force() - drag).norm() <= (expected ? rounding : 0.0)) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << hand.force().transpose() << " instead of "
                                       << drag.transpose() << " at " << p_m.transpose();
  }

  BodyHand hand;

 private:
  double viscosity_;
};

MediumRegion box_region(const Vec3& half_m) {
  MediumRegion region;
  region.shape = MediumRegion::Shape::kBox;
  region.half_m = half_m;
  return region;
}

MediumRegion sphere_region(double radius_m) {
  MediumRegion region;
  region.shape = MediumRegion::Shape::kSphere;
  region.half_m.x() = radius_m;
  return region;
}

TEST(Viscosity, DragsInsideABoxOrSphereAndNowhereElse) {
  Random random(6201);
  int inside_ticks = 0;
  int outside_ticks = 0;
  for (int run = 0; run < 60; ++run) {
    const bool is_box = run % 2 == 0;
    const Vec3 half(random.uniform(0.01, 0.05), random.uniform(0.01, 0.05), 0.03);
    Medium medium(is_box ? box_region(half) : sphere_region(half.x()), random.uniform(0.1, 20.0),
                  random.pose(0.5));
    Vec3 p = random.in_box(0.06);
    medium.hand.go_to(p);
    EXPECT_EQ(medium.hand.force(), Vec3(0, 0, 0));  // the velocity is not known yet
    Vec3 heading = random.in_box(3e-4);
    for (int tick = 0; tick < 2000; ++tick) {
      const Vec3 last = p;
      if (tick % 50 == 0) heading = random.in_box(2e-3);
      if (tick % 50 > 40) heading.setZero();  // sometimes at rest
      p = (p + heading).cwiseMax(-0.07).cwiseMin(0.07);
      const double dt_s = random.uniform(5e-4, 2e-3);
      medium.hand.go_to(p, dt_s);
      const double height =
          is_box ? (p.cwiseAbs() - half).maxCoeff() : p.norm() - half.x();  // sign: inside or not
      if (std::abs(height) < 1e-12) continue;
      ASSERT_TRUE(medium.drags(last, p, height < 0.0, dt_s)) << tick;
      ASSERT_EQ(medium.hand.has_active_effect(test::effect_number<ViscosityEffect>()),
                height < 0.0);
      ++(height < 0.0 ? inside_ticks : outside_ticks);
    }
  }
  EXPECT_GT(inside_ticks, 1000);
  EXPECT_GT(outside_ticks, 10000);
}

// A closed mesh that is no obstacle. Whether a point is inside is known analytically in each tick.
template <typename IsInside>
void expect_medium_of_mesh(const Soup& soup, Random& random, IsInside is_inside,
                           const std::vector<Vec3>& corners) {
  const SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
  const SurfaceIndex index(mesh);
  MediumRegion region;
  region.shape = MediumRegion::Shape::kThrough;
  region.index = &index;
  int inside_ticks = 0;
  int crossings = 0;
  for (int run = 0; run < 20; ++run) {
    // Half of the runs have no pose, so that paths meet edges and vertices exactly.
    Medium medium(region, random.uniform(0.1, 20.0), run % 2 ? random.pose(0.5) : RigidTransform{});
    Vec3 p = random.in_box(0.06);
    medium.hand.go_to(p);
    bool was_inside = is_inside(p).value_or(false);
    Vec3 target = p;
    for (int tick = 0; tick < 3000; ++tick) {
      const Vec3 last = p;
      if ((target - p).norm() < 1e-9) {
        // Through corners or midpoints of corner pairs and beyond, or anywhere.
        const Vec3& a = corners[random.index(corners.size())];
        const Vec3& b = corners[random.index(corners.size())];
        const Vec3 aim = random.index(2) ? a : Vec3(0.5 * (a + b));
        target = random.index(3) ? Vec3(aim + (aim - p)) : random.in_box(0.06);
        target = target.cwiseMax(-0.08).cwiseMin(0.08);
      }
      const double step = std::min((target - p).norm(), random.index(10) ? 1e-3 : 0.03);
      p += step * (target - p).normalized();
      medium.hand.go_to(p);
      const std::optional<bool> inside = is_inside(p);
      if (!inside) continue;  // on the surface, within the rounding of the pose
      ASSERT_TRUE(medium.drags(last, p, *inside)) << "run " << run << " tick " << tick;
      inside_ticks += *inside;
      crossings += *inside != was_inside;
      was_inside = *inside;
    }
  }
  EXPECT_GT(inside_ticks, 3000);
  EXPECT_GT(crossings, 500);
}

constexpr double kDoubtful_m = 1e-9;

TEST(Viscosity, DragsInsideAClosedMeshWithoutASurface) {
  Random random(6202);
  const Vec3 half(0.04, 0.03, 0.02);
  const Soup box = box_soup(half);
  expect_medium_of_mesh(
      box, random,
      [&](const Vec3& p) -> std::optional<bool> {
        const double height = (p.cwiseAbs() - half).maxCoeff();
        if (std::abs(height) < kDoubtful_m) return std::nullopt;
        return height < 0.0;
      },
      box.positions);
  // A convex mesh: inside is behind every face.
  const TriangleMesh mesh = icosphere(2, 0.05);
  const Soup sphere = test::soup_of(mesh);
  expect_medium_of_mesh(
      sphere, random,
      [&](const Vec3& p) -> std::optional<bool> {
        double height = -1.0;
        for (const Triangle& t : sphere.triangles) {
          const Vec3& a = sphere.positions[t[0]];
          const Vec3 n =
              (sphere.positions[t[1]] - a).cross(sphere.positions[t[2]] - a).normalized();
          height = std::max(height, n.dot(p - a));
        }
        if (std::abs(height) < kDoubtful_m) return std::nullopt;
        return height < 0.0;
      },
      sphere.positions);
  // A ring, without drag in its hole. The mesh lies within its facets' sagitta of the true ring.
  constexpr double kMajor_m = 0.04;
  constexpr double kMinor_m = 0.015;
  const Soup ring = test::soup_of(torus(kMajor_m, kMinor_m, 4));
  expect_medium_of_mesh(
      ring, random,
      [&](const Vec3& p) -> std::optional<bool> {
        const double from_core = std::hypot(std::hypot(p.x(), p.y()) - kMajor_m, p.z());
        if (std::abs(from_core - kMinor_m) < 2e-4) return std::nullopt;
        return from_core < kMinor_m;
      },
      ring.positions);
}

TEST(Viscosity, DragsAProxyInsideAClosedSurfaceAndNoProxyOutside) {
  Random random(6203);
  for (int run = 0; run < 20; ++run) {
    const bool starts_inside = run % 2 == 0;
    const bool is_moved = run % 4 >= 2;
    BodyHand hand({test::soup_of(icosphere(2, 0.05))}, random.pose(0.5));
    EffectProgram& program = hand.effects.builder.program;
    MediumRegion region;
    region.shape = MediumRegion::Shape::kInside;
    program.media.push_back(region);
    const double viscosity = random.uniform(0.1, 10.0);
    hand.effects.builder.add_surroundings(
        effect_entry<ViscosityEffect>({viscosity, &program.media.back()}));
    hand.effects.add_body_without_effects();
    hand.begin(hand_settings());
    Vec3 p = (starts_inside ? 0.02 : 0.06) * random.unit_vector();
    hand.go_to(p);
    int contacts = 0;
    RigidTransform moved = hand.pose();
    for (int tick = 0; tick < 1500; ++tick) {
      const Vec3 last = p;
      p += 1e-3 * random.unit_vector() + (starts_inside ? 2e-4 : -2e-4) * p.normalized();
      if (p.norm() > 0.09) p *= 0.09 / p.norm();
      if (is_moved) {
        moved.translation_m += random.in_box(1e-4);
        moved.rotation = moved.rotation * Quat(Eigen::AngleAxisd(0.01, random.unit_vector()));
        hand.loop().move_body(0, moved);
      }
      hand.go_to(p);
      const Vec3 spring = 1000.0 * (hand.proxy() - hand.goal());
      const Vec3 drag =
          starts_inside ? Vec3(-viscosity * (p - last) / kTick_s) : Vec3(Vec3::Zero());
      ASSERT_LE((hand.force() - spring - drag).norm(), 1e-9) << tick;
      contacts += hand.record().contact;
    }
    EXPECT_GT(contacts, 50);
  }
}

TEST(Viscosity, DissipatesExactlyTheEnergyOfItsLaw) {
  Random random(6204);
  for (int run = 0; run < 20; ++run) {
    const double viscosity = random.uniform(0.1, 20.0);
    Medium medium(sphere_region(0.03), viscosity, random.pose(0.5));
    const SmoothLoop loop(random.in_box(0.01), {0.04, 0.04, 0.04}, random);
    constexpr int kTicks = 400;
    double taken_J = 0.0;
    double expected_J = 0.0;
    double port_J = 0.0;
    for (int k = 0; k < 2 * kTicks; ++k) {
      const auto at = [&](int tick) {
        return loop.at(static_cast<double>(tick % kTicks) / kTicks);
      };
      medium.hand.go_to(at(k));
      if (k < kTicks) continue;
      const Vec3 step = at(k) - at(k - 1);
      taken_J -= medium.hand.force().dot(step);
      if (at(k).norm() <= 0.03) expected_J += viscosity * step.squaredNorm() / kTick_s;
      port_J += medium.hand.force().dot(at(k + 1) - at(k));
    }
    EXPECT_GT(expected_J, 0.0);
    EXPECT_NEAR(taken_J, expected_J, 1e-9 * expected_J);
    EXPECT_LT(port_J, -0.9 * expected_J);
  }
}

// ---- magnets -----------------------------------------------------------------------------------

// Bodies whose whole surface attracts.
void add_magnet(BodyHand& hand, std::uint32_t body, double force_N, double range_m) {
  EffectProgram& program = hand.effects.builder.program;
  // The number of the next material.
  const auto material = static_cast<std::uint32_t>(program.materials.size());
  program.magnets.push_back({body, material, &hand.index(body)});
  hand.effects.add_body({effect_entry<MagnetEffect>({force_N, range_m, &program.magnets.back()})});
}

double well(double force_N, double range_m, double distance_m) {
  const double part = std::max(0.0, 1.0 - distance_m / range_m);
  return force_N * part * part;
}

// The nearest point of an axis-aligned box to a point outside.
Vec3 nearest_of_box(const Vec3& p, const Vec3& half) {
  return p.cwiseMax(-half).cwiseMin(half);
}

TEST(Magnet, AttractsTowardsTheNearestPointByTheLaw) {
  Random random(6301);
  const Vec3 half(0.04, 0.03, 0.02);
  int active = 0;
  int quiet = 0;
  for (int run = 0; run < 40; ++run) {
    const double force_N = random.uniform(0.1, 5.0);
    const double range_m = random.uniform(0.002, 0.02);
    BodyHand hand({box_soup(half)}, random.pose(0.3));
    add_magnet(hand, 0, force_N, range_m);
    hand.begin(hand_settings());
    // A walk at various speeds, with rests: a body once known to be out of range may come into
    // range.
    Vec3 p(0.07, 0, 0);
    hand.go_to(p);
    double pace = 1e-3;
    for (int tick = 0; tick < 3000; ++tick) {
      if (tick % 20 == 0) pace = std::pow(10.0, random.uniform(-6.0, -2.0));
      if (tick % 7 != 0) {
        p += pace * random.unit_vector() - 0.1 * pace * p.normalized();
        p = p.cwiseMax(-0.08).cwiseMin(0.08);
        const double low = (p.cwiseAbs() - half).maxCoeff();
        if (low < 1e-6) p += 0.004 * p.normalized();
        if ((p.cwiseAbs() - half).maxCoeff() < 1e-6) p = Vec3(0.07, 0, 0);
      }
      hand.go_to(p);
      if (hand.record().contact) {
        p = Vec3(0.07, 0, 0);  // the path led through the body
        hand.go_to(p);
        continue;
      }
      const Vec3 way = nearest_of_box(p, half) - p;
      const Vec3 expected = well(force_N, range_m, way.norm()) * way.normalized();
      ASSERT_LE((hand.force() - expected).norm(),
                16 * kEpsilon * force_N * (1 + hand.pose().translation_m.norm()) / way.norm())
          << "run " << run << " tick " << tick;
      ++(way.norm() < range_m ? active : quiet);
    }
  }
  EXPECT_GT(active, 5000);
  EXPECT_GT(quiet, 5000);
}

TEST(Magnet, ActsOnAHandAtRestForAnyTime) {
  BodyHand hand({square_soup(0.1)}, {});
  add_magnet(hand, 0, 2.0, 0.01);
  hand.begin(hand_settings());
  for (const double height : {0.005, 0.0001, -0.0005}) {
    hand.go_to({0, 0, 0.02});
    for (int tick = 0; tick < 5; ++tick) {
      hand.go_to({0, 0, height});
      const double expected = height > 0 ? -well(2.0, 0.01, height) : 1000.0 * -height - 2.0;
      ASSERT_NEAR(hand.force().z(), expected, 1e-8) << height << " " << tick;
    }
  }
  // Under friction the proxy keeps its place to the bit, even where the quiet ball begins.
  BodyHand stuck({square_soup(0.1)}, {});
  EffectProgram& program = stuck.effects.builder.program;
  program.magnets.push_back({0, 1, &stuck.index()});
  stuck.effects.add_body({effect_entry<MagnetEffect>({2.0, 0.01, &program.magnets.back()}),
                          effect_entry<FrictionEffect>({1.0, 1.0, nullptr})});
  stuck.begin(hand_settings());
  stuck.go_to({0, 0, 0.001});
  for (int tick = 0; tick < 5; ++tick) {
    stuck.go_to({1e-5 * tick, 0, -0.001});
    ASSERT_NEAR(stuck.force().z(), 1.0 - 2.0, 1e-8) << tick;
  }
}

TEST(Magnet, IsSmoothAtTheEndOfItsRangeAndContinuousAtContact) {
  Random random(6303);
  for (int run = 0; run < 20; ++run) {
    const double force_N = random.uniform(0.1, 5.0);
    const double range_m = random.uniform(0.002, 0.02);
    BodyHand hand({square_soup(0.1)}, random.pose(0.3));
    add_magnet(hand, 0, force_N, range_m);
    hand.begin(hand_settings());
    const double step_m = 1e-6 * range_m * 100;
    double last = 0.0;
    double last_change = 0.0;
    for (double z = 1.5 * range_m; z > -0.2 * range_m; z -= step_m) {
      hand.go_to({0.01, 0.02, z});
      const double force = hand.force().z();
      // The steepest slope: 2 F0 / r outside, the spring's K inside.
      const double slope = z > -step_m ? 2 * force_N / range_m + 1000.0 : 1000.0;
      ASSERT_LE(std::abs(force - last), slope * step_m * (1 + 1e-6) + 1e-9) << z / range_m;
      // The slope is continuous except where the spring begins: it changes by 2 F0 / r^2.
      const double change = force - last;
      if (z > step_m && z < 1.5 * range_m - 2 * step_m) {
        ASSERT_LE(std::abs(change - last_change),
                  2 * force_N / (range_m * range_m) * step_m * step_m * (1 + 1e-6) + 1e-10)
            << z / range_m;
      }
      last = force;
      last_change = change;
    }
    EXPECT_NEAR(last + force_N, 1000.0 * 0.2 * range_m, 1000.0 * 2 * step_m);
  }
}

// Around closed loops, in and out of range and contact, the only energy gained is that of holding
// the force for a tick, which is proportional to the square of the step.
TEST(Magnet, AddsNoEnergyAroundALoop) {
  Random random(6304);
  const Vec3 half(0.04, 0.03, 0.02);
  for (int run = 0; run < 20; ++run) {
    const double force_N = random.uniform(0.5, 5.0);
    const double range_m = random.uniform(0.005, 0.02);
    const SmoothLoop loop({0.01, 0.0, half.z() + 0.005}, {0.02, 0.02, 0.0065}, random);
    double gained_J[2];
    double scale_J = 0.0;
    for (const int fine : {0, 1}) {
      BodyHand hand({box_soup(half)}, random.pose(0.3));
      add_magnet(hand, 0, force_N, range_m);
      hand.begin(hand_settings());
      const int ticks = fine ? 8000 : 1000;
      hand.go_to({0.01, 0, 0.06});
      double sum_J = 0.0;
      double rough_J = 0.0;
      for (int k = 0; k < 2 * ticks; ++k) {
        const auto at = [&](int tick) {
          return loop.at(static_cast<double>(tick % ticks) / ticks);
        };
        hand.go_to(at(k));
        const Vec3 step = at(k + 1) - at(k);
        if (k >= ticks) {
          sum_J += hand.force().dot(step);
          rough_J += std::abs(hand.force().dot(step));
        }
      }
      gained_J[fine] = sum_J;
      scale_J = rough_J;
    }
    // The held force of a potential gains at most H dx^2 / 2 per step, with H the potential's
    // curvature: about 1 / ticks of the energy that is exchanged. With eight times the ticks, an
    // eighth is left.
    EXPECT_LT(std::abs(gained_J[0]), 0.03 * scale_J);
    EXPECT_LT(std::abs(gained_J[1]), 0.004 * scale_J);
  }
}

TEST(Magnet, PullsTowardsTheTouchedSurfaceAndHoldsTheHandAtF0OverK) {
  Random random(6305);
  for (int run = 0; run < 30; ++run) {
    const double force_N = random.uniform(0.1, 2.0);
    BodyHand hand({test::soup_of(icosphere(3, 0.05))}, random.pose(0.3));
    add_magnet(hand, 0, force_N, 0.01);
    hand.begin(hand_settings(1000.0, 0.0));
    const Vec3 outwards = random.unit_vector();
    hand.go_to(0.06 * outwards);
    const Vec3 goal = (0.05 - random.uniform(0.001, 0.004)) * outwards;
    for (int tick = 0; tick < 4; ++tick) {
      hand.go_to(goal);
      ASSERT_TRUE(hand.record().contact);
      const Vec3 expected = 1000.0 * (hand.proxy() - hand.goal()) - force_N * hand.normal();
      ASSERT_LE((hand.force() - expected).norm(), 1e-9);
    }
    // The depth at which the spring balances the attraction.
    const Vec3 rest = hand.proxy() - force_N / 1000.0 * hand.normal();
    hand.go_to(rest);
    ASSERT_LE(hand.force().norm(), 1e-8);
  }
}

TEST(Magnet, IsTheSameNextToMovingBodies) {
  Random random(6306);
  const Vec3 half(0.02, 0.02, 0.02);
  int active = 0;
  for (int run = 0; run < 20; ++run) {
    const RigidTransform pose = random.pose(0.1);
    OwnedBodies bodies({{box_soup(half), pose}, {speck(), {}}});
    test::EffectBodies effects;
    EffectProgram& program = effects.builder.program;
    program.magnets.push_back({0, 1, bodies.world().bodies[0].index});
    const double force_N = 2.0;
    const double range_m = 0.01;
    effects.add_body({effect_entry<MagnetEffect>({force_N, range_m, &program.magnets.back()})});
    effects.add_body_without_effects();
    bodies.set_effects(effects.finish());
    auto loop = test::made(HapticLoop::create(
        bodies.world(), ActuationModel::from_counts(3, 3).value(), hand_settings()));
    RigidTransform moved = pose;
    Vec3 p = pose.point({0.05, 0, 0});
    loop.tick(p, kTick_s);
    for (int tick = 0; tick < 2000; ++tick) {
      // The body moves and rests by turns; the hand sometimes rests, too.
      if (tick / 100 % 3 != 0) {
        moved.translation_m += 2e-4 * random.unit_vector();
        moved.rotation = moved.rotation * Quat(Eigen::AngleAxisd(0.02, random.unit_vector()));
        loop.move_body(0, moved);
      }
      const Vec3 away = p - moved.translation_m;
      if (tick / 50 % 3 != 0) {
        p += 3e-4 * random.unit_vector() + 0.05 * (0.032 / away.norm() - 1.0) * away;
      }
      const TickRecord& record = loop.tick(p, kTick_s);
      if (record.contact) {
        // Return to a place out of range. The return may be pushed; this test does not check it.
        p = moved.point({0.05, 0, 0});
        for (int i = 0; i < 2; ++i) loop.tick(p, kTick_s);
        continue;
      }
      const Vec3 local = moved.inverse_point(p);
      const Vec3 way = nearest_of_box(local, half) - local;
      if (way.isZero(0.0)) continue;
      const Vec3 expected = moved.direction(well(force_N, range_m, way.norm()) * way.normalized());
      ASSERT_LE((vec3(record.force_device_N) - expected).norm(), 1e-9 + 1e-15 / way.norm()) << tick;
      active += way.norm() < range_m;
    }
  }
  EXPECT_GT(active, 500);
}

// ---- gravity -----------------------------------------------------------------------------------

TEST(Gravity, IsConstantInTheSceneAndTurnsWithIt) {
  Random random(6401);
  for (int run = 0; run < 10; ++run) {
    OwnedBodies bodies({{square_soup(0.1), {}}});
    test::EffectBodies effects;
    const double mass = random.uniform(0.01, 0.2);
    const Vec3 gravity = 9.81 * random.unit_vector();
    const Vec3 field = random.in_box(1.0);
    effects.builder.add_surroundings(effect_entry<GravityEffect>(
        {mass, {gravity.x(), gravity.y(), gravity.z()}, {field.x(), field.y(), field.z()}}));
    effects.add_body_without_effects();
    bodies.set_effects(effects.finish());
    HapticSettings s = hand_settings();
    s.a4.enabled = true;
    s.initial_pose.rotation = Eigen::AngleAxisd(0.25 * std::numbers::pi, Vec3::UnitY());
    const Vec3 weight = mass * gravity + field;
    auto loop = test::made(
        HapticLoop::create(bodies.world(), ActuationModel::from_counts(3, 1).value(), s));
    const Vec3 normal_device = s.initial_pose.rotation * Vec3::UnitZ();
    Vec3 first = Vec3::Zero();
    Vec3 last = Vec3::Zero();
    for (int tick = 0; tick < 1000; ++tick) {
      const Vec3 p = (tick < 10 ? 0.001 : -0.002) * normal_device;
      const TickRecord& record = loop.tick(p, kTick_s);
      const Vec3 spring = 1000.0 * (vec3(record.proxy_scene_m) - vec3(record.goal_scene_m));
      const Vec3 expected = pose_before(record).rotation * Vec3(spring + weight);
      ASSERT_LE((vec3(record.full_force_device_N) - expected).norm(), 1e-9);
      if (tick == 0) first = pose_before(record).rotation * weight;
      last = pose_before(record).rotation * weight;
    }
    EXPECT_GT((last - first).norm(), 0.0);  // A4 has turned the scene
  }
}

}  // namespace
}  // namespace palpate
