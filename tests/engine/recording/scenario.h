#pragma once

// A session in which everything happens that a recording must hold: a device with turning motors
// and faults, nodes that move, materials that are tuned, switches, pauses, trips and rearms.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/recording/recorded_tick.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_reader.h"
#include "engine/recording/recording_settings.h"
#include "engine/session/haptic_session.h"
#include "engine/session/live_setting.h"
#include "engine/session/material_tuner.h"
#include "engine/session/node_motions.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

inline constexpr int kMovingNodes = 16;
inline constexpr double kScenarioTick_s = 1e-3;

// A floor of "wood" with its top at z = 0, and small boxes of "felt" that stand on it.
inline SceneDescription scenario_description() {
  SceneDescription scene;
  scene.path = "scenario.glb";
  const auto value = [](const char* key, double v) {
    return MaterialParameter{key, v, std::string("/materials/0/extras/palpate/") + key};
  };
  scene.materials = {
      {"wood",
       "/materials/0",
       {value("dynamicFriction", 0.2), value("staticFriction", 0.4), value("stiffness", 800.0),
        value("vibrationAmplitude", 0.1), value("vibrationFrequency", 60.0)},
       {}},
      {"felt", "/materials/1", {value("stiffness", 300.0)}, {}}};
  const std::array half_extents = {Vec3(0.1, 0.1, 0.02), Vec3(0.004, 0.004, 0.004)};
  for (std::uint32_t m = 0; m < half_extents.size(); ++m) {
    Soup soup = box_soup(half_extents[m]);
    MeshDescription mesh{"box", std::move(soup.positions), std::move(soup.triangles)};
    mesh.material_runs = {{0, m}};
    scene.meshes.push_back(std::move(mesh));
  }
  const auto add = [&](const std::string& name, std::uint32_t mesh, const Vec3& at_m) {
    const auto number = static_cast<std::uint32_t>(scene.tree.size());
    scene.tree.push_back({name, number, {}, true, at_m});
    NodeDescription node{name, mesh, Mat3::Identity(), at_m};
    node.tree_node = number;
    scene.nodes.push_back(node);
  };
  add("floor", 0, Vec3(0, 0, -0.02));
  for (int n = 0; n < kMovingNodes; ++n) {
    add("box " + std::to_string(n), 1, Vec3(0.03 * (n % 4) - 0.045, 0.03 * (n / 4) - 0.045, 0.004));
  }
  return scene;
}

// A device with two motors that turn as it moves, held by a hand that wanders over the floor. Its
// samples have every fault that a sample can have, at random.
class FaultyDevice final : public Device {
 public:
  FaultyDevice(std::uint64_t seed, double faults_per_tick)
      : random_(seed), faults_per_tick_(faults_per_tick) {
    description_.name = "faulty";
    description_.sensed_axes = 3;
    description_.motor_count = 2;
    description_.motors = motors();
    description_.workspace_low_m = {-0.06, -0.06, -0.05};
    description_.workspace_high_m = {0.06, 0.06, 0.05};
    description_.peak_force_N = 2.5;
  }

  const DeviceDescription& description() const noexcept override { return description_; }
  void command(const DeviceCommand&) noexcept override {}
  std::span<const MotorDescription> motors_now() const noexcept override {
    return std::span(motors_).first(2);
  }
  DeviceSample read(double dt_s) noexcept override {
    time_s_ += dt_s > 0.0 && dt_s < 1.0 ? dt_s : 0.0;
    const double t = time_s_;
    position_m_ = Vec3(0.05 * std::sin(0.9 * t), 0.05 * std::sin(0.7 * t + 1.0),
                       0.004 * std::sin(1.7 * t) + 0.001 * std::sin(5.3 * t));
    // A motor that never moves is no input of every tick.
    if (std::fmod(t, 2.0) < 1.0) motors_ = motors();
    DeviceSample sample;
    sample.position_m = {position_m_.x(), position_m_.y(), position_m_.z()};
    sample.buttons = std::fmod(t, 0.5) < 0.05 ? 1 : 0;
    if (stale_ticks_ > 0) {
      --stale_ticks_;
    } else {
      ++sequence_;
      sample_ns_ = now_ns;
    }
    sample.sequence = sequence_;
    sample.time_ns = sample_ns_;
    if (random_.uniform(0, 1) < faults_per_tick_) spoil(sample);
    return sample;
  }

  std::int64_t now_ns = 0;  // of the tick that runs

 private:
  std::array<MotorDescription, 3> motors() const {
    const double angle = 0.3 + 4.0 * position_m_.x();
    std::array<MotorDescription, 3> motors;
    motors[0] = {{std::cos(angle), std::sin(angle), 0.0}, 2.0, 1.0};
    motors[1] = {{0.0, std::sin(0.2 * angle), std::cos(0.2 * angle)}, 2.5, 1.0};
    return motors;
  }
  void spoil(DeviceSample& sample) {
    switch (static_cast<int>(random_.uniform(0, 8))) {
      case 0:
        sample.is_valid = false;
        break;
      case 1:
        sample.position_m[1] = std::numeric_limits<double>::quiet_NaN();
        break;
      case 2:
        sample.position_m[0] = 1e200;
        break;
      case 3:
        sample.position_m[2] += 3.0;  // a jump
        break;
      case 4:
        stale_ticks_ = static_cast<int>(random_.uniform(3, 140));
        break;
      case 5:
        sample.sequence = sequence_ > 10 ? sequence_ - 10 : 0;  // out of order
        break;
      case 6:
        sample.asks_for_trip = true;
        break;
      default:
        sample.time_ns = 0;
        break;
    }
  }

  Random random_;
  double faults_per_tick_;
  DeviceDescription description_;
  Vec3 position_m_ = Vec3::Zero();
  std::array<MotorDescription, 3> motors_{};
  double time_s_ = 0.0;
  std::uint64_t sequence_ = 0;
  std::int64_t sample_ns_ = 0;
  int stale_ticks_ = 0;
};

// Switches everything that a program may switch, at random.
class Switches final : public BeforeTick {
 public:
  Switches(std::uint64_t seed, double per_tick) : random_(seed), per_tick_(per_tick) {}
  void before_tick(double, LoopChanges changes) noexcept override {
    if (free_ticks_ > 0 && --free_ticks_ == 0) changes.hold_hand();
    if (random_.uniform(0, 1) >= per_tick_) return;
    switch (static_cast<int>(random_.uniform(0, 6))) {
      case 0:
        changes.set(live_setting("a4"), random_.uniform(0, 1) < 0.6 ? 1.0 : 0.0);
        break;
      case 1:
        changes.set(live_setting("force"), std::floor(random_.uniform(0, 3)));
        break;
      case 2:
        changes.set(live_setting("stiffness"), random_.uniform(200, 1500));
        changes.set(live_setting("damping"), random_.uniform(0, 2));
        break;
      case 3: {
        const std::array axes = {Vec3(random_.uniform(-1, 1), 1.0, random_.uniform(-1, 1))};
        if (const auto model = ActuationModel::from_axes_at_pose(3, axes)) {
          changes.set_actuation(*model);
        }
        break;
      }
      case 4:
        changes.free_hand();
        free_ticks_ = 20;
        break;
      default:
        changes.refuse_body_pose();
        break;
    }
  }

 private:
  Random random_;
  double per_tick_;
  int free_ticks_ = 0;
};

// Keeps every tick that a recorder gets, and passes it on.
class TickKeeper final : public TickSink {
 public:
  explicit TickKeeper(TickSink* next) : next_(next) {}
  void on_start(const SessionFacts& facts) noexcept override {
    if (next_) next_->on_start(facts);
  }
  void on_input(const TickInput& input) noexcept override {
    ++inputs[static_cast<std::size_t>(input.kind)];
    for (const LiveChange& change : LiveChanges(input).all()) ++settings[change.setting];
    if (next_) next_->on_input(input);
  }
  void on_tick(const TickRecord& record, const TickReading& reading) noexcept override {
    rows.push_back({record, reading});
    if (next_) next_->on_tick(record, reading);
  }
  void on_trip(const GovernorTrip& trip) noexcept override {
    ++trips;
    if (next_) next_->on_trip(trip);
  }
  void on_late(LateCause cause, const TickCost& cost) noexcept override {
    if (next_) next_->on_late(cause, cost);
  }

  std::vector<RecordedTick> rows;
  std::array<std::uint64_t, kInputKinds.size()> inputs{};
  std::array<std::uint64_t, kLiveSettings.size()> settings{};
  std::uint64_t trips = 0;

 private:
  TickSink* next_;
};

struct ScenarioSettings {
  std::uint64_t ticks = 60'000;
  double faults_per_tick = 1.0 / 600;
  double switches_per_tick = 1.0 / 300;
};

// Runs the scenario in simulated time, with a clock that has late ticks.
class Scenario {
 public:
  explicit Scenario(std::uint64_t seed, ScenarioSettings settings = {})
      : settings_(settings), seed_(seed), scene_(compiled(scenario_description())) {
    setup_.dt_s = kScenarioTick_s;
    setup_.virtual_time = true;
    setup_.haptics.a4.enabled = true;
    setup_.haptics.coupling = {700.0, 0.5, {}};
    setup_.haptics.initial_pose.translation_m = Vec3(0.001, -0.002, 0.0005);
    setup_.actuation = *ActuationModel::from_counts(3, 2);
  }

  const Scene& scene() const { return scene_; }
  // scene_file: any file, whose hash the recording holds.
  RecordedSetup setup(const std::string& scene_file) const {
    RecordedSetup setup = setup_;
    setup.scene_path = scene_file;
    return setup;
  }

  // is_over(n) is called before tick n.
  template <typename IsOver>
  void run(TickSink* sink, const IsOver& is_over) {
    Random random(seed_);
    FaultyDevice device(random.seed() + 1, settings_.faults_per_tick);
    Switches switches(random.seed() + 2, settings_.switches_per_tick);
    MaterialTuner tuner(scene_);
    const auto stiffness = tuner.add("wood", "stiffness");
    const auto friction = tuner.add("wood", "dynamicFriction");
    ASSERT_TRUE(stiffness && friction);
    NodeMotions nodes(scene_);
    std::vector<std::size_t> handles;
    for (int n = 0; n < kMovingNodes; ++n) {
      const auto handle = nodes.add("box " + std::to_string(n));
      ASSERT_TRUE(handle) << handle.error().to_string();
      handles.push_back(*handle);
    }
    auto loop = test::made(HapticLoop::create(scene_.world(), setup_.actuation, setup_.haptics));
    HapticSession session(
        loop, device, {.changes = {&tuner, &nodes, &switches}, .max_force_N = 2.2, .sink = sink});
    ASSERT_FALSE(session.start());
    std::int64_t now_ns = 1'000'000'000;
    for (std::uint64_t n = 0; n < settings_.ticks && !is_over(n); ++n) {
      if (n % 97 == 0) {
        (void)tuner.set(*stiffness, random.uniform(400, 1200));
        (void)tuner.set(*friction, random.uniform(0.05, 0.4));
      }
      for (const std::size_t handle : handles) {
        if (random.uniform(0, 1) < 0.2) nodes.set(handle, pose(random));
      }
      const bool is_late = random.uniform(0, 1) < settings_.faults_per_tick;
      const auto late_ns =
          static_cast<std::int64_t>(is_late ? random.uniform(1e6, 70e6) : random.uniform(0, 5e4));
      now_ns += 1'000'000;
      device.now_ns = now_ns + late_ns;
      double dt_s = kScenarioTick_s;
      if (random.uniform(0, 1) < 0.1 * settings_.faults_per_tick) dt_s = -1.0;
      if (random.uniform(0, 1) < 0.5 * settings_.faults_per_tick) pause(session, random);
      if (random.uniform(0, 1) < 5 * settings_.faults_per_tick) session.rearm();
      session.tick(dt_s, late_ns, device.now_ns);
    }
    session.stop();
  }
  void run(TickSink* sink) {
    run(sink, [](std::uint64_t) { return false; });
  }

 private:
  static RigidTransform pose(Random& random) {
    const Vec3 axis(random.uniform(-1, 1), random.uniform(-1, 1), 1.0);
    return {Quat(Eigen::AngleAxisd(random.uniform(-0.2, 0.2), axis.normalized())),
            Vec3(random.uniform(-0.001, 0.001), random.uniform(-0.001, 0.001),
                 random.uniform(-0.002, 0.0))};
  }
  static void pause(HapticSession& session, Random& random) {
    session.set_paused(true);
    const int ticks = static_cast<int>(random.uniform(1, 60));
    for (int n = 0; n < ticks; ++n) session.tick(kScenarioTick_s);
    session.set_paused(false);
  }

  ScenarioSettings settings_;
  std::uint64_t seed_;
  Scene scene_;
  RecordedSetup setup_;
};

// Records the scenario into a new file of the folder and returns all that the recorder was given.
inline TickKeeper recorded_scenario(Scenario& scenario, const std::string& scene_file,
                                    const std::string& recording) {
  const auto meta = meta_of(scenario.scene(), scenario.setup(scene_file));
  EXPECT_TRUE(meta) << meta.error().to_string();
  auto recorder = Recorder::create(recording, *meta, {.virtual_time = true});
  EXPECT_TRUE(recorder) << recorder.error().to_string();
  TickKeeper keeper(recorder->get());
  scenario.run(&keeper);
  const RecordingResult result = (*recorder)->finish("end");
  EXPECT_FALSE(result.error) << result.error->to_string();
  EXPECT_EQ(result.ticks, keeper.rows.size());
  EXPECT_EQ(result.dropped, 0u);
  return keeper;
}

// The session and the rows of a recording.
inline RecordedSession session_in(const RecordingReader& reader) {
  const auto meta = reader.meta();
  EXPECT_TRUE(meta) << meta.error().to_string();
  auto session = session_of(*meta);
  EXPECT_TRUE(session) << session.error().to_string();
  return std::move(*session);
}

}  // namespace palpate::test
