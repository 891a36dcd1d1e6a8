// A recording keeps by which rules its scene was loaded and its work was counted, so that it gives
// the same bits again; recordings of older programs lack the keys, and are replayed by the rules
// of these programs.

#include <cmath>
#include <cstdint>
#include <sqlite3.h>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_reader.h"
#include "engine/recording/recording_replay.h"
#include "engine/recording/recording_settings.h"
#include "engine/scene/scene.h"
#include "engine/session/haptic_session.h"
#include "haptics/haptic_loop.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/generators.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Generators;
using test::GltfBuilder;
using test::Soup;
using test::TemporaryFolder;

constexpr std::uint64_t kTicks = 1500;
constexpr const char* kJoins = "scene.joins_within_rounding";
constexpr const char* kGaps = "scene.close_gaps_m";
constexpr const char* kCounting = "proxy.counting";

// A device that begins outside of a place, strokes it along two directions, and presses it again
// and again.
class StrokingDevice final : public VectorDevice {
 public:
  StrokingDevice(const Vec3& place_m, const Vec3& out, const Vec3& along_m, const Vec3& across_m)
      : place_m_(place_m), out_(out), along_m_(along_m), across_m_(across_m) {}
  Vec3 read_position_m(double dt_s) noexcept override {
    time_s_ += dt_s;
    const double height_m = 2e-3 * std::cos(9.0 * time_s_) - 1e-3;
    return place_m_ + height_m * out_ + std::sin(7.3 * time_s_) * along_m_ +
           std::sin(3.1 * time_s_) * across_m_;
  }
  void command_force_N(const Vec3&) noexcept override {}

 private:
  Vec3 place_m_, out_, along_m_, across_m_;
  double time_s_ = 0.0;
};

std::size_t add_mesh_of(GltfBuilder& gltf, const Soup& soup) {
  std::vector<Eigen::Vector3f> positions;
  for (const Vec3& p : soup.positions) positions.push_back(p.cast<float>());
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : soup.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const auto position = gltf.add_positions(positions);
  const auto index = gltf.add_indices(indices, GltfBuilder::kUnsignedInt);
  return gltf.add_mesh({{{"attributes", {{"POSITION", position}}}, {"indices", index}}});
}

struct RecordedScene {
  explicit RecordedScene(GltfBuilder gltf)
      : scene_file(gltf.write_glb(folder)), path(folder.path("a.palpate")) {}

  // Records a stroke over the scene. Returns the rows in contact.
  std::uint64_t record(RecordedSetup setup, StrokingDevice device) const {
    const auto scene = Scene::load(scene_file, setup.scene);
    EXPECT_TRUE(scene) << scene.error().to_string();
    setup.scene_path = scene_file;
    setup.virtual_time = true;
    const auto meta = meta_of(*scene, setup);
    EXPECT_TRUE(meta) << meta.error().to_string();
    auto recorder = Recorder::create(path, *meta, {.virtual_time = true});
    EXPECT_TRUE(recorder) << recorder.error().to_string();
    test::TickKeeper keeper(recorder->get());
    auto loop = test::made(HapticLoop::create(scene->world(), setup.actuation, setup.haptics));
    HapticSession session(loop, device, {.sink = &keeper});
    EXPECT_FALSE(session.start());
    for (std::uint64_t n = 0; n < kTicks; ++n) session.tick(1e-3);
    session.stop();
    EXPECT_EQ((*recorder)->finish("end").ticks, kTicks);
    std::uint64_t in_contact = 0;
    for (const RecordedTick& row : keeper.rows) in_contact += row.record.contact;
    return in_contact;
  }

  void edit(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    EXPECT_EQ(sqlite3_changes(database), 1) << sql;
    sqlite3_close(database);
  }
  void remove_key(const std::string& key) const {
    edit("DELETE FROM meta WHERE key = '" + key + "'");
  }
  bool has_key(const std::string& key) const {
    const auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader) << reader.error().to_string();
    return reader->meta()->contains(key);
  }

  // The scene as `replay` loads it.
  Scene loaded() const {
    const auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader) << reader.error().to_string();
    auto scene = load_recorded_scene(test::session_in(*reader), "");
    EXPECT_TRUE(scene) << scene.error().to_string();
    return std::move(*scene);
  }
  // True if every bit of every tick is computed again.
  bool replays() const {
    const auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader) << reader.error().to_string();
    const RecordedSession session = test::session_in(*reader);
    const auto scene = load_recorded_scene(session, "");
    EXPECT_TRUE(scene) << scene.error().to_string();
    const auto outcome = replay_recording(*reader, session, *scene);
    EXPECT_TRUE(outcome) << outcome.error().to_string();
    return !outcome->difference && !outcome->stopped && outcome->proved == kTicks;
  }

  TemporaryFolder folder;
  std::string scene_file;
  std::string path;
};

constexpr double kBall_m = 0.05;

// A sphere whose last column repeats the first one up to the rounding of the sine, in the plane
// z = 0 at x < 0.
GltfBuilder ball_of_generator() {
  GltfBuilder gltf;
  const auto mesh =
      add_mesh_of(gltf, Generators<float>::sphere(static_cast<float>(kBall_m), 24, 12));
  gltf.add_node({{"mesh", mesh}});
  return gltf;
}
StrokingDevice over_its_seam() {
  return {{-kBall_m, 0, 0}, -Vec3::UnitX(), {0, 0, 0.004}, {0, 0.008, 0}};
}

TEST(RecordedScene, ASeamOfAGeneratorIsJoinedAgainAndReplaysToTheBit) {
  const RecordedScene recorded(ball_of_generator());
  EXPECT_GT(recorded.record({}, over_its_seam()), kTicks / 4);
  EXPECT_TRUE(recorded.has_key(kJoins));
  EXPECT_FALSE(recorded.has_key(kGaps));
  const Scene scene = recorded.loaded();
  EXPECT_EQ(scene.statistics().cleaning.boundary_edges, 0u);
  EXPECT_GT(scene.statistics().rounding_joins.joined_vertices, 5u);
  EXPECT_TRUE(recorded.replays());
  // The seam decides bits: with the rule of an older program, the replay differs.
  recorded.remove_key(kJoins);
  EXPECT_FALSE(recorded.replays());
}

// An older program joined nothing, and wrote no key about it.
TEST(RecordedScene, WithoutTheKeyIsLoadedWithoutJoining) {
  const RecordedScene recorded(ball_of_generator());
  RecordedSetup before;
  before.scene.joins_within_rounding = false;
  EXPECT_GT(recorded.record(before, over_its_seam()), kTicks / 4);
  recorded.remove_key(kJoins);
  const Scene scene = recorded.loaded();
  EXPECT_GT(scene.statistics().cleaning.boundary_edges, 10u);
  EXPECT_EQ(scene.statistics().rounding_joins.joined_vertices, 0u);
  EXPECT_TRUE(recorded.replays());
}

// Boxes in a row whose translations are rounded to floats, as nodes of one that turns them.
constexpr double kBox_m = 0.02 / 7.0;
const Quat kTurn(Eigen::AngleAxisd(0.7, Vec3(0.2, 1.0, 0.3).normalized()));

GltfBuilder row_of_boxes() {
  GltfBuilder gltf;
  const auto mesh = add_mesh_of(gltf, test::box_soup(Vec3::Constant(0.5 * kBox_m)));
  nlohmann::json boxes = nlohmann::json::array();
  for (int i = 0; i < 5; ++i) {
    boxes.push_back(
        gltf.add_child({{"mesh", mesh}, {"translation", {static_cast<float>(i * kBox_m), 0, 0}}}));
  }
  gltf.add_node({{"children", boxes}, {"rotation", {kTurn.x(), kTurn.y(), kTurn.z(), kTurn.w()}}});
  return gltf;
}
StrokingDevice over_the_row() {
  return {kTurn * Vec3(2 * kBox_m, 0, 0.5 * kBox_m), kTurn * Vec3::UnitZ(),
          kTurn * Vec3(1.8 * kBox_m, 0, 0), kTurn * Vec3(0, 1e-4, 0)};
}

TEST(RecordedScene, NodesAreJoinedAgainAndReplayToTheBit) {
  const RecordedScene recorded(row_of_boxes());
  EXPECT_GT(recorded.record({}, over_the_row()), kTicks / 4);
  EXPECT_GT(recorded.loaded().statistics().changed_nodes, 0u);
  EXPECT_TRUE(recorded.replays());
  recorded.remove_key(kJoins);
  EXPECT_EQ(recorded.loaded().statistics().changed_nodes, 0u);
  EXPECT_FALSE(recorded.replays());
}

// Two squares with a gap of 2 mm, in one mesh.
GltfBuilder squares_with_a_gap() {
  Soup soup;
  for (const double y : {0.0, 0.102}) {
    soup.add_quad({0, y, 0}, {0.1, y, 0}, {0.1, y + 0.1, 0}, {0, y + 0.1, 0});
  }
  GltfBuilder gltf;
  gltf.add_node({{"mesh", add_mesh_of(gltf, soup)}});
  return gltf;
}

TEST(RecordedScene, AGapThatWasClosedIsClosedAgain) {
  const RecordedScene recorded(squares_with_a_gap());
  RecordedSetup closed;
  closed.scene.close_gaps_m = 0.003;
  const StrokingDevice over_the_gap({0.05, 0.101, 0}, Vec3::UnitZ(), {0, 0.002, 0}, {0.01, 0, 0});
  EXPECT_GT(recorded.record(closed, over_the_gap), kTicks / 4);
  EXPECT_TRUE(recorded.has_key(kGaps));
  EXPECT_EQ(recorded.loaded().statistics().gap_joins.joined_edges, 1u);
  EXPECT_TRUE(recorded.replays());
  recorded.remove_key(kGaps);
  EXPECT_EQ(recorded.loaded().statistics().gap_joins.joined_edges, 0u);
  EXPECT_FALSE(recorded.replays());
}

// A square in each of two scenes; the square of scene 1 lies higher, and has a hidden copy above
// it.
GltfBuilder two_scenes() {
  Soup soup;
  soup.add_quad({0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0});
  GltfBuilder gltf;
  const std::size_t mesh = add_mesh_of(gltf, soup);
  gltf.add_node({{"mesh", mesh}});
  gltf.json["nodes"].push_back({{"mesh", mesh}, {"translation", {0, 0, 0.05}}});
  gltf.json["nodes"].push_back({{"mesh", mesh},
                                {"translation", {0, 0, 0.0505}},
                                {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  gltf.json["scenes"].push_back({{"nodes", {1, 2}}});
  return gltf;
}

TEST(RecordedScene, IsTheChosenOneAgainWithoutHiddenNodes) {
  const RecordedScene recorded(two_scenes());
  RecordedSetup setup;
  setup.scene.listed_scene = "1";
  const StrokingDevice device({0.05, 0.05, 0.05}, Vec3::UnitZ(), {0.01, 0, 0}, {0, 0.01, 0});
  EXPECT_GT(recorded.record(setup, device), kTicks / 4);
  EXPECT_EQ(recorded.loaded().objects().size(), 1u);
  EXPECT_TRUE(recorded.replays());
  // Programs that felt hidden nodes did not write the key.
  recorded.remove_key("scene.feels_hidden");
  EXPECT_EQ(recorded.loaded().objects().size(), 2u);
  EXPECT_FALSE(recorded.replays());
  recorded.remove_key("scene.listed_scene");
  EXPECT_EQ(recorded.loaded().statistics().scenes.loaded, 0u);
}

TEST(RecordedScene, WithHiddenNodesThatWereFeltFeelsThemAgain) {
  const RecordedScene recorded(two_scenes());
  RecordedSetup setup;
  setup.scene.listed_scene = "1";
  setup.scene.feels_hidden = true;
  const StrokingDevice device({0.05, 0.05, 0.0505}, Vec3::UnitZ(), {0.01, 0, 0}, {0, 0.01, 0});
  EXPECT_GT(recorded.record(setup, device), kTicks / 4);
  EXPECT_EQ(recorded.loaded().objects().size(), 2u);
  EXPECT_TRUE(recorded.replays());
}

// Before the rule of counting had a number, less work counted and effects had no budget. A large
// sphere on a fine surface runs out of a small budget in most ticks.
TEST(RecordedScene, WithoutARuleOfCountingReplaysByTheFirstOne) {
  const auto setup_by = [](CountingRule rule) {
    RecordedSetup setup;
    setup.haptics.god_object.radius_m = 0.03;
    setup.scene.proxy_radius_m = 0.03;
    setup.haptics.god_object.accuracy.work_budget = 300;
    setup.haptics.god_object.accuracy.counting = rule;
    return setup;
  };
  const StrokingDevice device({-kBall_m - 0.03, 0, 0}, -Vec3::UnitX(), {0, 0, 0.008}, {0, 0.01, 0});
  {
    const RecordedScene recorded(ball_of_generator());
    EXPECT_GT(recorded.record(setup_by(CountingRule::kFirst), device), kTicks / 4);
    recorded.remove_key(kCounting);
    EXPECT_TRUE(recorded.replays());
    recorded.edit("UPDATE meta SET value = 300000 WHERE key = 'proxy.work_budget'");
    EXPECT_FALSE(recorded.replays()) << "the budget ended no tick";
  }
  const RecordedScene recorded(ball_of_generator());
  EXPECT_GT(recorded.record(setup_by(CountingRule::kSecond), device), kTicks / 4);
  EXPECT_TRUE(recorded.replays());
  recorded.remove_key(kCounting);
  EXPECT_FALSE(recorded.replays()) << "both rules count the same";
}

}  // namespace
}  // namespace palpate
