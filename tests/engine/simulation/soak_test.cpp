// Long runs of the haptic thread, here short ones.

#include "engine/simulation/soak.h"

#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "engine/simulation/exploration.h"
#include "models/primitives.h"

namespace palpate {
namespace {

Scene sphere_scene() {
  SceneDescription description;
  const TriangleMesh mesh = icosphere(3, 0.05);
  description.meshes.push_back({"sphere", mesh.positions_m, mesh.triangles});
  description.nodes.push_back({"sphere", 0, Mat3::Identity(), Vec3::Zero()});
  auto scene = Scene::compile(std::move(description));
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

RunSetup setup_of(double rate_Hz) {
  RunSettings settings;
  settings.rate_Hz = rate_Hz;
  settings.default_actuators = 2;
  settings.haptics.a4.enabled = true;
  auto setup = make_setup(settings);
  EXPECT_TRUE(setup) << setup.error().to_string();
  return std::move(*setup);
}

void ignore_progress(double) {}

TEST(Soak, CountsEveryTickOnceAndMakesThoseOfASimulatedRun) {
  const Scene scene = sphere_scene();
  const RunSetup setup = setup_of(500.0);
  SoakSettings settings;
  settings.seconds = 2.5;
  const auto run = soak(scene, setup, settings, ignore_progress);
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_FALSE(run->interrupted);
  EXPECT_EQ(run->summary.ticks, 1250u);
  EXPECT_EQ(run->ticks_not_finite, 0u);
  const TickTimes& times = run->tick_times;
  for (const TimeHistogram* all :
       {&times.late, &times.wall, &times.cpu, &times.step, &times.delay}) {
    EXPECT_EQ(all->count(), 1250u);
  }
  EXPECT_EQ(times.period.count(), 1249u);
  EXPECT_LE(times.step.largest_ns(), times.wall.largest_ns());
  EXPECT_LE(times.delay.largest_ns(), times.wall.largest_ns());
  EXPECT_EQ(std::min<std::uint64_t>(times.all_late_ticks(), LateTickLog::kMost),
            times.late_log.ticks().size());
  EXPECT_GE(run->memory_at_start.heap, 0);  // 0 where a sanitizer replaces malloc
  EXPECT_GT(run->memory_at_start.resident, 0);
  // The work and the contact depend on the inputs alone.
  ExplorationSettings same;
  same.seconds = settings.seconds;
  same.virtual_time = true;
  const auto simulated = explore(scene, setup, same, ignore_progress);
  ASSERT_TRUE(simulated) << simulated.error().to_string();
  EXPECT_GT(run->summary.contact_ticks, 500u);
  EXPECT_EQ(run->summary.contact_ticks, simulated->summary.contact_ticks);
  EXPECT_EQ(run->summary.mean_penetration_m, simulated->summary.mean_penetration_m);
  EXPECT_EQ(run->summary.port_work_J, simulated->summary.port_work_J);
}

TEST(Soak, RefusesABadLength) {
  const Scene scene = sphere_scene();
  for (const double seconds : {1.9, 0.0, -5.0, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
    SoakSettings settings;
    settings.seconds = seconds;
    const auto run = soak(scene, setup_of(1000.0), settings, ignore_progress);
    ASSERT_FALSE(run) << seconds;
    EXPECT_EQ(run.error().element, "seconds");
  }
}

TEST(Soak, EndsWhenAStopIsRequested) {
  const Scene scene = sphere_scene();
  StopFlag stop;
  SoakSettings settings;
  settings.seconds = 3600.0;
  int looks = 0;
  const auto run = soak(
      scene, setup_of(1000.0), settings,
      [&](double) {
        if (++looks == 3) stop.request();
      },
      &stop);
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_TRUE(run->interrupted);
  EXPECT_LT(run->summary.ticks, 3'600'000u);
}

}  // namespace
}  // namespace palpate
