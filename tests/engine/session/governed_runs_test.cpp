// The governor changes nothing in runs that keep its rules: the paper's runs, and devices with
// motors after their start ramp.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/hapi_view.h"
#include "engine/session/haptic_session.h"
#include "engine/simulation/exploration.h"
#include "haptics/record_vectors.h"
#include "tests/engine/devices/hapi_rig.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::HapiRig;
using test::kMillisecond_ns;
using test::OwnedWorld;
using test::Random;

constexpr double kGovernedTick_s = 1e-3;
// The rule *start*: the speed is known after 5 ticks, the hand must be calm for 100 ms, and the
// force grows for 500 ms, of which the last tick has the full force.
constexpr int kRampTicks = 5 + 100 + 499;

std::uint32_t rules_of(const TickRecord& record) {
  return record.rules;
}

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

// The last record of a session.
class LastRecord final : public TickObserver {
 public:
  void on_tick(const TickRecord& new_record) noexcept override { record = new_record; }
  TickRecord record;
};

// ---- the paper's runs ---------------------------------------------------------------------------

struct PaperRun {
  int sensors;
  int actuators;
  double start_deg;  // rotation of the scene about A3
};

class GovernedPaperRuns : public testing::TestWithParam<const char*> {};

TEST_P(GovernedPaperRuns, NoRuleOfTheGovernorActs) {
  auto scene = Scene::load(PALPATE_MODELS_DIR "/" + std::string(GetParam()) + ".glb");
  ASSERT_TRUE(scene) << scene.error().to_string();
  for (const PaperRun& run : {PaperRun{2, 1, 0}, PaperRun{2, 1, 45}, PaperRun{3, 1, 0},
                              PaperRun{3, 2, 0}, PaperRun{3, 3, 0}}) {
    for (const bool a4 : {false, true}) {
      SCOPED_TRACE(std::to_string(run.sensors) + " sensors, " + std::to_string(run.actuators) +
                   " actuators, " + std::to_string(run.start_deg) + " deg" +
                   (a4 ? ", with A4" : ", without A4"));
      RunSettings settings;
      settings.sensors = run.sensors;
      settings.default_actuators = run.actuators;
      settings.haptics.a4.enabled = a4;
      settings.haptics.initial_pose.rotation =
          Quat(Eigen::AngleAxisd(run.start_deg * std::numbers::pi / 180, Vec3::UnitZ()));
      const auto setup = make_setup(settings);
      ASSERT_TRUE(setup) << setup.error().to_string();
      ExplorationSettings exploration;
      exploration.virtual_time = true;
      const auto done = explore(*scene, *setup, exploration, [](double) {});
      ASSERT_TRUE(done) << done.error().to_string();
      const RunSummary& summary = done->summary;
      EXPECT_EQ(summary.ticks, 28000u);
      EXPECT_GT(summary.contact_ticks, 10000u) << "too little to judge";
      EXPECT_EQ(summary.trips, 0u);
      for (std::size_t rule = 0; rule < summary.governor_rules.size(); ++rule) {
        EXPECT_EQ(summary.governor_rules[rule], 0u) << kGovernorRuleNames[rule];
      }
      EXPECT_EQ(std::accumulate(summary.faults.begin(), summary.faults.end(), std::uint64_t{0}),
                0u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PaperObjects, GovernedPaperRuns,
                         testing::Values("star", "labyrinth", "inverted_labyrinth", "lock"));

// ---- a device with motors -----------------------------------------------------------------------

// A hand that waits in free space until the force has its full size, and then wanders around and
// through a box, slower than 1 m/s.
class WanderingDevice final : public Device {
 public:
  WanderingDevice(Random& random, int sensors, const std::vector<Vec3>& motors) : random_(random) {
    description_.name = "wandering";
    description_.sensed_axes = sensors;
    description_.motor_count = static_cast<int>(motors.size());
    for (std::size_t i = 0; i < motors.size(); ++i) {
      MotorDescription& motor = description_.motors[i];
      std::copy_n(motors[i].data(), 3, motor.direction_device.begin());
      motor.peak_force_N = 100.0;
    }
    description_.peak_force_N = 15.0;
    description_.workspace_low_m.fill(-0.25);
    description_.workspace_high_m.fill(0.25);
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double) noexcept override {
    ++sample_.sequence;
    if (sample_.sequence > kRampTicks) wander();
    return sample_;
  }
  void command(const DeviceCommand& command) noexcept override {
    force_N = Vec3(command.force_N.data());
  }

  Vec3 force_N = Vec3::Zero();

 private:
  void wander() {
    if (sample_.sequence % 100 == 0) aim_m_ = 0.12 * random_.unit_vector();
    for (int k = 0; k < description_.sensed_axes; ++k) {
      double& x_m = sample_.position_m[static_cast<std::size_t>(k)];
      x_m += 0.004 * (aim_m_[k] - x_m);
    }
  }

  Random& random_;
  DeviceDescription description_;
  DeviceSample sample_{.position_m = {0.19, 0.0, 0.0}};
  Vec3 aim_m_ = Vec3::Zero();
};

std::vector<Vec3> some_motors(Random& random, int sensors) {
  const std::uint64_t count = 1 + random.index(static_cast<std::uint64_t>(sensors));
  for (;;) {
    std::vector<Vec3> motors;
    for (std::uint64_t i = 0; i < count; ++i) {
      Vec3 motor = random.unit_vector();
      if (sensors == 2) motor.z() = 0.0;
      motors.push_back(motor.normalized());
    }
    if (ActuationModel::from_axes(sensors, motors)) return motors;
  }
}

TEST(GovernedRuns, AfterItsStartADeviceWithMotorsGetsTheBitsOfTheLoopAlone) {
  Random random(19);
  std::cout << "seed " << random.seed() << "\n";
  int contacts = 0;
  int limited = 0;  // ticks of the start in which a rule has acted
  for (int run = 0; run < 60; ++run) {
    const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)), {random.rotation(), Vec3::Zero()},
                           run % 3 == 0 ? 5e-3 : 0.0);
    const int sensors = 2 + static_cast<int>(random.index(2));
    const std::vector<Vec3> motors = some_motors(random, sensors);
    HapticSettings settings;
    settings.god_object.radius_m = run % 3 == 0 ? 5e-3 : 0.0;
    // Weaker than 5 N, which the rule slew permits from zero in a tick.
    // So weak that the work of the missing motors stays within its budget.
    settings.coupling.stiffness_N_per_m = random.uniform(0.4, 1.0);
    settings.a4.enabled = random.index(2) == 0;
    const ActuationModel actuation = *ActuationModel::from_axes(sensors, motors);
    auto governed = test::made(HapticLoop::create(world.world(), actuation, settings));
    auto alone = test::made(HapticLoop::create(world.world(), actuation, settings));
    WanderingDevice device(random, sensors, motors);
    LastRecord last;
    HapticSession session(governed, device, {.observers = {&last}});
    ASSERT_FALSE(session.start());
    for (int n = 0; n < 3000; ++n) {
      session.tick(kGovernedTick_s);
      const TickRecord& expected = alone.tick(vec3(last.record.device_m), kGovernedTick_s);
      if (n < kRampTicks) {
        limited += rules_of(last.record) != 0;
        continue;
      }
      ASSERT_EQ(rules_of(last.record), 0u) << "the hand breaks a rule: run " << run << ", " << n;
      ASSERT_TRUE(same_bits(device.force_N, vec3(expected.force_device_N)))
          << "run " << run << ", tick " << n;
      contacts += expected.contact != 0 && !device.force_N.isZero();
    }
  }
  EXPECT_GT(contacts, 60 * 500);
  EXPECT_EQ(limited, 60 * kRampTicks) << "the ramp must last as long as this test waits";
}

// ---- a board ------------------------------------------------------------------------------------

constexpr double kTorquePerNm = 2.0;
// The first sample of a session is older than a tick.
constexpr int kBoardRampTicks = kRampTicks + 10;

HapiSettings board_settings() {
  HapiSettings settings;
  settings.torque_per_Nm = kTorquePerNm;
  settings.peak_torque_Nm = 3.0;
  return settings;
}

// The driver of a simulated board, in virtual time.
class RigDevice final : public Device {
 public:
  RigDevice() : rig(board_settings()), view_(board_settings()) { rig.run_until_working(); }
  const DeviceDescription& description() const noexcept override { return view_.description(); }
  DeviceSample read(double) noexcept override { return view_.take(rig.link.sample()); }
  std::span<const MotorDescription> motors_now() const noexcept override { return view_.motors(); }
  void command(const DeviceCommand& command) noexcept override {
    rig.link.set_force({{command.force_N[0], command.force_N[1]}, rig.now_ns});
  }
  // The position of the linkage's origin, device frame.
  Vec2 linkage_m() {
    const DeviceSample sample = view_.take(rig.link.sample());
    return Vec2(sample.position_m.data()) - Vec2(rig.link.sample().tip_m.data());
  }

  HapiRig rig;

 private:
  HapiView view_;
};

ActuationModel actuation_of(std::span<const MotorDescription> motors) {
  const std::array<Vec3, 2> axes = {Vec3(motors[0].direction_device.data()),
                                    Vec3(motors[1].direction_device.data())};
  return *ActuationModel::from_axes_at_pose(2, axes);
}

TEST(GovernedRuns, AfterItsStartABoardGetsTheTorquesOfTheLoopAlone) {
  Random random(23);
  std::cout << "seed " << random.seed() << "\n";
  int pushing = 0;
  for (int run = 0; run < 12; ++run) {
    RigDevice device;
    HapiRig& rig = device.rig;
    // A box that the hand enters through its face, which lies oblique to the axes.
    const double angle = random.uniform(-0.5, 0.5);
    const Vec2 face_m = device.linkage_m() + Vec2(0.01, 0.055);
    const Vec3 inward(std::sin(angle), std::cos(angle), 0.0);
    const Quat rotation(Eigen::AngleAxisd(-angle, Vec3::UnitZ()));
    const Vec3 middle_m = Vec3(face_m.x(), face_m.y(), 0.0) + 0.05 * inward;
    const OwnedWorld world(test::box_soup(Vec3::Constant(0.05)), {rotation, middle_m});
    HapticSettings settings;
    settings.coupling.stiffness_N_per_m = random.uniform(30.0, 130.0);  // stable (kBareTip)
    settings.a4.enabled = false;
    auto governed =
        test::made(HapticLoop::create(world.world(), actuation_of(device.motors_now()), settings));
    auto alone =
        test::made(HapticLoop::create(world.world(), actuation_of(device.motors_now()), settings));
    LastRecord last;
    HapticSession session(governed, device, {.observers = {&last}});
    ASSERT_FALSE(session.start());
    const double beat_rad = random.uniform(2.0, 6.0) * kGovernedTick_s;
    std::vector<Vec2> forces_N;  // of the loop alone, per tick
    const std::int64_t first_ns = rig.now_ns;
    for (int n = 0; n < 2500; ++n) {
      const double in_m = n < kBoardRampTicks + 50 ? -0.01 : 0.008 * std::sin(beat_rad * n);
      const Vec2 hand_m = Vec2(0.01, 0.055) + in_m * inward.head<2>();
      rig.board.set_hand(hand_m);
      session.tick(kGovernedTick_s, 0, rig.now_ns);
      alone.set_actuation(actuation_of(device.motors_now()));
      const TickRecord& expected = alone.tick(vec3(last.record.device_m), kGovernedTick_s);
      if (n >= kBoardRampTicks) {
        ASSERT_EQ(rules_of(last.record), 0u) << "run " << run << ", tick " << n;
      }
      forces_N.push_back(vec3(expected.force_device_N).head<2>());
      rig.run(kMillisecond_ns);
    }
    // Each command of the board has the newest tick's force in the pose of the answer before it.
    const auto& log = rig.board.log();
    for (std::size_t k = 1; k < log.size(); ++k) {
      const std::int64_t n = (log[k].time_ns - first_ns) / kMillisecond_ns;
      if (log[k].time_ns < first_ns || n < kBoardRampTicks) continue;
      const auto pose = hapi_pose(FiveBar(board_settings().links), log[k - 1].answered_deg);
      const Vec2& force_N = forces_N[static_cast<std::size_t>(n)];
      const Vec2 torques_Nm = pose->jacobian.transpose() * force_N;
      ASSERT_EQ(log[k].torques, (HapiNumbers{static_cast<float>(kTorquePerNm * torques_Nm[0]),
                                             static_cast<float>(kTorquePerNm * torques_Nm[1])}))
          << "run " << run << ", tick " << n;
      pushing += !force_N.isZero();
    }
  }
  EXPECT_GT(pushing, 12 * 500);
}

}  // namespace
}  // namespace palpate
