// Materials that an application changes while the hand feels them.

#include "engine/session/material_tuner.h"

#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "engine/session/haptic_thread.h"
#include "engine/session/node_motions.h"
#include "haptics/record_vectors.h"
#include "tests/engine/session/still_device.h"
#include "tests/helpers/made.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::StillDevice;

// Two boxes of one material, the second with a physics material of its own, and a third of another.
SceneDescription described() {
  SceneDescription scene;
  scene.path = "made.glb";
  for (const std::uint32_t material : {0u, 1u}) {
    test::Soup soup = test::box_soup({1, 1, 1});
    MeshDescription mesh{"box", std::move(soup.positions), std::move(soup.triangles)};
    mesh.material_runs = {{0, material}};
    scene.meshes.push_back(std::move(mesh));
  }
  const auto value = [](const char* key, MaterialValue v) {
    return MaterialParameter{key, std::move(v), std::string("/materials/0/extras/palpate/") + key};
  };
  scene.materials = {
      {"wood",
       "/materials/0",
       {value("creaseAngle", 30.0), value("magnetForce", 1.0), value("magnetRange", 0.5),
        value("staticFriction", 0.5), value("stiffness", 1000.0)},
       {}},
      {"ice", "/materials/1", {value("stiffness", 100.0)}, {}}};
  scene.physics_materials = {{0.5, 0.25, 0.0}};
  scene.nodes = {{"a", 0, Mat3::Identity(), Vec3::Zero()},
                 {"b", 0, Mat3::Identity(), Vec3(5, 0, 0)},
                 {"c", 1, Mat3::Identity(), Vec3(10, 0, 0)}};
  scene.nodes[1].physics_material = 0;
  return scene;
}

// A little below the top of the first box.
const Vec3 kPressing_m(0, 0, 0.999);

Scene compiled_boxes(const SceneSettings& settings = {}) {
  auto scene = Scene::compile(described(), settings);
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

void expect_refused(const std::optional<Error>& error, const std::vector<std::string>& names) {
  ASSERT_TRUE(error);
  for (const std::string& name : names) {
    EXPECT_NE(error->to_string().find(name), std::string::npos)
        << "no " << name << " in: " << error->to_string();
  }
}

void expect_not_added(MaterialTuner& tuner, const char* material, const char* key,
                      const std::vector<std::string>& names) {
  const auto handle = tuner.add(material, key);
  ASSERT_FALSE(handle) << material << "." << key;
  expect_refused(handle.error(), names);
}

TEST(MaterialTuner, RefusesWhatCannotChange) {
  const Scene scene = compiled_boxes();
  MaterialTuner tuner(scene);
  expect_not_added(tuner, "glass", "stiffness", {"glass.stiffness", "no surface has"});
  expect_not_added(tuner, "wood", "hardness", {"wood.hardness", "not a key"});
  expect_not_added(tuner, "wood", "viscosity", {"wood.viscosity", "the effect viscosity"});
  expect_not_added(tuner, "ice", "staticFriction", {"the effect friction"});
  expect_not_added(tuner, "wood", "creaseAngle", {"fixed when the scene is compiled"});
  expect_not_added(tuner, "wood", "solid", {"fixed when the scene is compiled"});
  EXPECT_TRUE(tuner.add("wood", "magnetRange"));
  EXPECT_TRUE(tuner.add("wood", "stiffness"));
}

TEST(MaterialTuner, RefusesValuesOutOfRangeAndContradictions) {
  const Scene scene = compiled_boxes();
  MaterialTuner tuner(scene);
  const auto stiffness = tuner.add("wood", "stiffness");
  const auto range = tuner.add("wood", "magnetRange");
  const auto rest = tuner.add("wood", "staticFriction");
  const auto slide = tuner.add("wood", "dynamicFriction");
  ASSERT_TRUE(stiffness && range && rest && slide);
  for (const double wrong : {-1.0, 1e7, std::nan(""), std::numeric_limits<double>::infinity()}) {
    expect_refused(tuner.set(*stiffness, wrong), {"wood", "stiffness", "1e+06 N/m"});
  }
  expect_refused(tuner.set(*range, 0.0), {"wood", "magnetRange", "above 0"});
  // At rest both have 0.5; while sliding 0.5 and, where the physics material says so, 0.25.
  expect_refused(tuner.set(*slide, 0.6), {"wood", "dynamicFriction is larger"});
  expect_refused(tuner.set(*rest, 0.3), {"larger"});
  EXPECT_FALSE(tuner.set(*slide, 0.2));
  EXPECT_FALSE(tuner.set(*rest, 0.3));
}

TEST(MaterialTuner, ChangesWhatIsFeltFromTheNextTickOn) {
  const Scene scene = compiled_boxes();
  MaterialTuner tuner(scene);
  const auto stiffness = tuner.add("wood", "stiffness");
  const auto force = tuner.add("wood", "magnetForce");
  ASSERT_TRUE(stiffness && force);
  EXPECT_FALSE(tuner.set(*force, 0.0));
  for (const double x : {0.0, 5.0}) {  // both bodies of the material
    auto loop =
        test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
    StillDevice device(kPressing_m);
    MaterialTuner own(scene);
    const auto k = own.add("wood", "stiffness");
    const auto pull = own.add("wood", "magnetForce");
    ASSERT_FALSE(own.set(*pull, 0.0));
    NodeMotions motions(scene);
    HapticSession session(loop, device, {.changes = {&motions, &own}});
    session.start();
    device.position_m = {x, 0, 1.1};
    session.tick(kTick_s);
    device.position_m = {x, 0, 0.999};
    session.tick(kTick_s);
    EXPECT_NEAR(device.force_N.z(), 1.0, 1e-6);
    ASSERT_FALSE(own.set(*k, 3000.0));
    session.tick(kTick_s);
    EXPECT_NEAR(device.force_N.z(), 3.0, 1e-6);
    EXPECT_TRUE(own.set(*k, -1.0));
    session.tick(kTick_s);
    EXPECT_NEAR(device.force_N.z(), 3.0, 1e-6);
  }
}

TEST(MaterialTuner, TakesLengthsInTheUnitOfTheFile) {
  SceneSettings settings;
  settings.scale = 0.1;
  const Scene scene = compiled_boxes(settings);
  MaterialTuner tuner(scene);
  const auto range = tuner.add("wood", "magnetRange");
  const auto force = tuner.add("wood", "magnetForce");
  ASSERT_TRUE(range && force);
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  StillDevice device(kPressing_m);
  HapticSession session(loop, device, {.changes = {&tuner}});
  session.start();
  device.position_m = {0, 0, 0.11};
  ASSERT_FALSE(tuner.set(*range, 0.2));
  ASSERT_FALSE(tuner.set(*force, 4.0));
  session.tick(kTick_s);
  EXPECT_NEAR(device.force_N.z(), -4.0 * std::pow(1 - 0.01 / 0.02, 2), 1e-9);
}

// An application turns a knob as fast as it can while the haptic thread runs.
TEST(MaterialTuner, ReachesARunningHapticThread) {
  const Scene scene = compiled_boxes();
  MaterialTuner tuner(scene);
  const auto stiffness = tuner.add("wood", "stiffness");
  const auto force = tuner.add("wood", "magnetForce");
  ASSERT_TRUE(stiffness && force);
  EXPECT_FALSE(tuner.set(*force, 0.0));
  StillDevice device(kPressing_m);
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  HapticSession session(loop, device, {.changes = {&tuner}});
  session.start();
  device.position_m = {0, 0, 1.1};
  session.tick(kTick_s);
  device.position_m = {0, 0, 0.999};
  HapticThread thread(session, {2000.0, 0});
  thread.start();
  while (thread.ticks() < 1) std::this_thread::yield();
  for (int n = 0; n < 4000; ++n) {
    EXPECT_FALSE(tuner.set(*stiffness, 1000.0 + 500.0 * std::sin(1e-3 * n)));
    std::this_thread::yield();
  }
  EXPECT_FALSE(tuner.set(*stiffness, 2000.0));
  const std::uint64_t seen = thread.ticks();
  while (thread.ticks() < seen + 3) std::this_thread::yield();
  TickRecord snapshot;
  ASSERT_TRUE(session.latest(snapshot));
  thread.stop();
  EXPECT_NEAR(vec3(snapshot.force_device_N)[2], 2.0, 1e-6);
}

}  // namespace
}  // namespace palpate
