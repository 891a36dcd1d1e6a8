// Every strategy in hard scenes, with bodies at rest and in motion. A second god-object gets the
// goals and the poses of the loop; the proxies of both must be equal bit for bit, so that the
// judgement of its path holds for the loop. Each piece of the path must touch no triangle of any
// body, in the frame of the body, exactly.
//
// The seed determines a scene: PALPATE_SEED=N repeats scene N.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/proxy/trace_log.h"
#include "haptics/proxy/work.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"
#include "haptics/strategies/a4_anticipate.h"
#include "haptics/strategies/anisotropic.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::kTick_s;
using test::OwnedBodies;
using test::Random;

constexpr int kTicksPerScene = 200;

int scenes_per_strategy() {
  return test::in_soak_or_else(1'000'000, 8'000) / kTicksPerScene;
}

RigidTransform moved(const RigidTransform& T, const Vec3& by_m, const Vec3& turn_rad) {
  const Quat turn(Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()));
  return {(turn * T.rotation).normalized(), T.translation_m + by_m};
}

OwnedBodies three_bodies(Random& random, double radius_m) {
  std::vector<OwnedBodies::Placed> placed;
  for (int b = 0; b < 3; ++b) {
    const auto kind = test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))];
    placed.push_back({hard_scene(kind, random).soup, random.pose(0.1)});
  }
  return OwnedBodies(placed, radius_m);
}

ActuationModel judged_device(Random& random) {
  const int sensors = 2 + static_cast<int>(random.index(2));
  if (sensors == 2) return *ActuationModel::from_counts(2, 1);
  std::vector<Vec3> axes{random.unit_vector()};
  if (random.index(2)) axes.push_back(random.unit_vector());
  return *ActuationModel::from_axes(3, axes);
}

// A loop with a strategy among three bodies, of which two move in turn, and its judge.
class JudgedRun {
 public:
  JudgedRun(const Strategy& strategy, Random& random)
      : random_(random),
        strategy_(strategy),
        radius_m_(pick_radius_m()),
        bodies_(three_bodies(random, radius_m_)),
        device_(judged_device(random)),
        loop_(test::made(HapticLoop::create(bodies_.world(), device_, settings()))),
        shadow_(test::made(GodObject::create(bodies_.world(), {.radius_m = radius_m_}))) {
    for (std::size_t b = 0; b < bodies_.world().bodies.size(); ++b) {
      judges_.emplace_back(bodies_.triangles(b));
    }
    nearest_m_ = radius_m_ - 64 * std::numeric_limits<double>::epsilon() *
                                 (bodies_.world().size_m + radius_m_) * kFarthest;
    goal_m_ = pick_start();
  }

  // False if a judgement failed.
  bool tick() {
    move(static_cast<std::uint32_t>(n_ % 2));
    aim();
    const TickRecord record = loop_.tick(loop_.T_device_scene().point(goal_m_), kTick_s);
    if ((record.faults & kFaultsWithoutForce) != 0) return expect(false, "the sample is refused");
    contacts += record.contact;
    turns += record.rotation_rad > 0.0 && record.contact == 0;
    const bool is_good = follow(record) && is_finite(record) && is_governed(record);
    ++n_;
    return is_good;
  }

  int contacts = 0;
  int turns = 0;  // in free motion

 private:
  static constexpr double kFarthest = 4.0;  // of bodies, in sizes, for rounding
  static constexpr double kClamp_N = 2.0;
  // As in work_budget_test.cpp.
  static constexpr WorkUnits kLastStep =
      DoubtfulTriangles::kMost * (price_of(Work::kTriangle) + 4 * price_of(Work::kNearestPoint) +
                                  5 * price_of(Work::kSignByExpansions)) +
      Accuracy{}.iterations * (price_of(Work::kStep) + kMaxContactPlanes * price_of(Work::kPlane) +
                               3 * price_of(Work::kContact));

  static DeviceDescription three_motors() {
    DeviceDescription device;
    device.motor_count = 3;
    for (std::size_t i = 0; i < 3; ++i) device.motors[i].direction_device[i] = 1.0;
    device.workspace_low_m.fill(-10.0);
    device.workspace_high_m.fill(10.0);
    return device;
  }

  double pick_radius_m() {
    const bool is_point = strategy_.type == &kAnisotropicStrategy || random_.index(2) == 0;
    return is_point ? 0.0 : random_.uniform(1e-4, 5e-3);
  }

  HapticSettings settings() const {
    HapticSettings settings;
    settings.coupling = {1000.0, 2.0};
    settings.god_object.radius_m = radius_m_;
    set_strategy(strategy_, settings);
    return settings;
  }

  Vec3 pick_start() {
    const auto is_free = [&](const Vec3& p) {
      for (std::uint32_t b = 0; b < judges_.size(); ++b) {
        const double distance_m = judges_[b].distance_m(shadow_.world().body(b).to_body(p));
        if (distance_m <= 1.5 * radius_m_ + 1e-6) return false;
      }
      return true;
    };
    Vec3 start = Vec3::Zero();
    do {
      start = random_.in_box(0.3);
      if (device_.is_planar()) start.z() = 0.0;
    } while (!is_free(start));
    return start;
  }

  void move(std::uint32_t mover) {
    const RigidTransform now = loop_.T_scene_body(mover);
    const double leap_m = random_.index(10) == 0 ? 0.05 : 1e-3;
    const Vec3 home_m = -0.02 * now.translation_m;
    const RigidTransform to =
        moved(now, random_.in_box(leap_m) + home_m, random_.in_box(10 * leap_m));
    loop_.move_body(mover, to);
    if (motions_.size() <= mover) motions_.push_back({mover, {}});
    motions_[mover].T_solver_body = {to.rotation.normalized(),
                                     bodies_.world().to_solver(to.translation_m)};
    have_arrived_ = false;
  }

  // A goal in the scene: from time to time the hand aims at another triangle and through it.
  void aim() {
    if (n_ % 25 == 0) {
      aimed_ = static_cast<std::uint32_t>(random_.index(3));
      const auto& triangles = judges_[aimed_].triangles();
      aim_body_ = triangles[random_.index(triangles.size())].a + random_.in_box(2e-3);
    }
    const Vec3 to_m = shadow_.world().body(aimed_).to_solver(aim_body_);
    if (n_ > 0) goal_m_ += random_.uniform(0.0, 0.3) * (to_m - goal_m_) + random_.in_box(1e-3);
  }

  bool follow(const TickRecord& record) {
    const Vec3 goal = bodies_.world().to_solver(vec3(record.goal_scene_m));
    std::optional<Vec3> plane_normal;
    const Mat3 R = pose_before(record).rotation.toRotationMatrix();
    if (device_.is_planar()) plane_normal = R.transpose().col(2);
    if (n_ == 0) {
      for (const BodyMotion& m : motions_) shadow_.place_body(m.body, m.T_solver_body);
      have_arrived_ = true;
      return expect(shadow_.place(goal), "the shadow is not placed");
    }
    if (!push(plane_normal)) return false;
    const ProxyState state =
        strategy_.type == &kAnisotropicStrategy && strategy_.parameter != 1.0
            ? shadow_.move_in_norm(goal, plane_normal,
                                   anisotropic_norm(strategy_.parameter, device_, R))
            : shadow_.move_to(goal, plane_normal);
    if (state.work > settings().god_object.accuracy.work_budget + kLastStep) {
      return expect(false, "the work budget was exceeded");
    }
    const Vec3 expected =
        state.in_contact ? bodies_.world().to_scene(state.proxy) : vec3(record.goal_scene_m);
    return expect(vec3(record.proxy_scene_m) == expected, "the loop has another proxy") &&
           is_free(shadow_.path());
  }

  // The bodies move as in the loop. Their push is judged where one body alone has moved.
  bool push(const std::optional<Vec3>& plane_normal) {
    if (have_arrived_) return true;
    const bool was_held = is_held_;
    const Vec3 before = shadow_.proxy();
    std::vector<Vec3> starts;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      starts.push_back(shadow_.world().body(b).to_body(before));
    }
    is_held_ = shadow_.move_bodies(motions_, plane_normal) > 0;
    have_arrived_ = !is_held_;
    if (was_held || is_held_) return true;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      const Vec3 path[] = {starts[b], shadow_.world().body(b).to_body(shadow_.proxy())};
      if (!is_free_in(b, path)) return expect(false, "a body passed the proxy");
    }
    return true;
  }

  bool is_free(std::span<const Vec3> path) {
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      std::vector<Vec3> path_body;
      for (const Vec3& p : path) path_body.push_back(shadow_.world().body(b).to_body(p));
      if (!is_free_in(b, path_body)) return expect(false, "the proxy touched a triangle");
    }
    return true;
  }
  bool is_free_in(std::uint32_t b, std::span<const Vec3> path_body) const {
    return radius_m_ == 0.0 ? !judges_[b].touch_of_point(path_body)
                            : !judges_[b].touch_of_sphere(path_body, nearest_m_);
  }

  bool is_finite(const TickRecord& record) {
    return expect(vec3(record.force_device_N).allFinite() &&
                      vec3(record.full_force_device_N).allFinite() &&
                      std::isfinite(record.alpha_rad) &&
                      std::abs(loop_.T_device_scene().rotation.norm() - 1.0) <= 4 * 0x1p-52,
                  "a number is not finite, or the quaternion is no rotation");
  }

  // What the motors get: the governor clamps any strategy's force, and its span is that of the
  // motors of a device with these axes.
  bool is_governed(TickRecord record) {
    DeviceSample sample;
    std::copy_n(record.device_m, 3, sample.position_m.begin());
    sample.sequence = static_cast<std::uint64_t>(n_) + 1;
    governor_.begin_tick(sample, {kTick_s, 0, 0});
    governor_.govern(record);
    const double length_N = vec3(record.force_device_N).norm();
    return expect(length_N <= kClamp_N * (1.0 + 0x1p-50), "the governor let a force through");
  }

  bool expect(bool is_so, const char* problem) {
    if (!is_so) {
      ADD_FAILURE() << problem << ": " << name_of(strategy_) << ", tick " << n_ << ", radius "
                    << radius_m_;
    }
    return is_so;
  }

  Random& random_;
  Strategy strategy_;
  double radius_m_;
  OwnedBodies bodies_;
  ActuationModel device_;
  HapticLoop loop_;
  GodObject shadow_;
  SafetyGovernor governor_{three_motors(), SafetyGovernor::clamp_of(three_motors(), kClamp_N)};
  std::vector<ExactJudge> judges_;
  double nearest_m_ = 0.0;
  std::vector<BodyMotion> motions_;
  bool have_arrived_ = true;
  bool is_held_ = false;
  Vec3 goal_m_ = Vec3::Zero();
  Vec3 aim_body_ = Vec3::Zero();
  std::uint32_t aimed_ = 0;
  int n_ = 0;
};

class StrategiesInHardScenes : public testing::TestWithParam<const char*> {};

TEST_P(StrategiesInHardScenes, NeverLetTheProxyThrough) {
  const Strategy strategy = *parse_strategy(GetParam());
  const std::uint64_t scenes = static_cast<std::uint64_t>(scenes_per_strategy());
  int contacts = 0;
  int turns = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    Random random(seed);
    JudgedRun run(strategy, random);
    for (int n = 0; n < kTicksPerScene && run.tick(); ++n) {
    }
    ASSERT_FALSE(HasFailure());
    contacts += run.contacts;
    turns += run.turns;
    if (std::getenv("PALPATE_SEED")) return;
  }
  EXPECT_GT(contacts, static_cast<int>(scenes) * kTicksPerScene / 20);
  if (strategy.type == &kA4AnticipateStrategy) {
    EXPECT_GT(turns, static_cast<int>(scenes));
  } else {
    EXPECT_EQ(turns, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, StrategiesInHardScenes,
                         testing::Values("none", "mask", "full", "a4", "a4-anticipate",
                                         "a4-passive:0", "a4-passive:10", "cd",
                                         "anisotropic:0.0625", "anisotropic:0.25",
                                         "anisotropic:0.5", "anisotropic:1", "anisotropic:2",
                                         "anisotropic:4", "anisotropic:16"),
                         [](const auto& name) {
                           std::string text;
                           for (const char* c = name.param; *c != '\0'; ++c) {
                             if (std::isalnum(static_cast<unsigned char>(*c))) text += *c;
                           }
                           return text;
                         });

}  // namespace
}  // namespace palpate
