// A hand that begins inside a closed surface gets no force until it has left or stays.

#include "engine/session/start_inside.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_replay.h"
#include "engine/session/node_motions.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Random;
using Phase = StartInside::Phase;

constexpr double kHalf_m = 0.05;
constexpr double kStiffness = 500.0;
constexpr double kTick_s = 1e-3;

struct Node {
  std::string name;
  Vec3 half_m;
  Vec3 centre_m = Vec3::Zero();
  bool is_open = false;  // one face is missing
};

Scene scene_of(const std::vector<Node>& nodes) {
  SceneDescription scene;
  scene.path = "boxes.glb";
  for (const Node& n : nodes) {
    test::Soup soup = test::box_soup(n.half_m);
    if (n.is_open) soup.triangles.resize(soup.triangles.size() - 2);
    scene.meshes.push_back({n.name, std::move(soup.positions), std::move(soup.triangles)});
    const auto number = static_cast<std::uint32_t>(scene.tree.size());
    scene.tree.push_back({n.name, number, {}, true, n.centre_m});
    NodeDescription node{n.name, number, Mat3::Identity(), n.centre_m};
    node.tree_node = number;
    scene.nodes.push_back(node);
  }
  return test::compiled(std::move(scene));
}

// A hand whose place the test states in the frame of the scene.
class PlacedHand final : public VectorDevice {
 public:
  Vec3 read_position_m(double) noexcept override { return position_m; }
  void command_force_N(const Vec3& force) noexcept override { force_N = force; }
  Vec3 position_m = Vec3::Zero();
  Vec3 force_N = Vec3::Zero();
};

// A session whose scene has a random pose.
struct Felt {
  explicit Felt(const Scene& felt, bool stays = false, std::uint64_t seed = 7,
                std::vector<BeforeTick*> before = {}, TickSink* sink = nullptr)
      : scene(felt), random(seed), start(felt, stays) {
    setup.haptics.initial_pose = {random.rotation(), random.in_box(0.1)};
    setup.haptics.coupling = {kStiffness, 0.0, {}};
    setup.haptics.force = ForceMode::kFull;
    setup.dt_s = kTick_s;
    setup.virtual_time = true;
    before.push_back(&start);
    loop = test::made(HapticLoop::create(felt.world(), setup.actuation, setup.haptics));
    session.emplace(*loop, hand, SessionParts{.changes = std::move(before), .sink = sink});
  }
  void begin() { EXPECT_FALSE(session->start()); }
  const TickRecord& tick(const Vec3& p_scene_m) {
    hand.position_m = setup.haptics.initial_pose.point(p_scene_m);
    session->tick(kTick_s);
    EXPECT_TRUE(session->latest(record));
    return record;
  }
  double force_N() const { return hand.force_N.norm(); }
  // The hand moves straight in steps of at most 1 mm.
  void move_to(const Vec3& to_scene_m) {
    const Vec3 from = at;
    const int steps = static_cast<int>((to_scene_m - from).norm() / 1e-3) + 1;
    for (int k = 1; k <= steps; ++k) {
      at = from + static_cast<double>(k) / steps * (to_scene_m - from);
      tick(at);
      largest_N = std::max(largest_N, force_N());
    }
  }

  const Scene& scene;
  Random random;
  RecordedSetup setup;
  StartInside start;
  PlacedHand hand;
  std::optional<HapticLoop> loop;
  std::optional<HapticSession> session;
  TickRecord record;
  Vec3 at = Vec3::Zero();
  double largest_N = 0.0;  // in move_to()
};

TEST(StartInside, GivesNoForceUntilTheHandHasLeftAndThenTheForceOfTheWall) {
  const Scene scene = scene_of({{"cube", Vec3::Constant(kHalf_m)}});
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    Felt felt(scene, false, seed);
    felt.begin();
    EXPECT_EQ(felt.start.status().phase, Phase::kSearching);
    felt.at = felt.random.in_box(0.9 * kHalf_m);
    felt.move_to(felt.at);
    felt.move_to(felt.random.in_box(0.9 * kHalf_m));
    const auto inside = felt.start.status();
    EXPECT_EQ(inside.phase, Phase::kInside);
    ASSERT_TRUE(inside.was_inside);
    EXPECT_EQ(scene.objects()[inside.object].name, "cube");
    // Out through a wall, and some way on.
    const Vec3 above(0.01, -0.02, 2 * kHalf_m);
    felt.move_to({0.01, -0.02, 0.0});
    felt.move_to(above);
    EXPECT_EQ(felt.largest_N, 0.0);
    EXPECT_EQ(felt.start.status().phase, Phase::kOutside);
    // Back onto the wall: the force begins with the first penetration.
    for (const double depth_m : {-1e-4, 1e-4, 2e-4, 1e-3, 3e-3}) {
      felt.tick({0.01, -0.02, kHalf_m - depth_m});
      EXPECT_NEAR(felt.force_N(), kStiffness * std::max(0.0, depth_m), 1e-6) << depth_m;
    }
  }
}

TEST(StartInside, AHandThatStaysFeelsTheWallsFromInside) {
  const Scene scene = scene_of({{"room", Vec3::Constant(kHalf_m)}});
  for (const bool is_early : {true, false}) {
    Felt felt(scene, is_early);
    felt.begin();
    felt.move_to({0.01, 0.0, 0.0});
    if (!is_early) {
      felt.move_to({0.0, 0.0, 2 * kHalf_m - kHalf_m - 1e-3});
      EXPECT_EQ(felt.start.status().phase, Phase::kInside);
      felt.start.stay();
      felt.tick(felt.at);
      EXPECT_EQ(felt.force_N(), 0.0) << "the proxy begins where the hand is";
    }
    EXPECT_EQ(felt.start.status().phase, Phase::kStays);
    EXPECT_TRUE(felt.start.status().was_inside);
    felt.move_to({0.01, 0.0, kHalf_m + 2e-3});
    EXPECT_NEAR(felt.force_N(), kStiffness * 2e-3, 1e-6);
  }
}

TEST(StartInside, LeavesSessionsAloneThatBeginOutsideOrWhereNothingIsClosed) {
  const Scene open = scene_of({{"shell", Vec3::Constant(kHalf_m), Vec3::Zero(), true}});
  Felt in_shell(open);
  in_shell.begin();
  in_shell.tick(Vec3::Zero());
  EXPECT_EQ(in_shell.start.status().phase, Phase::kOutside);
  EXPECT_FALSE(in_shell.start.status().was_inside);
  in_shell.move_to({kHalf_m + 1e-3, 0.0, 0.0});
  EXPECT_NEAR(in_shell.force_N(), kStiffness * 1e-3, 1e-6) << "from the first tick on";
  const Scene closed = scene_of({{"cube", Vec3::Constant(kHalf_m)}});
  Felt outside(closed);
  outside.begin();
  outside.at = {0.0, 0.0, 1.5 * kHalf_m};
  outside.move_to({0.0, 0.0, kHalf_m - 1e-3});
  EXPECT_FALSE(outside.start.status().was_inside);
  EXPECT_NEAR(outside.force_N(), kStiffness * 1e-3, 1e-6);
}

// A box in a room: the hand has left when it is outside of both.
TEST(StartInside, AHandHasLeftWhenItIsOutsideOfAllSurfaces) {
  const Scene scene = scene_of({{"room", Vec3::Constant(0.2)}, {"box", Vec3::Constant(kHalf_m)}});
  Felt felt(scene);
  felt.begin();
  felt.move_to({0.0, 0.0, 0.01});
  felt.move_to({0.0, 0.0, 0.12});
  auto status = felt.start.status();
  EXPECT_EQ(status.phase, Phase::kInside);
  EXPECT_EQ(scene.objects()[status.object].name, "room");
  felt.move_to({0.0, 0.0, 0.3});
  EXPECT_EQ(felt.largest_N, 0.0);
  EXPECT_EQ(felt.start.status().phase, Phase::kOutside);
}

// The box leaves the hand.
TEST(StartInside, AMovingSurfaceCanLeaveTheHand) {
  const Scene scene = scene_of({{"box", Vec3::Constant(kHalf_m)}});
  NodeMotions motions(scene);
  const auto box = motions.add("box");
  ASSERT_TRUE(box);
  Felt felt(scene, false, 3, {&motions});
  felt.begin();
  for (int k = 0; k < 100; ++k) {
    motions.set(*box, {Quat::Identity(), Vec3(0.0, 0.0, -1e-3 * k)});
    felt.tick({0.01, 0.02, 0.0});
    EXPECT_EQ(felt.force_N(), 0.0);
    if (k == 20) {
      EXPECT_EQ(felt.start.status().phase, Phase::kInside);
    }
  }
  EXPECT_EQ(felt.start.status().phase, Phase::kOutside);
  // When it comes back, it pushes the hand's proxy ahead of it.
  for (int k = 100; k >= 45; --k) {
    motions.set(*box, {Quat::Identity(), Vec3(0.0, 0.0, -1e-3 * k)});
    felt.tick({0.01, 0.02, 0.0});
  }
  EXPECT_NEAR(felt.force_N(), kStiffness * 5e-3, 1e-6);
}

// Motors: the force begins as after a start, from zero.
TEST(StartInside, TheForceOfMotorsBeginsSlowly) {
  const Scene scene = scene_of({{"room", Vec3::Constant(kHalf_m)}});
  Felt felt(scene);
  felt.begin();
  for (int k = 0; k < 2000; ++k) felt.tick({0.0, 0.0, 0.02});
  felt.start.stay();
  int n = 0;
  for (; n < 50; ++n) felt.tick({0.0, 0.0, 0.02});
  EXPECT_EQ(felt.start.status().phase, Phase::kStays);
  double before_N = 0.0;
  for (; n < 2000; ++n) {
    felt.tick({0.0, 0.0, kHalf_m + 1e-3});
    const double most_N = GovernorLimits::kSlew_N_per_s * kTick_s;
    EXPECT_LE(felt.force_N() - before_N, most_N);
    before_N = felt.force_N();
  }
}

// The recording holds when the hand was free: the replay has no StartInside.
TEST(StartInside, ARecordedSessionReplaysToTheBit) {
  const test::TemporaryFolder folder;
  const Scene scene = scene_of({{"room", Vec3::Constant(0.2)}, {"box", Vec3::Constant(kHalf_m)}});
  for (const bool stays : {false, true}) {
    const std::string path = folder.path(stays ? "stays.palpate" : "leaves.palpate");
    RecordedSetup setup;
    {
      Felt plan(scene);
      setup = plan.setup;
    }
    setup.scene_path = folder.write("boxes.glb", "any bytes");
    const auto meta = meta_of(scene, setup);
    ASSERT_TRUE(meta) << meta.error().to_string();
    auto recorder = Recorder::create(path, *meta, {.virtual_time = true});
    ASSERT_TRUE(recorder);
    Felt felt(scene, stays, 7, {}, recorder->get());
    felt.begin();
    felt.move_to({0.0, 0.0, 0.04});
    felt.move_to({0.0, 0.01, 0.25});
    felt.move_to({0.0, 0.01, 0.19});
    felt.move_to({0.0, 0.01, 0.25});
    felt.session->stop();
    EXPECT_GT(felt.largest_N, 0.0);
    EXPECT_FALSE((*recorder)->finish("end").error);
    const auto reader = RecordingReader::open(path);
    ASSERT_TRUE(reader);
    const auto session = test::session_in(*reader);
    const auto proved = replay_recording(*reader, session, scene);
    ASSERT_TRUE(proved) << proved.error().to_string();
    EXPECT_FALSE(proved->difference) << proved->difference->column;
    EXPECT_FALSE(proved->stopped);
    if (stays) continue;  // the hand is free for two ticks, in which it touches nothing
    const auto without =
        replay_recording(*reader, session, scene, {.left_out = InputKind::kFreeHand});
    ASSERT_TRUE(without);
    EXPECT_TRUE(without->difference);
  }
}

TEST(StartInside, ALoopWithoutAPersonIsToldWhichNodeEnclosesItsBegin) {
  const Scene scene = scene_of({{"room", Vec3::Constant(0.2)}, {"box", Vec3::Constant(kHalf_m)}});
  EXPECT_EQ(enclosing_object(scene, {0.1, 0.0, 0.0}), 0u);
  EXPECT_TRUE(enclosing_object(scene, {0.01, 0.0, 0.0}).has_value());
  EXPECT_FALSE(enclosing_object(scene, {0.21, 0.0, 0.0}));
  EXPECT_FALSE(enclosing_object(scene, {5.0, 0.0, 0.0}));
  EXPECT_EQ(object_text(scene, 1), "node \"box\"");
}

}  // namespace
}  // namespace palpate
