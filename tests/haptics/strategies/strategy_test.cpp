// Names of strategies, and what a named strategy changes in the bits of a loop.

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/check_settings.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "haptics/strategies/a4_passive.h"
#include "haptics/strategies/anisotropic.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::OwnedWorld;
using test::Random;

const char* const kNames[] = {"none", "mask", "full", "a4", "a4-anticipate", "cd"};

Strategy strategy(std::string_view name) {
  const auto parsed = parse_strategy(name);
  EXPECT_TRUE(parsed) << name;
  return parsed ? *parsed : Strategy{};
}

HapticSettings settings_of(const Strategy& strategy) {
  HapticSettings settings;
  settings.coupling = {1000.0, 1.0};
  set_strategy(strategy, settings);
  return settings;
}

TEST(StrategyNames, AreReadAndWritten) {
  for (const char* name : kNames) EXPECT_EQ(name_of(strategy(name)), name);
  for (const StrategyType* type : strategies()) {
    if (type->parameter) continue;
    EXPECT_NE(std::find(std::begin(kNames), std::end(kNames), type->name), std::end(kNames))
        << type->name << ": CONTRIBUTING.md states which tests list the strategies";
  }
  EXPECT_EQ(strategy("mask"), Strategy{});
  EXPECT_EQ(strategy("anisotropic:4"), (Strategy{&kAnisotropicStrategy, 4.0}));
  EXPECT_EQ(strategy("anisotropic:+2.5e-1"), (Strategy{&kAnisotropicStrategy, 0.25}));
  EXPECT_EQ(name_of({&kAnisotropicStrategy, 1.0 / 16}), "anisotropic:0.0625");
  EXPECT_EQ(strategy("a4-passive:0"), (Strategy{&kA4PassiveStrategy, 0.0}));
  EXPECT_EQ(strategy("a4-passive:2.5"), (Strategy{&kA4PassiveStrategy, 2.5}));
}

TEST(StrategyNames, MayLeaveOutANumberThatTheirTypeStates) {
  EXPECT_EQ(strategy("a4-passive"), (Strategy{&kA4PassiveStrategy, 10.0}));
  EXPECT_EQ(name_of(strategy("a4-passive")), "a4-passive:10");
  EXPECT_EQ(name_with_symbol(kA4PassiveStrategy), "a4-passive[:mJ]");
  EXPECT_EQ(name_with_symbol(kAnisotropicStrategy), "anisotropic:E");
}

TEST(StrategyNames, KeepEveryBitOfTheAnisotropy) {
  Random random(11);
  for (int n = 0; n < 10000; ++n) {
    const Strategy written{&kAnisotropicStrategy,
                           random.uniform(kAnisotropicStrategy.parameter->least,
                                          kAnisotropicStrategy.parameter->most)};
    ASSERT_EQ(strategy(name_of(written)), written);
  }
}

TEST(StrategyNames, AreReadAlikeInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* locale : {"de_DE.UTF-8", "de_DE.utf8", "C"}) {
    if (std::setlocale(LC_ALL, locale) == nullptr) continue;
    EXPECT_EQ(strategy("anisotropic:0.5").parameter, 0.5) << locale;
    EXPECT_FALSE(parse_strategy("anisotropic:0,5")) << locale;
    EXPECT_EQ(name_of({&kAnisotropicStrategy, 0.5}), "anisotropic:0.5") << locale;
  }
  std::setlocale(LC_ALL, before.c_str());
}

TEST(StrategyNames, AreRefusedWithTheReason) {
  for (const char* name : {"",
                           "Mask",
                           "mask ",
                           "a4_anticipate",
                           "anisotropic",
                           "anisotropic:",
                           "anisotropic:0",
                           "anisotropic:-1",
                           "anisotropic:0.062",
                           "anisotropic:16.1",
                           "anisotropic:nan",
                           "anisotropic:inf",
                           "anisotropic:0x1p0",
                           "anisotropic:1 ",
                           "anisotropic: 1",
                           "anisotropic:1;",
                           "anisotropic:+-1",
                           "anisotropic:1e999",
                           "anisotropic:2e",
                           "a4-passive:",
                           "a4-passive:-1",
                           "a4-passive:1001",
                           "a4-passive:1mJ",
                           "a4-passive[:mJ]"}) {
    const auto parsed = parse_strategy(name);
    ASSERT_FALSE(parsed) << name;
    EXPECT_EQ(parsed.error().element, "strategy");
    EXPECT_EQ(parsed.error().problem.rfind("is \"" + std::string(name) + "\"; expected ", 0), 0u)
        << parsed.error().problem;
  }
  const auto hostile = parse_strategy(std::string("mask\nx\x1b[2J") + std::string(1000, 'a'));
  ASSERT_FALSE(hostile);
  EXPECT_LT(hostile.error().to_string().size(), 200u);
  EXPECT_EQ(hostile.error().to_string().find('\x1b'), std::string::npos);
}

// Positions of a hand that begins outside of a box of 0.2 m and wanders in and out of it.
std::vector<Vec3> path_into_box(Random& random) {
  std::vector<Vec3> path{{0.15, 0.0, 0.0}};
  Vec3 aim = path.front();
  for (int n = 0; n < 3000; ++n) {
    if (n % 100 == 0) aim = 0.12 * random.unit_vector();
    path.push_back(path.back() + 0.01 * (aim - path.back()));
  }
  return path;
}

// A device with 2 sensors and a motor, or with 3 sensors and one or two motors.
ActuationModel motors_anywhere(Random& random) {
  if (random.index(2)) {
    const double angle = random.uniform(-3.0, 3.0);
    return *ActuationModel::from_axes(2, {Vec3(std::cos(angle), std::sin(angle), 0.0)});
  }
  std::vector<Vec3> axes{random.unit_vector()};
  if (random.index(2)) axes.push_back(random.unit_vector());
  return *ActuationModel::from_axes(3, axes);
}

struct Equivalent {
  const char* name;
  ForceMode force;
  bool a4;
};
constexpr Equivalent kEquivalents[] = {{"none", ForceMode::kNone, false},
                                       {"mask", ForceMode::kActuated, false},
                                       {"full", ForceMode::kFull, false},
                                       {"a4", ForceMode::kActuated, true}};

TEST(Strategies, ThatForceAndA4DescribeGiveTheirBits) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  int contacts = 0;
  for (const Equivalent& e : kEquivalents) {
    Random random(21);
    for (int run = 0; run < 4; ++run) {
      const ActuationModel device = motors_anywhere(random);
      HapticSettings stated = settings_of(strategy("cd"));  // leaves nothing behind
      set_strategy(strategy(e.name), stated);
      HapticSettings plain;
      plain.coupling = stated.coupling;
      plain.force = e.force;
      plain.a4.enabled = e.a4;
      auto a = test::made(HapticLoop::create(world.world(), device, stated));
      auto b = test::made(HapticLoop::create(world.world(), device, plain));
      for (const Vec3& p : path_into_box(random)) {
        const TickRecord& record = a.tick(p, kTick_s);
        ASSERT_EQ(std::memcmp(&record, &b.tick(p, kTick_s), sizeof record), 0) << e.name;
        contacts += record.contact;
      }
    }
  }
  EXPECT_GT(contacts, 5000);
}

TEST(Strategies, OfAnisotropyOneEqualMaskButForTheFullForce) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  Random random(22);
  int contacts = 0;
  for (int run = 0; run < 8; ++run) {
    const ActuationModel device = motors_anywhere(random);
    auto a = test::made(
        HapticLoop::create(world.world(), device, settings_of({&kAnisotropicStrategy, 1.0})));
    auto b = test::made(HapticLoop::create(world.world(), device, settings_of(strategy("mask"))));
    for (const Vec3& p : path_into_box(random)) {
      TickRecord record = a.tick(p, kTick_s);
      const TickRecord& expected = b.tick(p, kTick_s);
      const Vec3 full_N = vec3(record.full_force_device_N);
      const Vec3 mask_N = vec3(expected.full_force_device_N);
      std::memcpy(record.full_force_device_N, expected.full_force_device_N,
                  sizeof record.full_force_device_N);
      ASSERT_EQ(std::memcmp(&record, &expected, sizeof record), 0);
      contacts += record.contact;
      // The part in the span of the normals, also in edges and corners: some roundings of the force
      // and of the normals' basis.
      ASSERT_LE((full_N - mask_N).norm(), 0x1p-46 * mask_N.norm());
    }
  }
  EXPECT_GT(contacts, 5000);
}

// Every other strategy differs from mask, so that the tests above cannot pass by chance.
TEST(Strategies, WithAStepOfTheirOwnDifferFromMask) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (const char* name : {"a4-anticipate", "a4-passive:10", "anisotropic:4", "cd"}) {
    Random random(23);
    const ActuationModel device = *ActuationModel::from_axes(3, {Vec3(0.6, 0.8, 0.0)});
    auto a = test::made(HapticLoop::create(world.world(), device, settings_of(strategy(name))));
    auto b = test::made(HapticLoop::create(world.world(), device, settings_of(strategy("mask"))));
    bool differs = false;
    for (const Vec3& p : path_into_box(random)) {
      const TickRecord& record = a.tick(p, kTick_s);
      differs = differs || std::memcmp(record.force_device_N, b.tick(p, kTick_s).force_device_N,
                                       sizeof record.force_device_N) != 0;
    }
    EXPECT_TRUE(differs) << name;
  }
}

// A loop keeps its strategy: a switch of the force or of A4 changes no bit.
TEST(Strategies, WithAStepOfTheirOwnIgnoreSwitches) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (const char* name : {"a4-anticipate", "anisotropic:4", "cd"}) {
    Random random(24);
    const ActuationModel device = *ActuationModel::from_counts(2, 1);
    auto switched =
        test::made(HapticLoop::create(world.world(), device, settings_of(strategy(name))));
    auto left = test::made(HapticLoop::create(world.world(), device, settings_of(strategy(name))));
    int n = 0;
    for (const Vec3& p : path_into_box(random)) {
      switched.set_a4(n % 3 == 0);
      switched.set_force(static_cast<ForceMode>(n++ % 3));
      const TickRecord& record = switched.tick(p, kTick_s);
      ASSERT_EQ(std::memcmp(&record, &left.tick(p, kTick_s), sizeof record), 0) << name;
    }
  }
}

TEST(StrategySettings, ThatContradictTheForceOrA4AreRefused) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  const auto error_of = [&](const HapticSettings& settings) {
    const auto error = check_settings(world.world(), settings);
    return error ? error->to_string() : "";
  };
  for (const char* name : {"a4-anticipate", "anisotropic:4", "cd"}) {
    HapticSettings settings = settings_of(strategy(name));
    EXPECT_EQ(error_of(settings), "") << name;
    settings.force = ForceMode::kFull;
    EXPECT_NE(error_of(settings).find("strategy: is " + std::string(name)), std::string::npos);
    settings = settings_of(strategy(name));
    settings.a4.enabled = !settings.a4.enabled;
    EXPECT_NE(error_of(settings).find("contradicts"), std::string::npos) << name;
    const auto loop =
        HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), settings);
    ASSERT_FALSE(loop.ok()) << name;
    EXPECT_EQ(loop.error().to_string(), error_of(settings));
  }
  HapticSettings settings = settings_of(strategy("mask"));
  settings.strategy = strategy("mask");
  EXPECT_NE(error_of(settings).find("contradicts"), std::string::npos);
  settings = settings_of(strategy("anisotropic:4"));
  settings.god_object.radius_m = 1e-3;
  const OwnedWorld for_spheres(test::box_soup(Vec3::Constant(0.1)), {}, 1e-3);
  const auto error = check_settings(for_spheres.world(), settings);
  ASSERT_TRUE(error);
  EXPECT_NE(error->problem.find("is for a point"), std::string::npos) << error->to_string();
  settings = settings_of({&kAnisotropicStrategy, 17.0});
  EXPECT_NE(error_of(settings).find("expected a number from"), std::string::npos);
  settings = settings_of(strategy("a4-anticipate"));
  settings.anticipation.range_m = 0.0;
  EXPECT_NE(error_of(settings).find("anticipation.range_m"), std::string::npos);
}

}  // namespace
}  // namespace palpate
