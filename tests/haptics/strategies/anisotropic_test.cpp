// The strategy anisotropic:E against closed formulas: the force of a plane, the work round a loop,
// and the certificate in the norm of W.

#include "haptics/strategies/anisotropic.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/check_settings.h"
#include "haptics/effects/damping.h"
#include "haptics/effects/stiffness.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::OwnedWorld;
using test::Random;

constexpr double kAnisotropies[] = {1.0 / 16, 0.25, 1.0, 4.0, 16.0};
constexpr double kStiffness_N_per_m = 1000.0;

HapticSettings anisotropic_settings(double anisotropy) {
  HapticSettings settings;
  settings.coupling = {kStiffness_N_per_m, 0.0};
  set_strategy({&kAnisotropicStrategy, anisotropy}, settings);
  return settings;
}

// A rotation that maps z to a direction.
Quat z_to(const Vec3& normal, Random& random) {
  const Quat turn(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), normal));
  return (turn * turn_between(Vec3::UnitZ(), normal)).normalized();
}

// A device with one or two motors in random directions.
ActuationModel device_with_motors(Random& random) {
  std::vector<Vec3> axes{random.unit_vector()};
  if (random.index(2)) axes.push_back(random.unit_vector());
  return *ActuationModel::from_axes(3, axes);
}

// |f| = K d cos a / (cos^2 a + sin^2 a / E), along the projection of the normal. The oracle takes
// the depth d below the plane in which the proxy stops, 7/8 of a stand-off above the surface.
TEST(AnisotropicForce, OfAPlaneIsTheFormula) {
  Random random(31);
  constexpr double kHalf_m = 0.05;
  for (const double E : kAnisotropies) {
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 normal = random.unit_vector();
      const RigidTransform T_device_plane{z_to(normal, random), random.in_box(0.02)};
      const OwnedWorld world(test::sheet_soup(kHalf_m, kHalf_m));
      HapticSettings settings = anisotropic_settings(E);
      settings.initial_pose = T_device_plane;
      const ActuationModel device = device_with_motors(random);
      auto loop = test::made(HapticLoop::create(world.world(), device, settings));
      loop.tick(T_device_plane.point({0, 0, 1e-3}), kTick_s);
      const double depth_m = random.uniform(1e-3, 5e-3);
      TickRecord record = loop.tick(T_device_plane.point({0, 0, -depth_m}), kTick_s);
      const SolverScale scale = SolverScale::of(world.world().size_m, 0.0);
      const double d_m = depth_m + scale.stop_m;
      const Vec3 along = device.actuated_part(normal);
      const double cos2 = along.squaredNorm();
      const Vec3 expected_N = kStiffness_N_per_m * d_m / (cos2 + (1.0 - cos2) / E) * along;
      const double allowed_N = 1e-9 * kStiffness_N_per_m * d_m;
      ASSERT_LT((vec3(record.force_device_N) - expected_N).norm(), allowed_N) << "E " << E;
      const Vec3 full_N = kStiffness_N_per_m * d_m * normal;
      ASSERT_LT((vec3(record.full_force_device_N) - full_N).norm(), allowed_N) << "E " << E;
      // The proxy rests: with the same goal, it keeps its place.
      const Vec3 proxy = vec3(record.proxy_scene_m);
      record = loop.tick(T_device_plane.point({0, 0, -depth_m}), kTick_s);
      ASSERT_LT((vec3(record.proxy_scene_m) - proxy).norm(), 2 * scale.stand_off_m);
    }
  }
}

// The work of the port round a square in the plane of the motor and the normal.
TEST(AnisotropicForce, DoesTheWorkOfItsCurlRoundALoop) {
  Random random(32);
  constexpr double kSide_m = 2e-3;
  constexpr int kSteps = 1000;
  for (const double E : kAnisotropies) {
    for (const double angle_deg : {15.0, 40.0, 75.0}) {
      const double a = angle_deg * test::kDeg;
      const Vec3 a1 = Vec3::UnitX();
      const Vec3 v = (Quat(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), a1)) * Vec3::UnitY());
      const Vec3 normal = std::cos(a) * a1 + std::sin(a) * v;
      const OwnedWorld world(test::sheet_soup(0.1, 0.1));
      HapticSettings settings = anisotropic_settings(E);
      settings.initial_pose = {z_to(normal, random), Vec3::Zero()};
      auto loop = test::made(
          HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), settings));
      loop.tick(1e-3 * normal, kTick_s);
      const Vec3 at_m = -5e-3 * normal;
      const Vec3 corners[] = {at_m, at_m + kSide_m * a1, at_m + kSide_m * (a1 + v),
                              at_m + kSide_m * v, at_m};
      Vec3 force_N = vec3(loop.tick(at_m, kTick_s).force_device_N);
      Vec3 from = at_m;
      double work_J = 0.0;
      for (int side = 0; side < 4; ++side) {
        for (int i = 1; i <= kSteps; ++i) {
          const double part = static_cast<double>(i) / kSteps;
          const Vec3 to = corners[side] + part * (corners[side + 1] - corners[side]);
          const Vec3 next_N = vec3(loop.tick(to, kTick_s).force_device_N);
          work_J += 0.5 * (force_N + next_N).dot(to - from);
          force_N = next_N;
          from = to;
        }
      }
      const double weighted = std::pow(std::cos(a), 2) + std::pow(std::sin(a), 2) / E;
      const double expected_J =
          kStiffness_N_per_m * kSide_m * kSide_m * std::sin(a) * std::cos(a) / weighted;
      EXPECT_NEAR(work_J, expected_J, 0.01 * expected_J) << "E " << E << ", " << angle_deg;
    }
  }
}

// W in long double, from its definition.
using Wide = long double;
using WideMat3 = Eigen::Matrix<Wide, 3, 3>;
WideMat3 weights(double E, const ActuationModel& device) {
  WideMat3 P = WideMat3::Zero();
  for (int i = 0; i < device.actuators(); ++i) {
    const Eigen::Matrix<Wide, 3, 1> axis = device.actuated_axis(i).cast<Wide>();
    P += axis * axis.transpose();
  }
  return WideMat3::Identity() + (Wide{E} - 1) * (WideMat3::Identity() - P);
}

// The nearest points of a line and of a plane: what is left of the vector is orthogonal to them in
// the norm of W.
TEST(AnisotropicNorm, FindsTheNearestPointsOfLinesAndPlanes) {
  Random random(34);
  for (int n = 0; n < 10000; ++n) {
    const ActuationModel device = device_with_motors(random);
    const double E = std::pow(16.0, random.uniform(-1.0, 1.0));
    const AnisotropicNorm norm = anisotropic_norm(E, device, Mat3::Identity());
    const Mat3 W = weights(E, device).cast<double>();
    const Vec3 v = random.in_box(1.0);
    const Vec3 line = random.unit_vector();
    const double rounding = 16 * 64 * 0x1p-52;  // the norm weighs a rounding by up to 16
    ASSERT_NEAR(norm.length(v), std::sqrt(v.dot(W * v)), rounding);
    const Vec3 on_line = norm.along(v, line);
    ASSERT_LT(on_line.cross(line).norm(), rounding);
    ASSERT_NEAR(line.dot(W * (v - on_line)), 0.0, rounding);
    const Vec3 on_plane = norm.within(v, line);
    ASSERT_NEAR(on_plane.dot(line), 0.0, rounding);
    const Vec3 left = W * (v - on_plane);
    ASSERT_NEAR((left - left.dot(line) * line).norm(), 0.0, rounding);
  }
}

// In every tick on a fixed mesh, the spring K/2 |p - x|^2 in the norm of W gains no more than the
// work of F_W and the leak K/2 |dx|^2 in that norm.
TEST(AnisotropicCertificate, HoldsInTheNormOfWInHardScenes) {
  int contacts = 0;
  for (std::uint64_t seed = 1; seed <= 55; ++seed) {
    Random random(seed);
    const auto kind = test::kAllHardKinds[seed % std::size(test::kAllHardKinds)];
    const test::HardScene scene = hard_scene(kind, random);
    const OwnedWorld world(scene.soup);
    const double E = kAnisotropies[random.index(5)];
    const ActuationModel device = device_with_motors(random);
    const WideMat3 W = weights(E, device);
    auto loop = test::made(HapticLoop::create(world.world(), device, anisotropic_settings(E)));
    const auto triangles = test::solver_triangles(world);
    ProxyState state;
    state.proxy = Vec3(0.3, 0.2, 0.1);
    test::DeviceMotion motion(triangles, {}, state.proxy, random);
    const auto lag_of = [](const TickRecord& r) -> Eigen::Matrix<Wide, 3, 1> {
      return vec3(r.proxy_scene_m).cast<Wide>() - vec3(r.goal_scene_m).cast<Wide>();
    };
    TickRecord last = loop.tick(world.world().to_scene(state.proxy), kTick_s);
    for (int n = 0; n < 400; ++n) {
      const TickRecord now = loop.tick(world.world().to_scene(motion.next_goal(state)), kTick_s);
      if ((now.faults & kFaultsWithoutForce) != 0) continue;  // a jump across the scene
      state.proxy = world.world().to_solver(vec3(now.proxy_scene_m));
      state.in_contact = now.contact != 0;
      contacts += now.contact;
      const Eigen::Matrix<Wide, 3, 1> dx =
          vec3(now.goal_scene_m).cast<Wide>() - vec3(last.goal_scene_m).cast<Wide>();
      const Wide before = lag_of(last).dot(W * lag_of(last)) / 2;
      const Wide after = lag_of(now).dot(W * lag_of(now)) / 2;
      const Wide given = -lag_of(last).dot(W * dx);
      const Wide leak = dx.dot(W * dx) / 2;
      // Rounding: of the energies, and of the coordinates of the lag, each of which is rounded at
      // most eight times; its weight in the norm of W is at most E or 1.
      const double size_m = world.world().size_m + vec3(now.goal_scene_m).norm();
      const Wide rounding_m = 16 * 0x1p-53L * size_m * std::max(1.0, E);
      const Wide allowed = 1e-12L * (before + after + std::abs(given) + leak) +
                           rounding_m * (lag_of(now).norm() + rounding_m);
      ASSERT_LE(after - before - given - leak, allowed)
          << "seed " << seed << ", tick " << n << ", E " << E;
      last = now;
    }
  }
  EXPECT_GT(contacts, 5000);
}

// A program in which one material declares this effect with its default parameters.
std::shared_ptr<const EffectProgram> program_with(const EffectType& effect) {
  EffectProgramBuilder builder;
  const auto number = static_cast<std::uint16_t>(&effect - compiled_effects().data());
  EffectProgramBuilder::Entry entry{number, std::vector<std::byte>(effect.parameter_bytes)};
  effect.begin_parameters(entry.parameters.data());
  builder.add_material(std::span(&entry, 1));
  return std::make_shared<const EffectProgram>(std::move(builder).finish());
}

// A material's K and B act as those of the loop do, bit for bit.
TEST(AnisotropicScope, HasTheStiffnessAndDampingOfMaterials) {
  Random random(33);
  const test::Soup soup = test::box_soup(Vec3::Constant(0.1));
  OwnedWorld stated(soup);
  const OwnedWorld plain(soup);
  test::EffectBodies bodies;
  bodies.add_body(
      {test::effect_entry<StiffnessEffect>({700.0}), test::effect_entry<DampingEffect>({1.5})});
  stated.set_effects(bodies.finish());
  HapticSettings settings = anisotropic_settings(0.25);
  auto a =
      test::made(HapticLoop::create(stated.world(), *ActuationModel::from_counts(3, 1), settings));
  settings.coupling = {700.0, 1.5};
  auto b =
      test::made(HapticLoop::create(plain.world(), *ActuationModel::from_counts(3, 1), settings));
  int contacts = 0;
  Vec3 at(0.15, 0.0, 0.0);
  Vec3 aim = at;
  for (int n = 0; n < 5000; ++n) {
    if (n % 100 == 0) aim = 0.13 * random.unit_vector();
    at += 0.02 * (aim - at);
    const TickRecord& expected = b.tick(at, kTick_s);
    const TickRecord& record = a.tick(at, kTick_s);
    ASSERT_EQ(vec3(record.force_device_N), vec3(expected.force_device_N)) << "tick " << n;
    ASSERT_EQ(vec3(record.full_force_device_N), vec3(expected.full_force_device_N));
    contacts += record.contact;
  }
  EXPECT_GT(contacts, 1000);
}

TEST(AnisotropicScope, IsStiffnessAndDampingAndRefusesOtherEffectsByName) {
  OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (const EffectType& effect : compiled_effects()) {
    world.set_effects(program_with(effect));
    const auto error = check_settings(world.world(), anisotropic_settings(4.0));
    if (effect.name == "stiffness" || effect.name == "damping") {
      EXPECT_FALSE(error) << effect.name;
    } else {
      ASSERT_TRUE(error) << effect.name;
      EXPECT_NE(error->problem.find("the scene declares " + std::string(effect.name)),
                std::string::npos);
    }
  }
}

}  // namespace
}  // namespace palpate
