// Combined effects: order, bounds, counters, tuning and faults.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"
#include "tests/helpers/all_effects.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::AllEffects;
using test::BodyHand;
using test::effect_entry;
using test::effect_number;
using test::hand_settings;
using test::kNan;
using test::kTick_s;
using test::Random;
using test::square_soup;
using test::Wander;

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0;
}

testing::AssertionResult is_same(const TickRecord& a, const TickRecord& b) {
  if (same_bits(vec3(a.force_device_N), vec3(b.force_device_N)) &&
      same_bits(vec3(a.proxy_scene_m), vec3(b.proxy_scene_m)) &&
      same_bits(vec3(a.normal_scene), vec3(b.normal_scene)) && a.contact == b.contact &&
      a.faults == b.faults && a.alpha_rad == b.alpha_rad && a.iterations == b.iterations) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure()
         << "force " << vec3(a.force_device_N).transpose() << " and "
         << vec3(b.force_device_N).transpose() << ", proxy " << vec3(a.proxy_scene_m).transpose()
         << " and " << vec3(b.proxy_scene_m).transpose() << ", normal "
         << vec3(a.normal_scene).transpose() << " and " << vec3(b.normal_scene).transpose();
}

BodyHand all_effects(const RigidTransform& pose, const std::vector<std::size_t>& order = {},
                     bool with_gravity = true) {
  BodyHand hand({AllEffects::sphere(), AllEffects::plate()}, pose);
  AllEffects::add_to(hand, order, with_gravity);
  return hand;
}

TEST(Effects, DoNotDependOnTheOrderOfTheirDeclaration) {
  Random random(6901);
  std::uint32_t active = 0;
  for (int run = 0; run < 20; ++run) {
    const RigidTransform pose = random.pose(0.3);
    std::vector<std::size_t> order(AllEffects::kEntries);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
    BodyHand a = all_effects(pose);
    BodyHand b = all_effects(pose, order);
    a.begin(hand_settings());
    b.begin(hand_settings());
    Wander wander(random, 0.046, 0.07);
    for (int tick = 0; tick < 2000; ++tick) {
      const Vec3& p = wander.next();
      const double dt_s = random.uniform(5e-4, 2e-3);
      ASSERT_TRUE(is_same(a.go_to(p, dt_s), b.go_to(p, dt_s))) << run << " " << tick;
      ASSERT_EQ(a.record().effects, b.record().effects);
      active |= a.record().effects;
    }
  }
  EXPECT_EQ(active, (1u << compiled_effects().size()) - 1) << "see AllEffects";
}

// Next to a body with all effects, a body without effects is rendered as if there were no effects.
TEST(Effects, AreInactiveOnABodyWithoutEffects) {
  Random random(6902);
  int contacts = 0;
  for (int run = 0; run < 10; ++run) {
    const RigidTransform pose = random.pose(0.3);
    BodyHand with = all_effects(pose, {}, false);
    BodyHand without({AllEffects::sphere(), AllEffects::plate()}, pose);
    with.begin(hand_settings(1000.0, 2.0));
    without.begin_without_effects(hand_settings(1000.0, 2.0));
    Vec3 p(0, 0, AllEffects::kPlate_m + 0.003);
    for (int tick = 0; tick < 3000; ++tick) {
      p += random.in_box(5e-4);
      const Vec3 middle(0, 0, AllEffects::kPlate_m);
      p = p.cwiseMax(middle - Vec3(0.09, 0.09, 0.004)).cwiseMin(middle + Vec3(0.09, 0.09, 0.004));
      ASSERT_TRUE(is_same(with.go_to(p), without.go_to(p))) << run << " " << tick;
      ASSERT_EQ(with.record().effects, 0u);
      contacts += with.record().contact;
    }
  }
  EXPECT_GT(contacts, 3000);
}

// A material with the loop's own coupling is rendered like one without effects: to the bit with one
// touched face, and up to the rounding of shares with more.
TEST(Effects, WithTheLoopsParametersChangeNothing) {
  Random random(6903);
  constexpr double kSharesRoundoff = 8 * std::numeric_limits<double>::epsilon();
  const auto ring = test::soup_of(torus(0.05, 0.02, 2));
  int contacts = 0;
  for (int run = 0; run < 10; ++run) {
    const RigidTransform pose = random.pose(0.3);
    BodyHand with({ring}, pose);
    with.effects.add_body({effect_entry<StiffnessEffect>({900.0}),
                           effect_entry<DampingEffect>({1.5}),
                           effect_entry<FrictionEffect>({0.0, 0.0, nullptr}),
                           effect_entry<VibrationEffect>({80.0, 0.0, 0.0})});
    BodyHand without({ring}, pose);
    with.begin(hand_settings(900.0, 1.5));
    without.begin_without_effects(hand_settings(900.0, 1.5));
    Vec3 p(0.08, 0, 0);
    for (int tick = 0; tick < 3000; ++tick) {
      const Vec3 core = 0.05 * Vec3(p.x(), p.y(), 0).normalized();
      p += 5e-4 * random.unit_vector() +
           0.02 * (0.018 - (p - core).norm()) * (p - core).normalized();
      with.go_to(p);
      without.go_to(p);
      const Vec3& plain_N = vec3(without.record().force_device_N);
      ASSERT_LE((vec3(with.record().force_device_N) - plain_N).norm(),
                kSharesRoundoff * plain_N.norm());
      ASSERT_TRUE(
          same_bits(vec3(with.record().proxy_scene_m), vec3(without.record().proxy_scene_m)));
      contacts += with.record().contact;
    }
  }
  EXPECT_GT(contacts, 3000);
}

TEST(Effects, AreCountedInTheTicksInWhichTheyAreActive) {
  Random random(6904);
  BodyHand hand = all_effects(random.pose(0.3));
  hand.begin(hand_settings());
  Wander wander(random, 0.044, 0.08);
  const auto bit = [&](std::uint16_t effect) { return hand.has_active_effect(effect); };
  std::array<std::uint64_t, kMostEffects> counted{};
  for (int tick = 0; tick < 20000; ++tick) {
    const Vec3 p = wander.next();
    hand.go_to(p);
    for (std::size_t i = 0; i < kMostEffects; ++i) {
      counted[i] += hand.record().effects >> i & 1u;
    }
    const bool contact = hand.record().contact;
    ASSERT_EQ(bit(effect_number<StiffnessEffect>()), contact);
    ASSERT_EQ(bit(effect_number<DampingEffect>()), contact);
    ASSERT_EQ(bit(effect_number<TextureEffect>()), contact);
    ASSERT_EQ(bit(effect_number<ShadingEffect>()), contact);
    ASSERT_TRUE(bit(effect_number<GravityEffect>()));
    const double out_m = hand.proxy().norm();
    // The distance to the mesh, which lies within its sagitta inside the sphere.
    if (out_m < AllEffects::kRadius_m + AllEffects::kRange_m - 5e-4) {
      ASSERT_TRUE(bit(effect_number<MagnetEffect>())) << tick;
    }
    if (out_m > AllEffects::kRadius_m + AllEffects::kRange_m) {
      ASSERT_FALSE(bit(effect_number<MagnetEffect>())) << tick;
    }
    const double medium_m = AllEffects::kRadius_m + 0.5 * AllEffects::kRange_m;
    if (std::abs(out_m - medium_m) > 1e-9) {
      ASSERT_EQ(bit(effect_number<ViscosityEffect>()), out_m < medium_m) << tick;
    }
  }
  EXPECT_EQ(hand.loop().effect_counters()->ticks, counted);
  for (std::size_t i = 0; i < compiled_effects().size(); ++i) {
    EXPECT_GT(counted[i], 100u) << compiled_effects()[i].name << ": see AllEffects";
  }
}

template <typename Effect>
void tune(BodyHand& hand, const typename Effect::Parameters& parameters) {
  const auto& calls = hand.world().effects->calls;
  for (std::uint32_t call = 0; call < calls.size(); ++call) {
    if (calls[call].effect != effect_number<Effect>()) continue;
    hand.loop().set_effect_parameters(call, std::as_bytes(std::span(&parameters, 1)));
  }
}

TEST(Effects, CanBeTunedFromTheNextTickOn) {
  BodyHand hand({square_soup(0.1)}, {});
  EffectProgram& program = hand.effects.builder.program;
  program.magnets.push_back({0, 1, &hand.index()});
  hand.effects.add_body({effect_entry<StiffnessEffect>({500.0}),
                         effect_entry<MagnetEffect>({1.0, 0.01, &program.magnets.back()})});
  hand.begin(hand_settings());
  hand.go_to({0, 0, 0.02});
  hand.go_to({0, 0, -0.001});
  EXPECT_NEAR(hand.force().z(), 0.5 - 1.0, 1e-8);
  tune<StiffnessEffect>(hand, {2000.0});
  hand.go_to({0, 0, -0.001});
  EXPECT_NEAR(hand.force().z(), 2.0 - 1.0, 1e-8);
  // For a hand at rest out of range, a larger range takes effect at once.
  for (int tick = 0; tick < 3; ++tick) hand.go_to({0, 0, 0.02});
  EXPECT_EQ(hand.force(), Vec3(0, 0, 0));
  tune<MagnetEffect>(hand, {1.0, 0.04, &hand.world().effects->magnets.back()});
  hand.go_to({0, 0, 0.02});
  EXPECT_NEAR(hand.force().z(), -0.25, 1e-9);
}

// After a fault, the next good sample continues; rates and times begin as if it were the first
// sample. Friction has a single coefficient here: with two, a sliding contact would stick after a
// fault and end elsewhere.
TEST(Effects, ContinueAfterBadSamples) {
  Random random(6906);
  for (int run = 0; run < 20; ++run) {
    BodyHand hand = all_effects(random.pose(0.3));
    BodyHand twin = all_effects(hand.pose());
    hand.begin(hand_settings());
    twin.begin(hand_settings());
    for (BodyHand* h : {&hand, &twin}) {
      tune<FrictionEffect>(*h, {0.5, 0.5, &h->world().effects->maps.back()});
    }
    Wander wander(random, 0.046, 0.07);
    std::uint32_t faults = 0;
    for (int tick = 0; tick < 4000; ++tick) {
      const Vec3 p = wander.next();
      bool after_fault = false;
      if (tick > 0 && random.index(50) == 0) {
        const double bad =
            std::array{kNan, std::numeric_limits<double>::infinity(), -0.0, -1e-3}[random.index(4)];
        switch (random.index(3)) {
          case 0:
            hand.go_to(Vec3(p.x(), kNan, p.z()), kTick_s);
            break;
          case 1:
            hand.go_to(p, bad);
            break;
          default:
            hand.go_to(p + 40.0 * random.unit_vector(), kTick_s);
        }
        ASSERT_NE(hand.record().faults, 0u);
        ASSERT_EQ(vec3(hand.record().force_device_N), Vec3(0, 0, 0));
        ASSERT_EQ(hand.record().effects, 0u);
        faults |= hand.record().faults;
        after_fault = true;
      }
      hand.go_to(p);
      twin.go_to(p);
      ASSERT_EQ(hand.record().faults & kFaultsWithoutForce, 0u);
      ASSERT_TRUE(vec3(hand.record().force_device_N).allFinite());
      ASSERT_TRUE(vec3(hand.record().proxy_scene_m).allFinite());
      // The position is kept; rates, pulses and vibrations begin again.
      ASSERT_TRUE(same_bits(vec3(hand.record().proxy_scene_m), vec3(twin.record().proxy_scene_m)))
          << tick;
      if (after_fault) {
        // No effect that needs two samples is active.
        ASSERT_FALSE(hand.has_active_effect(effect_number<RestitutionEffect>()));
        const Vec3 still = hand.force();
        ASSERT_LE(still.norm(), 800.0 * 0.02 + 2.0);  // the spring, and effects without a rate
      }
    }
    EXPECT_EQ(faults, kFaultNonFiniteSample | kFaultBadTimeStep | kFaultJump);
    // At the end both records are equal, except for the vibration's phase.
    for (int tick = 0; tick < 100; ++tick) {
      hand.go_to({0.055, 0, 0});
      twin.go_to({0.055, 0, 0});
    }
    EXPECT_LE((hand.force() - twin.force()).norm(), 1e-12);
  }
}

TEST(Effects, ForcesStayFiniteAndBoundedAtAllSpeeds) {
  Random random(6907);
  BodyHand hand = all_effects(random.pose(0.3));
  hand.begin(hand_settings());
  for (int tick = 0; tick < 50000; ++tick) {
    // A hand that moves at random.
    const double dt_s = std::pow(10.0, random.uniform(-6.0, 0.0));
    const Vec3 p = random.index(3) ? Vec3(0.05 * random.unit_vector()) : random.in_box(0.1);
    hand.go_to(p, dt_s);
    ASSERT_TRUE(vec3(hand.record().force_device_N).allFinite());
    ASSERT_TRUE(vec3(hand.record().proxy_scene_m).allFinite());
    ASSERT_TRUE(vec3(hand.record().normal_scene).allFinite());
  }
}

}  // namespace
}  // namespace palpate
