// A rig: scene, settings and device as one session.

#include "engine/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/path_device.h"
#include "engine/rig/replay.h"
#include "haptics/check_settings.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::Random;

constexpr double kHalf_m = 0.05;

// A closed box whose node can move.
Scene box_scene() {
  SceneDescription scene;
  scene.path = "box.glb";
  test::Soup soup = test::box_soup({kHalf_m, kHalf_m, kHalf_m});
  scene.meshes.push_back({"box", std::move(soup.positions), std::move(soup.triangles)});
  scene.tree.push_back({"box", 0, {}, true, Vec3::Zero()});
  NodeDescription node{"box", 0, Mat3::Identity(), Vec3::Zero()};
  node.tree_node = 0;
  scene.nodes.push_back(node);
  return test::compiled(std::move(scene));
}

// The scene in a random pose, and a path that presses into the box and slides.
struct Case {
  explicit Case(Random& random) : setup(*make_setup({})) {
    setup.haptics.initial_pose = {random.rotation(), random.in_box(0.1)};
    setup.haptics.force = ForceMode::kActuated;
    setup.haptics.a4.enabled = true;
    setup.actuation = *ActuationModel::from_counts(3, 1 + static_cast<int>(random.index(3)));
    for (int n = 0; n < 200; ++n) {
      const double height_m = kHalf_m + 0.004 - 5e-5 * n;
      const Vec3 p_scene_m(0.03 * std::sin(0.02 * n), 0.02 * std::cos(0.03 * n), height_m);
      path_m.push_back(setup.haptics.initial_pose.point(p_scene_m + random.in_box(1e-4)));
    }
  }
  RunSetup setup;
  std::vector<Vec3> path_m;
};

class Records final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    TickRecord& kept = all.emplace_back(record);
    kept.step_ns = 0;  // measured
  }
  std::vector<TickRecord> all;
};

bool are_equal(const std::vector<TickRecord>& a, const std::vector<TickRecord>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

std::vector<TickRecord> run(HapticSession& session, Records& records, std::size_t ticks) {
  EXPECT_FALSE(session.start());
  for (std::size_t n = 0; n < ticks; ++n) session.tick(kTick_s);
  return std::move(records.all);
}

bool has_contact(const std::vector<TickRecord>& records) {
  return std::any_of(records.begin(), records.end(),
                     [](const TickRecord& record) { return record.contact != 0; });
}

TEST(Rig, GivesTheBitsOfItsPartsPutTogetherByHand) {
  Random random(3);
  const Scene scene = box_scene();
  for (int i = 0; i < 20; ++i) {
    Case c(random);
    c.setup.moves = {{"box", random.in_box(0.01), random.in_box(0.2)}};
    if (i % 2 == 0) c.setup.max_force_N = 0.5;

    PathDevice by_hand_device(c.path_m);
    auto motions = SteadyMotions::create(scene, c.setup.moves);
    ASSERT_TRUE(motions.ok());
    auto loop = test::made(HapticLoop::create(scene.world(), c.setup.actuation, c.setup.haptics));
    Records by_hand;
    HapticSession session(
        loop, by_hand_device,
        {.changes = {&*motions}, .observers = {&by_hand}, .max_force_N = c.setup.max_force_N});
    const auto expected = run(session, by_hand, c.path_m.size());
    ASSERT_TRUE(has_contact(expected));

    PathDevice device(c.path_m);
    Records records;
    const auto rig = Rig::create(scene, c.setup, device, {.observers = {&records}});
    ASSERT_TRUE(rig.ok()) << rig.error().to_string();
    ASSERT_TRUE(are_equal(run((*rig)->session(), records, c.path_m.size()), expected)) << i;
  }
}

TEST(Rig, WithoutASceneGivesTheSameBits) {
  Random random(4);
  const Scene scene = box_scene();
  const Case c(random);
  Records of_scene, of_world;
  PathDevice first(c.path_m), second(c.path_m);
  const auto with = Rig::create(scene, c.setup, first, {.observers = {&of_scene}});
  const auto without = Rig::create(scene.world(), c.setup, second, {.observers = {&of_world}});
  ASSERT_TRUE(with.ok() && without.ok());
  const auto expected = run((*with)->session(), of_scene, c.path_m.size());
  ASSERT_TRUE(has_contact(expected));
  EXPECT_TRUE(are_equal(run((*without)->session(), of_world, c.path_m.size()), expected));
}

TEST(Rig, RefusesWhatNoTickWouldAccept) {
  Random random(5);
  const Scene scene = box_scene();
  PathDevice device({});
  const auto refusal_of = [&](const RunSetup& setup) {
    const auto rig = Rig::create(scene, setup, device);
    return rig ? std::string() : rig.error().element;
  };
  const Case good(random);
  EXPECT_EQ(refusal_of(good.setup), "");
  RunSetup bad = good.setup;
  bad.haptics.coupling.stiffness_N_per_m = -1.0;
  const auto settings = check_settings(scene.world(), bad.haptics);
  ASSERT_TRUE(settings);
  EXPECT_EQ(refusal_of(bad), settings->element);
  const auto of_world = Rig::create(scene.world(), bad, device);
  ASSERT_FALSE(of_world.ok());
  EXPECT_EQ(of_world.error().element, settings->element);
  bad = good.setup;
  bad.dt_s = 2.0 * kLongestTick_s;
  EXPECT_EQ(refusal_of(bad), "rate_Hz");
  bad = good.setup;
  bad.moves = {{"lid", Vec3::UnitX(), Vec3::Zero()}};
  EXPECT_NE(refusal_of(bad).find("lid"), std::string::npos);
}

// A change of the rig's owner.
class Refusal final : public BeforeTick {
 public:
  void before_tick(double, LoopChanges loop) noexcept override { loop.refuse_body_pose(); }
};

// The inputs of the first tick, in the order in which they act.
class FirstInputs final : public TickSink {
 public:
  void on_start(const SessionFacts&) noexcept override {}
  void on_input(const TickInput& input) noexcept override {
    const bool is_repeated = !kinds.empty() && kinds.back() == input.kind;
    if (!has_ticked_ && !is_repeated) kinds.push_back(input.kind);
  }
  void on_tick(const TickRecord&, const TickReading&) noexcept override { has_ticked_ = true; }
  void on_trip(const GovernorTrip&) noexcept override {}
  void on_late(LateCause, const TickCost&) noexcept override {}
  std::vector<InputKind> kinds;

 private:
  bool has_ticked_ = false;
};

TEST(Rig, MovesNodesThenTunesThenMakesItsOwnersChangesThenFreesTheHand) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/effect_friction.glb");
  ASSERT_TRUE(scene.ok());
  RunSetup setup = *make_setup({});
  setup.moves = {{"friction_sticking", Vec3::UnitX(), Vec3::Zero()}};
  const std::vector<Vec3> path_m(1, Vec3(0.0, 0.0, 0.2));
  PathDevice device(path_m);
  Refusal refusal;
  FirstInputs inputs;
  const auto rig = Rig::create(
      *scene, setup, device,
      {.changes = {&refusal}, .sink = &inputs, .has_tuner = true, .stays_inside = false});
  ASSERT_TRUE(rig.ok()) << rig.error().to_string();
  const auto friction = (*rig)->tuner().add("friction_sticking", "dynamicFriction");
  ASSERT_TRUE(friction.ok());
  ASSERT_FALSE((*rig)->tuner().set(*friction, 0.1));
  ASSERT_FALSE((*rig)->session().start());
  (*rig)->session().tick(kTick_s);
  const std::vector<InputKind> expected = {InputKind::kBodyPose, InputKind::kEffectParameters,
                                           InputKind::kBadBodyPose, InputKind::kFreeHand};
  EXPECT_EQ(inputs.kinds, expected);
}

TEST(Rig, HandsOverWhatItsKeeperKept) {
  Random random(6);
  const Scene scene = box_scene();
  const Case c(random);
  PathDevice device(c.path_m);
  Records records;
  const auto rig = Rig::create(
      scene, c.setup, device,
      {.observers = {&records}, .keeper = std::make_unique<RecordKeeper>(c.path_m.size())});
  ASSERT_TRUE(rig.ok());
  const auto observed = run((*rig)->session(), records, c.path_m.size());
  RunRecords kept = (*rig)->take_keeper()->finish();
  EXPECT_EQ(kept.summary.ticks, c.path_m.size());
  for (TickRecord& record : kept.records) record.step_ns = 0;
  EXPECT_TRUE(are_equal(kept.records, observed));

  auto replayed = replay(scene, c.setup, c.path_m, 3);
  ASSERT_TRUE(replayed.ok());
  for (TickRecord& record : replayed->records) record.step_ns = 0;
  EXPECT_TRUE(are_equal(replayed->records, observed));
}

TEST(Rig, MovesNodesOfTheApplication) {
  const Scene scene = box_scene();
  const RunSetup setup = *make_setup({});
  const std::vector<Vec3> away_m(3, Vec3(0.0, 0.0, 0.2));
  PathDevice device(away_m);
  const auto rig = Rig::create(scene, setup, device, {});
  ASSERT_TRUE(rig.ok());
  const auto box = (*rig)->nodes().add("box");
  ASSERT_TRUE(box.ok());
  const RigidTransform T{Quat::Identity(), {0.01, 0.02, 0.0}};
  (*rig)->nodes().set(*box, T);
  ASSERT_FALSE((*rig)->session().start());
  for (std::size_t n = 0; n < away_m.size(); ++n) (*rig)->session().tick(kTick_s);
  EXPECT_EQ((*rig)->loop().T_scene_body(0).translation_m,
            scene.objects()[0].T_scene_body.translation_m + T.translation_m);
}

}  // namespace
}  // namespace palpate
