// Nodes that an application moves while the haptic thread runs.

#include "engine/session/node_motions.h"

#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/scene/node_tree.h"
#include "engine/session/haptic_thread.h"
#include "haptics/record_vectors.h"
#include "tests/engine/session/still_device.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::compiled;
using test::kTick_s;
using test::Random;
using test::StillDevice;

MeshDescription box_mesh(const Vec3& half_extent) {
  test::Soup soup = test::box_soup(half_extent);
  return {"box", std::move(soup.positions), std::move(soup.triangles)};
}

// arm (at x = 1) carries box "arm box" and hand (at x = 1.2), which carries two boxes; a floor.
SceneDescription arm_scene() {
  SceneDescription scene;
  scene.path = "made.glb";
  scene.meshes = {box_mesh({0.02, 0.02, 0.02}), box_mesh({1.0, 1.0, 0.1})};
  scene.tree = {{"root", 0, {}, false, Vec3::Zero()},   {"arm", 4, 0u, true, Vec3(1.0, 0, 0)},
                {"hand", 2, 1u, true, Vec3(1.2, 0, 0)}, {"finger", 3, 2u, true, Vec3(1.3, 0, 0)},
                {"floor", 1, 0u, true, Vec3(0, 0, -1)}, {"twin", 5, 4u, false, Vec3::Zero()},
                {"twin", 6, 4u, false, Vec3::Zero()}};
  const auto node = [&](const char* name, std::uint32_t mesh, std::uint32_t tree_node) {
    NodeDescription n{name, mesh, Mat3::Identity(), scene.tree[tree_node].origin_m};
    n.tree_node = tree_node;
    scene.nodes.push_back(n);
  };
  node("arm", 0, 1);
  node("hand", 0, 2);
  node("finger", 0, 3);
  node("floor", 1, 4);
  return scene;
}

class LastRecord final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    last = record;
    faults |= record.faults;
  }
  TickRecord last;
  std::uint32_t faults = 0;
};

RigidTransform shifted(const Vec3& by_m) {
  return {Quat::Identity(), by_m};
}

TEST(NodeTree, FindsNodesByNameOrNumber) {
  const SceneDescription scene = arm_scene();
  EXPECT_EQ(*find_node(scene.tree, "hand"), 2u);
  EXPECT_EQ(*find_node(scene.tree, "#4"), 1u);
  for (const char* wrong : {"Hand", "#9", "#", "#1x", "", "#-1", "#99999999999"}) {
    const auto found = find_node(scene.tree, wrong);
    ASSERT_FALSE(found) << wrong;
    EXPECT_NE(found.error().element.find(wrong), std::string::npos);
  }
  const auto twin = find_node(scene.tree, "twin");
  ASSERT_FALSE(twin);
  EXPECT_NE(twin.error().hint.find("#5"), std::string::npos);
  EXPECT_EQ(end_of_subtree(scene.tree, 0), 7u);
  EXPECT_EQ(end_of_subtree(scene.tree, 1), 4u);
  EXPECT_EQ(end_of_subtree(scene.tree, 3), 4u);
  EXPECT_EQ(end_of_subtree(scene.tree, 6), 7u);
}

TEST(NodeTree, IsTold) {
  EXPECT_EQ(tree_text(arm_scene().tree),
            "  root  #0\n    arm  #4  mesh\n      hand  #2  mesh\n        finger  #3  mesh\n"
            "    floor  #1  mesh\n      twin  #5\n      twin  #6\n");
}

TEST(SceneParts, ASubtreeKeepsItsPlaceAndOnlyItsMeshes) {
  SceneSettings settings;
  settings.node = "hand";
  const Scene scene = compiled(arm_scene(), settings);
  EXPECT_EQ(scene.objects().size(), 2u);
  EXPECT_EQ(scene.statistics().meshes, 1u);
  EXPECT_EQ(scene.statistics().nodes, 2u);
  EXPECT_EQ(scene.tree()[0].name, "hand");
  EXPECT_FALSE(scene.tree()[0].parent);
  EXPECT_EQ(*scene.tree()[1].parent, 0u);
  EXPECT_EQ(scene.objects()[1].T_scene_body.translation_m, Vec3(1.3, 0, 0));
  EXPECT_EQ(scene.objects()[1].tree_node, 1u);
  EXPECT_NEAR(scene.statistics().extent_m.x(), 0.14, 1e-15);

  settings.node = "twin";
  EXPECT_FALSE(Scene::compile(arm_scene(), settings));
  settings.node = "#5";
  const auto empty = Scene::compile(arm_scene(), settings);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::kEmptyScene);
}

TEST(SceneParts, AreScaledOrFitted) {
  SceneSettings settings;
  settings.scale = 0.25;
  const Scene scaled = compiled(arm_scene(), settings);
  EXPECT_EQ(scaled.statistics().scale, 0.25);
  EXPECT_EQ(scaled.objects()[1].T_scene_body.translation_m, Vec3(0.3, 0, 0));
  EXPECT_EQ(scaled.tree()[2].origin_m, Vec3(0.3, 0, 0));
  EXPECT_NEAR(scaled.statistics().extent_m.x(), 0.25 * 2.32, 1e-15);
  EXPECT_EQ(scaled.statistics().indices, 2u);

  settings.scale = 1.0;
  settings.fit_size_m = 0.116;
  const Scene fitted = compiled(arm_scene(), settings);
  EXPECT_NEAR(fitted.statistics().extent_m.maxCoeff(), 0.116, 1e-16);
  EXPECT_NEAR(fitted.statistics().scale, 0.05, 1e-16);
}

TEST(NodeMotions, TakeEverythingBelowANodeAlongAndNothingElse) {
  const Scene scene = compiled(arm_scene());
  NodeMotions motions(scene);
  const auto hand = motions.add("hand");
  ASSERT_TRUE(hand);
  EXPECT_EQ(*motions.add("#2"), *hand);  // the same node
  const Vec3 over_finger(1.3, 0, 0.03);
  const Vec3 over_arm(1.0, 0, 0.03);
  const auto touched_at = [&](const Vec3& start, const Vec3& end) {
    auto loop =
        test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
    motions.move_bodies(0.0, loop);
    loop.tick(start, kTick_s);
    return loop.tick(end, kTick_s);
  };
  motions.set(*hand, shifted({0, 0, 0.1}));
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  motions.move_bodies(0.0, loop);
  loop.tick(over_finger + Vec3(0, 0, 0.2), kTick_s);
  EXPECT_NEAR(vec3(loop.tick(over_finger, kTick_s).proxy_scene_m).z(), 0.12, 1e-9);
  EXPECT_FALSE(touched_at(over_arm, over_arm).contact);
  EXPECT_NEAR(touched_at(over_arm, Vec3(1.0, 0, 0)).proxy_scene_m[2], 0.02, 1e-9);
}

// The finger turns about the hand, which turns about the arm.
TEST(NodeMotions, OfANodeBelowAnotherComeOnTop) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = compiled(arm_scene());
    NodeMotions motions(scene);
    const auto finger = motions.add("finger");
    const auto arm = motions.add("arm");  // the outer one, later
    const RigidTransform T_arm = random.pose(0.05);
    const RigidTransform T_finger = random.pose(0.05);
    motions.set(*finger, T_finger);
    motions.set(*arm, T_arm);
    auto loop =
        test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
    motions.move_bodies(0.0, loop);
    // A box of 0.04 m is where the two motions put it: seen along any axis of its own.
    const auto place = [&](const Vec3& p) {
      return T_arm.point(T_finger.point(Vec3(1.3, 0, 0) + p));
    };
    const Vec3 from = place(Vec3(0.0, 0.0, 0.03));
    loop.tick(from, kTick_s);
    const TickRecord& record = loop.tick(place(Vec3(0.001, 0.002, 0.015)), kTick_s);
    ASSERT_TRUE(record.contact);
    EXPECT_LT((vec3(record.proxy_scene_m) - place(Vec3(0.001, 0.002, 0.02))).norm(), 1e-9);
  }
}

TEST(NodeMotions, RefuseWhatCannotMove) {
  const Scene scene = compiled(arm_scene());
  NodeMotions motions(scene);
  EXPECT_FALSE(motions.add("nobody"));
  EXPECT_FALSE(motions.add("#5"));  // nothing to touch
  EXPECT_TRUE(motions.add("arm"));

  SceneDescription many;
  many.meshes = {box_mesh({0.02, 0.02, 0.02})};
  many.tree = {{"root", 0, {}, false, Vec3::Zero()}};
  for (std::uint32_t i = 0; i < LiveWorld::kMostMoving + 1; ++i) {
    many.tree.push_back({"box " + std::to_string(i), i + 1, 0u, true, Vec3::Zero()});
    NodeDescription n{"box", 0, Mat3::Identity(), Vec3(0.1 * i, 0, 0)};
    n.tree_node = i + 1;
    many.nodes.push_back(n);
  }
  const Scene crowd = compiled(std::move(many));
  NodeMotions of_crowd(crowd);
  const auto all = of_crowd.add("root");
  ASSERT_FALSE(all);
  EXPECT_NE(all.error().problem.find("257"), std::string::npos);
  EXPECT_TRUE(of_crowd.add("box 3"));
}

TEST(SteadyMotions, TurnAboutTheNodesOwnOrigin) {
  const Scene scene = compiled(arm_scene());
  const double rate = 2.0;
  auto mover = SteadyMotions::create(scene, {{"hand", Vec3(0, 0, 0.1), Vec3(0, 0, rate)}});
  ASSERT_TRUE(mover);
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  mover->move_bodies(0.5, loop);  // 1 rad, 5 cm up
  // The finger, a box 0.1 m beside the hand, is where it has been turned to.
  const Vec3 finger = Vec3(1.2, 0, 0.05) + 0.1 * Vec3(std::cos(1.0), std::sin(1.0), 0);
  loop.tick(finger + Vec3(0, 0, 0.05), kTick_s);
  EXPECT_NEAR(vec3(loop.tick(finger, kTick_s).proxy_scene_m).z(), 0.07, 1e-9);
}

TEST(NodeMotions, KeepTheLastPoseWhileWhatIsSetIsNone) {
  const Scene scene = compiled(arm_scene());
  NodeMotions motions(scene);
  const auto arm = motions.add("arm");
  const auto finger = motions.add("finger");
  StillDevice device(Vec3(0, 0, 5));
  LastRecord record;
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  HapticSession session(loop, device, {.changes = {&motions}, .observers = {&record}});
  session.start();
  session.tick(kTick_s);
  EXPECT_EQ(record.last.faults, kFaultNone);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const RigidTransform& bad : {RigidTransform{Quat::Identity(), Vec3(nan, 0, 0)},
                                    RigidTransform{Quat(0.5, 0, 0, 0), Vec3::Zero()}}) {
    motions.set(*arm, bad);
    motions.set(*finger, {Quat(2, 0, 0, 0), Vec3::Zero()});  // with 0.5 the product has length 1
    for (int n = 0; n < 3; ++n) {
      session.tick(kTick_s);
      EXPECT_EQ(record.last.faults, kFaultBadBodyPose);
    }
    motions.set(*arm, {});
    motions.set(*finger, {});
    session.tick(kTick_s);
    EXPECT_EQ(record.last.faults, kFaultNone);
  }
}

TEST(SteadyMotions, GoOnAfterABadTimeStep) {
  const Scene scene = compiled(arm_scene());
  auto mover = SteadyMotions::create(scene, {{"arm", Vec3(0, 0, 0.1), Vec3::Zero()}});
  StillDevice device(Vec3(0, 0, 5));
  LastRecord record;
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  HapticSession session(loop, device, {.changes = {&*mover}, .observers = {&record}});
  session.start();
  session.tick(kTick_s);
  session.tick(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(record.last.faults, kFaultBadTimeStep);
  session.tick(kTick_s);
  EXPECT_EQ(record.last.faults, kFaultNone);
}

TEST(SteadyMotions, RefuseTwoOfOneNode) {
  const Scene scene = compiled(arm_scene());
  const auto twice = SteadyMotions::create(
      scene, {{"arm", Vec3::UnitX(), Vec3::Zero()}, {"#4", Vec3::UnitY(), Vec3::Zero()}});
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().element.find("#4"), std::string::npos);
}

TEST(SteadyMotions, GiveTheSameBitsEveryTime) {
  const Scene scene = compiled(arm_scene());
  std::vector<Vec3> first;
  for (int pass = 0; pass < 2; ++pass) {
    auto mover = SteadyMotions::create(scene, {{"arm", Vec3(0, 0, -0.3), Vec3(0.1, 1.0, 0.2)}});
    StillDevice device(Vec3(1.3, 0.001, -0.05));
    LastRecord record;
    auto loop =
        test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 2), {}));
    HapticSession session(loop, device, {.changes = {&*mover}, .observers = {&record}});
    session.start();
    bool was_touched = false;
    for (int n = 0; n < 400; ++n) {
      session.tick(kTick_s);
      was_touched |= record.last.contact;
      if (pass == 0) {
        first.push_back(vec3(record.last.proxy_scene_m));
      } else {
        ASSERT_EQ(vec3(record.last.proxy_scene_m), first[static_cast<std::size_t>(n)]) << n;
      }
    }
    EXPECT_TRUE(was_touched);
  }
}

// An application lifts and lowers the floor while the hand rests on it, as fast as it can.
TEST(NodeMotions, ReachARunningHapticThread) {
  const Scene scene = compiled(arm_scene());
  NodeMotions motions(scene);
  const auto floor = motions.add("floor");
  ASSERT_TRUE(floor);
  StillDevice device(Vec3(0, 0, -0.89));
  LastRecord record;
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  HapticSession session(loop, device, {.changes = {&motions}, .observers = {&record}});
  HapticThread thread(session, {2000.0, 0});
  thread.start();
  while (thread.ticks() < 1) std::this_thread::yield();
  for (int n = 0; n < 4000; ++n) {
    motions.set(*floor, shifted({0, 0, 0.02 * std::sin(1e-3 * n)}));
    std::this_thread::yield();
  }
  motions.set(*floor, shifted({0, 0, 0.03}));
  const std::uint64_t seen = thread.ticks();
  while (thread.ticks() < seen + 3) std::this_thread::yield();
  TickRecord snapshot;
  ASSERT_TRUE(session.latest(snapshot));
  thread.stop();
  EXPECT_EQ(snapshot.contact, 1u);
  EXPECT_NEAR(snapshot.proxy_scene_m[2], -0.87, 1e-9);
  EXPECT_EQ(record.faults, kFaultNone);
}

}  // namespace
}  // namespace palpate
