// The main use case in virtual time: a simulated hand explores the shipped models.

#include "engine/simulation/exploration.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/rig/replay.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Compiled once for all tests.
const Scene& model(const std::string& name) {
  static std::map<std::string, Scene> scenes;
  auto found = scenes.find(name);
  if (found == scenes.end()) {
    auto scene = Scene::load(PALPATE_MODELS_DIR "/" + name + ".glb");
    if (!scene) ADD_FAILURE() << scene.error().to_string();
    found = scenes.emplace(name, std::move(*scene)).first;
  }
  return found->second;
}

RunSettings options_of(int sensors, int actuators, ForceMode force = ForceMode::kActuated) {
  RunSettings options;
  options.sensors = sensors;
  options.default_actuators = actuators;
  options.haptics.force = force;
  return options;
}

struct Condition {
  RunSettings options = options_of(2, 1);
  bool a4 = false;
  double start_deg = 0.0;  // rotation of the scene about A3
};

Result<ExplorationRun> try_explore(const std::string& name, const Condition& condition,
                                   const ExplorationSettings& settings) {
  auto setup = make_setup(condition.options);
  if (!setup) return setup.error();
  setup->haptics.a4.enabled = condition.a4;
  setup->haptics.initial_pose.rotation =
      Quat(Eigen::AngleAxisd(condition.start_deg * std::numbers::pi / 180, Vec3::UnitZ()));
  return explore(model(name), *setup, settings, [](double) {});
}

ExplorationRun explored(const std::string& name, const Condition& condition, std::uint64_t seed,
                        double seconds = 28.0) {
  ExplorationSettings settings;
  settings.virtual_time = true;
  settings.seed = seed;
  settings.seconds = seconds;
  auto run = try_explore(name, condition, settings);
  if (!run) {
    ADD_FAILURE() << run.error().to_string();
    return {};
  }
  return std::move(*run);
}

std::uint64_t fault_count(const ExplorationRun& run) {
  const auto& faults = run.summary.faults;
  return std::accumulate(faults.begin(), faults.end(), std::uint64_t{0});
}

std::vector<std::uint64_t> bits_of(const TickRecord& r) {
  std::vector<std::uint64_t> bits{r.tick, r.contact, r.faults,
                                  static_cast<std::uint64_t>(r.iterations)};
  const auto add = [&](double x) { bits.push_back(std::bit_cast<std::uint64_t>(x)); };
  add(r.time_s);
  add(r.alpha_rad);
  const std::span<const double> vectors[] = {
      r.device_m,       r.goal_scene_m,  r.proxy_scene_m, r.normal_scene, r.full_force_device_N,
      r.force_device_N, r.q_before_wxyz, r.o_before_m};
  for (const auto& vector : vectors) {
    for (const double x : vector) add(x);
  }
  return bits;
}

// First tick at which two runs differ by a bit; the number of ticks if none.
std::size_t first_difference(const ExplorationRun& a, const ExplorationRun& b) {
  EXPECT_EQ(a.records.size(), b.records.size());
  for (std::size_t n = 0; n < a.records.size(); ++n) {
    if (bits_of(a.records[n]) != bits_of(b.records[n])) return n;
  }
  return a.records.size();
}

// ---- the paper's four objects -------------------------------------------------------------------

struct Turn {
  const char* name;
  double start_deg;
};

void PrintTo(const Turn& turn, std::ostream* out) {
  *out << turn.name << " started at " << turn.start_deg << " deg";
}

class PaperObject : public testing::TestWithParam<Turn> {};

// The paper reports 32.1 deg with A4 and 49.4 deg without.
TEST_P(PaperObject, IsTurnedOnceAndA4LowersTheContactAngle) {
  const auto [name, start_deg] = GetParam();
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const bool a4 : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (a4 ? ", with A4" : ", without A4"));
      const ExplorationRun run = explored(name, {options_of(2, 1), a4, start_deg}, seed);
      EXPECT_EQ(run.a4, a4);
      EXPECT_EQ(run.summary.ticks, 28000u);
      EXPECT_GE(run.way_share, 0.97);
      EXPECT_LE(run.way_share, 1.0);
      EXPECT_EQ(fault_count(run), 0u);
      EXPECT_GT(run.summary.contact_ticks, 0.8 * 27000);
      if (a4) {
        EXPECT_LT(run.summary.mean_contact_angle_deg, 35.0);
      } else {
        EXPECT_GT(run.summary.mean_contact_angle_deg, 40.0);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BothStarts, PaperObject,
                         testing::Values(Turn{"star", 0}, Turn{"star", 45}, Turn{"labyrinth", 0},
                                         Turn{"labyrinth", 45}, Turn{"inverted_labyrinth", 0},
                                         Turn{"inverted_labyrinth", 45}, Turn{"lock", 0},
                                         Turn{"lock", 45}));

TEST(Exploration, TurnsAroundAStarInTheUsualTimesOf25To30Seconds) {
  for (const double seconds : {26.0, 31.0}) {  // including one second for the approach
    for (const bool a4 : {false, true}) {
      EXPECT_GE(explored("star", {options_of(2, 1), a4, 0}, 1, seconds).way_share, 0.99);
    }
  }
}

TEST(Exploration, KeepsTheHandAndTheProxyInThePlane) {
  Condition condition{options_of(2, 1), true, 30};
  condition.options.plane_height_m = 0.01;
  const ExplorationRun run = explored("lock", condition, 4, 6.0);
  for (const TickRecord& r : run.records) {
    ASSERT_EQ(vec3(r.device_m).z(), 0.01);
    ASSERT_NEAR(pose_before(r).point(vec3(r.proxy_scene_m)).z(), 0.01, 1e-15);
    ASSERT_EQ(vec3(r.force_device_N).z(), 0.0);
    ASSERT_EQ(vec3(r.force_device_N).y(), 0.0) << "nothing pushes along A2";
  }
}

// ---- one seed, one trace ------------------------------------------------------------------------

TEST(Exploration, GivesTheSameBitsForTheSameSeed) {
  for (const int sensors : {2, 3}) {
    const Condition condition{options_of(sensors, 1), true, 0};
    const std::string name = sensors == 2 ? "star" : "torus";
    const ExplorationRun a = explored(name, condition, 7, 10.0);
    const ExplorationRun b = explored(name, condition, 7, 10.0);
    EXPECT_EQ(first_difference(a, b), 10000u);
    EXPECT_EQ(a.way_share, b.way_share);
    EXPECT_EQ(a.summary.port_work_J, b.summary.port_work_J);
  }
}

TEST(Exploration, GivesADifferentMotionForADifferentSeed) {
  for (const int sensors : {2, 3}) {
    const Condition condition{options_of(sensors, 1), true, 0};
    const std::string name = sensors == 2 ? "star" : "torus";
    const ExplorationRun a = explored(name, condition, 7, 4.0);
    const ExplorationRun b = explored(name, condition, 8, 4.0);
    EXPECT_LT(first_difference(a, b), 100u);
  }
}

// dt is nominal: the clock of the machine has no effect.
TEST(Exploration, GivesTheSameBitsInRealTime) {
  ExplorationSettings settings;
  settings.seconds = 2.0;
  settings.seed = 5;
  const Condition condition{options_of(2, 1), true, 0};
  const auto real = try_explore("star", condition, settings);
  ASSERT_TRUE(real) << real.error().to_string();
  const ExplorationRun simulated = explored("star", condition, 5, 2.0);
  EXPECT_EQ(first_difference(*real, simulated), 2000u);
}

// An interrupted run equals the beginning of a complete run.
TEST(Exploration, EndsCleanlyWhenInterrupted) {
  const Condition condition{options_of(2, 1), true, 0};
  const ExplorationRun whole = explored("star", condition, 5, 20.0);
  auto setup = make_setup(condition.options);
  ASSERT_TRUE(setup);
  setup->haptics.a4.enabled = true;
  for (const bool virtual_time : {true, false}) {
    SCOPED_TRACE(virtual_time ? "virtual" : "real time");
    ExplorationSettings settings;
    settings.seconds = 20.0;
    settings.seed = 5;
    settings.virtual_time = virtual_time;
    StopFlag stop;
    double last_share = 0.0;
    const auto run = explore(
        model("star"), *setup, settings,
        [&](double share) {
          last_share = share;
          if (share > 0.06) stop.request();
        },
        &stop);
    ASSERT_TRUE(run) << run.error().to_string();
    EXPECT_TRUE(run->interrupted);
    EXPECT_GT(run->records.size(), 1200u);
    EXPECT_LT(run->records.size(), 20000u);
    EXPECT_LT(last_share, 1.0);
    EXPECT_EQ(run->summary.ticks, run->records.size());
    ExplorationRun part = whole;
    part.records.resize(run->records.size());
    EXPECT_EQ(first_difference(*run, part), run->records.size());
  }
}

TEST(Exploration, DoesNothingIfInterruptedBeforeTheStart) {
  const Condition condition{options_of(2, 1), false, 0};
  const auto setup = make_setup(condition.options);
  ASSERT_TRUE(setup);
  StopFlag stop;
  stop.request();
  for (const bool virtual_time : {true, false}) {
    ExplorationSettings settings;
    settings.virtual_time = virtual_time;
    const auto run = explore(
        model("star"), *setup, settings, [](double) {}, &stop);
    ASSERT_TRUE(run) << run.error().to_string();
    EXPECT_TRUE(run->interrupted);
    EXPECT_TRUE(run->records.empty());
    EXPECT_EQ(run->summary.ticks, 0u);
  }
}

// Replaying the device positions of a run gives the same run.
TEST(Exploration, CanBeReplayedFromItsDevicePositions) {
  const Condition condition{options_of(2, 1), true, 0};
  const ExplorationRun run = explored("star", condition, 2, 6.0);
  std::vector<Vec3> path;
  for (const TickRecord& r : run.records) path.push_back(vec3(r.device_m));
  auto setup = make_setup(condition.options);
  ASSERT_TRUE(setup);
  setup->haptics.a4.enabled = true;
  const Result<RunRecords> again = replay(model("star"), *setup, path, 2);
  ASSERT_TRUE(again);
  ASSERT_EQ(again->records.size(), run.records.size());
  for (std::size_t n = 0; n < path.size(); ++n) {
    ASSERT_EQ(bits_of(again->records[n]), bits_of(run.records[n])) << n;
  }
  EXPECT_EQ(again->summary.mean_contact_angle_deg, run.summary.mean_contact_angle_deg);
  EXPECT_EQ(again->summary.work_lost_J, run.summary.work_lost_J);
}

// ---- the walk with three sensors ----------------------------------------------------------------

TEST(Exploration, WalksOverATorusWithThreeSensors) {
  for (const int actuators : {1, 2}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(std::to_string(actuators) + " actuators, seed " + std::to_string(seed));
      const ExplorationRun off = explored("torus", {options_of(3, actuators), false, 0}, seed);
      const ExplorationRun on = explored("torus", {options_of(3, actuators), true, 0}, seed);
      for (const ExplorationRun* run : {&off, &on}) {
        EXPECT_EQ(fault_count(*run), 0u);
        EXPECT_GT(run->summary.contact_ticks, 0.95 * 28000);
        EXPECT_GE(run->way_share, 0.95);
        EXPECT_GT(run->summary.device_extent_m.maxCoeff(), 0.1) << "the hand moves";
      }
      EXPECT_LT(on.summary.mean_contact_angle_deg, 0.5 * off.summary.mean_contact_angle_deg);
      EXPECT_GT(on.summary.share_within_30deg, 0.9);
    }
  }
}

// At an edge the hand leaves the surface briefly and touches it again beyond the edge.
TEST(Exploration, WalksOverEdgesWithThreeSensors) {
  struct Walked {
    const char* name;
    double least_contact_share;
  };
  for (const auto& [name, least_contact_share] :
       {Walked{"cube", 0.87}, Walked{"lock", 0.7}, Walked{"star", 0.7}, Walked{"gallery", 0.5}}) {
    for (const int actuators : {1, 2}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        for (const bool a4 : {false, true}) {
          SCOPED_TRACE(std::string(name) + ", " + std::to_string(actuators) + " actuators, seed " +
                       std::to_string(seed) + (a4 ? ", with A4" : ", without A4"));
          const ExplorationRun run = explored(name, {options_of(3, actuators), a4, 0}, seed);
          EXPECT_EQ(fault_count(run), 0u);
          EXPECT_GT(run.summary.contact_ticks, least_contact_share * 28000);
          EXPECT_GE(run.way_share, 0.9);
          EXPECT_LT(run.summary.longest_gap_ticks, 2800u);
        }
      }
    }
  }
}

TEST(Exploration, DoesNotRotateAFullyActuatedScene) {
  for (const int sensors : {2, 3}) {
    const std::string name = sensors == 2 ? "star" : "torus";
    const ExplorationRun run = explored(name, {options_of(sensors, sensors), true, 20}, 1);
    EXPECT_GT(run.summary.contact_ticks, 20000u);
    EXPECT_EQ(run.summary.work_lost_J, 0.0);
    EXPECT_LT(run.summary.mean_contact_angle_deg, 1e-6);
    const Quat start = pose_before(run.records.front()).rotation;
    EXPECT_EQ(pose_before(run.records.back()).rotation.coeffs(), start.coeffs());
  }
}

// ---- the paper's conditions: NoH, UaH and H, with and without rotation --------------------------

TEST(Exploration, RunsAllThreeForceConditionsWithAndWithoutRotation) {
  for (const bool a4 : {false, true}) {
    const ExplorationRun none = explored("star", {options_of(2, 1, ForceMode::kNone), a4, 0}, 1);
    const ExplorationRun actuated = explored("star", {options_of(2, 1), a4, 0}, 1);
    const ExplorationRun full = explored("star", {options_of(2, 1, ForceMode::kFull), a4, 0}, 1);
    for (const ExplorationRun* run : {&none, &actuated, &full}) {
      EXPECT_EQ(fault_count(*run), 0u);
      EXPECT_GT(run->summary.contact_ticks, 20000u);
      EXPECT_GT(run->way_share, 0.9);
      EXPECT_EQ(run->summary.mean_contact_angle_deg < 35.0, a4) << "for every force condition";
    }
    EXPECT_EQ(none.summary.port_work_J, 0.0);
    EXPECT_NE(none.summary.work_lost_J, 0.0);
    EXPECT_NE(actuated.summary.work_lost_J, 0.0);
    EXPECT_EQ(full.summary.work_lost_J, 0.0);
    // Less force, deeper in: H < UaH < NoH.
    EXPECT_LT(full.summary.mean_penetration_m, none.summary.mean_penetration_m);
    EXPECT_LT(actuated.summary.mean_penetration_m, none.summary.mean_penetration_m);
    if (!a4) {
      EXPECT_LT(full.summary.mean_penetration_m, actuated.summary.mean_penetration_m);
    }
  }
}

// ---- coverage of the path -----------------------------------------------------------------------

// By the definition, from the written files: steps along the contour, each compared with the
// nearest proxy position.
TEST(Exploration, ReportsTheShareOfTheContourNearTheProxy) {
  for (const double seconds : {28.0, 8.0}) {
    const ExplorationRun run = explored("lock", {options_of(2, 1), false, 0}, 3, seconds);
    EXPECT_EQ(run.near_m, 2e-3);
    ASSERT_GE(run.contour_scene_m.size(), 4u);
    EXPECT_EQ(run.contour_scene_m.front(), run.contour_scene_m.back());
    double length_m = 0.0;
    double covered_m = 0.0;
    for (std::size_t i = 0; i + 1 < run.contour_scene_m.size(); ++i) {
      const Vec3 from = run.contour_scene_m[i];
      const Vec3 way = run.contour_scene_m[i + 1] - from;
      constexpr int kSteps = 40;
      for (int k = 0; k < kSteps; ++k) {
        const Vec3 place = from + (k + 0.5) / kSteps * way;
        double nearest_m = HUGE_VAL;
        for (const TickRecord& r : run.records) {
          nearest_m = std::min(nearest_m, (vec3(r.proxy_scene_m) - place).norm());
        }
        length_m += way.norm() / kSteps;
        if (nearest_m <= run.near_m) covered_m += way.norm() / kSteps;
      }
    }
    EXPECT_NEAR(run.way_share, covered_m / length_m, 0.01);
  }
}

TEST(Exploration, ReportsTheShareOfThePlacesNearTheProxy) {
  const ExplorationRun run = explored("torus", {options_of(3, 1), true, 0}, 3);
  EXPECT_EQ(run.near_m, 0.01 * model("torus").statistics().extent_m.maxCoeff());
  EXPECT_TRUE(run.contour_scene_m.empty());
  ASSERT_GE(run.places_scene_m.size(), 5u);
  std::size_t reached = 0;
  for (const Vec3& place : run.places_scene_m) {
    reached += std::any_of(run.records.begin(), run.records.end(), [&](const TickRecord& r) {
      return (vec3(r.proxy_scene_m) - place).norm() <= run.near_m;
    });
  }
  EXPECT_EQ(run.way_share,
            static_cast<double>(reached) / static_cast<double>(run.places_scene_m.size()));
}

TEST(Exploration, ReportsTheLongestIntervalWithoutContact) {
  const ExplorationRun run = explored("star", {options_of(2, 1), true, 0}, 1);
  std::uint64_t gap = 0;
  std::uint64_t longest = 0;
  bool touched = false;
  for (const TickRecord& r : run.records) {
    touched = touched || r.contact;
    gap = r.contact ? 0 : gap + 1;
    if (touched) longest = std::max(longest, gap);
  }
  EXPECT_GT(longest, 0u);
  EXPECT_EQ(run.summary.longest_gap_ticks, longest);
}

// ---- a hand that observes the proxy -------------------------------------------------------------

struct Part {
  test::Soup soup;
  Vec3 middle_m;
};

// Explored with one motor, without A4 and with it.
void expect_followed(const std::vector<Part>& parts, double least_share, int sensors = 2) {
  SceneDescription description;
  for (const Part& part : parts) {
    MeshDescription mesh;
    mesh.positions = part.soup.positions;
    mesh.triangles = part.soup.triangles;
    NodeDescription node;
    node.name = "part " + std::to_string(description.nodes.size());
    node.mesh = static_cast<std::uint32_t>(description.meshes.size());
    node.translation_m = part.middle_m;
    description.meshes.push_back(std::move(mesh));
    description.nodes.push_back(node);
  }
  const auto scene = Scene::compile(std::move(description));
  ASSERT_TRUE(scene) << scene.error().to_string();
  for (const bool a4 : {false, true}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE((a4 ? "with A4, seed " : "without A4, seed ") + std::to_string(seed));
      auto setup = make_setup(options_of(sensors, 1));
      ASSERT_TRUE(setup);
      setup->haptics.a4.enabled = a4;
      ExplorationSettings settings;
      settings.virtual_time = true;
      settings.seed = seed;
      const auto run = explore(*scene, *setup, settings, [](double) {});
      ASSERT_TRUE(run) << run.error().to_string();
      EXPECT_GE(run->way_share, least_share);
      EXPECT_GT(run->summary.contact_share(), 0.7);
      EXPECT_LT(run->summary.longest_gap_ticks, 2800u);
    }
  }
}

// Without a motor along a long wall the hand lags behind, and could turn the corner inside the
// wall.
TEST(PathPlan, TurnsTheCornersOfABar) {
  expect_followed({{test::box_soup({0.015, 0.1, 0.02}), Vec3::Zero()}}, 0.9);
  expect_followed({{test::box_soup({0.1, 0.015, 0.02}), Vec3::Zero()}}, 0.9);
}

// The plate is thinner than the press depth.
TEST(PathPlan, FollowsAThinPlateAllAround) {
  expect_followed({{test::box_soup({0.0005, 0.08, 0.02}), Vec3::Zero()}}, 0.9);
}

// The path does not begin inside the other part, and the hand does not slip off at the contour's
// end.
TEST(PathPlan, BeginsInFreeSpace) {
  const test::Soup box = test::box_soup({0.03, 0.03, 0.02});
  expect_followed({{box, Vec3(-0.033, 0.0, 0.0)}, {box, Vec3(0.033, 0.0, 0.0)}}, 0.85);
  test::Soup sheet;
  sheet.add_quad({-0.1, 0.0, -0.02}, {0.1, 0.0, -0.02}, {0.1, 0.0, 0.02}, {-0.1, 0.0, 0.02});
  expect_followed({{sheet, Vec3::Zero()}}, 0.9);
}

// Curves inside another part do not belong to the outline. A shell without a bottom is also a part.
TEST(PathPlan, FollowsTheUnionOfPartsAllAround) {
  const test::Soup bar = test::box_soup({0.08, 0.02, 0.02});
  const test::Soup post = test::box_soup({0.02, 0.06, 0.02});
  expect_followed({{bar, Vec3::Zero()}, {post, Vec3::Zero()}}, 0.9);
  test::Soup shell;
  shell.add_quad({0.03, 0, -0.02}, {0.03, 0.03, -0.02}, {0.03, 0.03, 0.02}, {0.03, 0, 0.02});
  shell.add_quad({0.03, 0.03, -0.02}, {-0.03, 0.03, -0.02}, {-0.03, 0.03, 0.02},
                 {0.03, 0.03, 0.02});
  shell.add_quad({-0.03, 0.03, -0.02}, {-0.03, 0, -0.02}, {-0.03, 0, 0.02}, {-0.03, 0.03, 0.02});
  expect_followed({{bar, Vec3::Zero()}, {shell, Vec3(0.0, 0.02, 0.0)}}, 0.9);
}

TEST(PathPlan, WalksOverBoxesThatTouch) {
  const test::Soup box = test::box_soup({0.06, 0.05, 0.04});
  expect_followed({{box, Vec3::Zero()}}, 0.9, 3);
  expect_followed({{box, Vec3(-0.06, 0.0, 0.0)}, {box, Vec3(0.06, 0.0, 0.0)}}, 0.9, 3);
  expect_followed({{box, Vec3(-0.06, 0.0, 0.0)}, {box, Vec3(0.0, 0.0, 0.08)}}, 0.9, 3);
}

// A hand that slips off is behind the sheet and continues there.
TEST(PathPlan, WalksOverSheetsAndATriangle) {
  test::Soup sheet;
  sheet.add_quad({-0.1, -0.08, 0.0}, {0.1, -0.08, 0.0}, {0.1, 0.08, 0.0}, {-0.1, 0.08, 0.0});
  expect_followed({{sheet, Vec3::Zero()}}, 0.9, 3);
  test::Soup upright;
  upright.add_quad({0.0, -0.1, -0.03}, {0.0, 0.1, -0.03}, {0.0, 0.1, 0.03}, {0.0, -0.1, 0.03});
  expect_followed({{upright, Vec3::Zero()}}, 0.9, 3);
  test::Soup triangle;
  triangle.add({-0.08, -0.06, 0.0}, {0.09, -0.05, 0.02}, {0.0, 0.1, 0.01});
  expect_followed({{triangle, Vec3::Zero()}}, 0.9, 3);
}

TEST(Exploration, FlagsATravelBeyondTheWorkspace) {
  ExplorationSettings settings;
  settings.virtual_time = true;
  settings.seconds = 10.0;
  Condition narrow;
  set_workspace_extent(narrow.options.device, 0.05);
  const auto small = try_explore("star", narrow, settings);
  const auto large = try_explore("star", {}, settings);
  ASSERT_TRUE(small && large);
  EXPECT_TRUE(small->exceeds_workspace);
  EXPECT_FALSE(large->exceeds_workspace);
}

// ---- rejected settings --------------------------------------------------------------------------

std::string refused_option(const Condition& condition, ExplorationSettings settings) {
  settings.virtual_time = true;
  const auto run = try_explore("star", condition, settings);
  return run ? "" : run.error().element;
}

TEST(Exploration, RejectsInvalidSettings) {
  Condition outside;
  outside.options.plane_height_m = 0.5;
  EXPECT_EQ(refused_option(outside, {}), "plane_height_m");
  ExplorationSettings settings;
  for (const double seconds : {kNan, -1.0, 0.5, 1e12, HUGE_VAL}) {
    settings.seconds = seconds;
    EXPECT_EQ(refused_option({}, settings), "seconds") << seconds;
  }
  settings = {};
  for (const double workspace_m : {kNan, 0.0, -1.0}) {
    Condition none;
    set_workspace_extent(none.options.device, workspace_m);
    EXPECT_EQ(refused_option(none, settings), "device.workspace") << workspace_m;
  }
  for (const double rate_Hz : {1e-12, 0.999, 1e12}) {
    Condition rate;
    rate.options.rate_Hz = rate_Hz;
    EXPECT_EQ(refused_option(rate, {}), rate_Hz < 1.0 ? "rate_Hz" : "seconds") << rate_Hz;
  }
  Condition damped;
  damped.options.device.damping_Ns_per_m = 1e5;
  EXPECT_EQ(refused_option(damped, {}), "device.damping_Ns_per_m");
  // explore() rejects before the first tick the settings that a loop would reject in every tick.
  Condition hard;
  hard.options.haptics.coupling.stiffness_N_per_m = 1e300;
  EXPECT_EQ(refused_option(hard, {}), "coupling.stiffness_N_per_m");
  Condition large;
  large.options.haptics.god_object.radius_m = 1e-3;  // the scene was loaded for a point
  EXPECT_EQ(refused_option(large, {}), "god_object.radius_m");
}

// ---- memory -------------------------------------------------------------------------------------

// Each step that lacks memory has its own remedy.
TEST(Exploration, ProposesARemedyForTheStepThatLacksMemory) {
  ExplorationSettings settings;
  settings.seconds = 2.0;
  const std::uint64_t records = 2000 * (sizeof(TickRecord) + sizeof(std::int64_t));
  const auto refused = [&](std::uint64_t bytes, std::uint64_t taken) {
    settings.max_memory_bytes = bytes;
    settings.taken_memory_bytes = taken;
    const auto run = try_explore("star", {options_of(2, 1), false, 0}, settings);
    EXPECT_FALSE(run) << bytes;
    return run ? Error{} : run.error();
  };
  const Error before = refused(1000, 1001);
  EXPECT_NE(before.hint.find("SceneSettings::node"), std::string::npos) << before.to_string();
  const Error recording = refused(records - 1, 0);
  EXPECT_EQ(recording.element, "seconds");
  EXPECT_NE(recording.hint.find("shorter run"), std::string::npos) << recording.to_string();
  const Error cutting = refused(records + 1, 0);
  EXPECT_NE(cutting.problem.find("cutting"), std::string::npos) << cutting.to_string();
  EXPECT_NE(cutting.hint.find("`RunSettings::sensors` 3"), std::string::npos)
      << cutting.to_string();
  EXPECT_EQ(cutting.hint.find("shorter run"), std::string::npos) << cutting.to_string();
}

// ---- display ------------------------------------------------------------------------------------

// The camera metaphor changes only the display: To = 0, Ts = -Tu.
TEST(CameraMetaphor, ChangesTheDisplayButNotTheTrace) {
  const ExplorationRun run = explored("star", {options_of(2, 1), true, 0}, 3, 6.0);
  auto setup = make_setup(options_of(2, 1));
  ASSERT_TRUE(setup);
  setup->haptics.a4.enabled = true;
  std::array<HapticLoop, 2> loops{
      test::made(HapticLoop::create(model("star").world(), setup->actuation, setup->haptics)),
      test::made(HapticLoop::create(model("star").world(), setup->actuation, setup->haptics))};
  const std::array modes{DisplayMode::kClassical, DisplayMode::kCamera};
  for (const TickRecord& played : run.records) {
    std::array<RigidTransform, 2> shown;
    std::array<TickRecord, 2> records;
    for (std::size_t i = 0; i < 2; ++i) {
      records[i] = loops[i].tick(vec3(played.device_m), setup->dt_s);
      shown[i] =
          display_transform(modes[i], loops[i].T_device_scene(), vec3(records[i].proxy_scene_m));
    }
    ASSERT_EQ(bits_of(records[0]), bits_of(played));
    ASSERT_EQ(bits_of(records[1]), bits_of(played));
    ASSERT_EQ(shown[0].rotation.coeffs(), shown[1].rotation.coeffs());
    ASSERT_GT((shown[0].translation_m - shown[1].translation_m).norm(), 0.01);
    ASSERT_LE(shown[1].point(vec3(played.proxy_scene_m)).norm(), 1e-15)
        << "the proxy is at the centre";
  }
}

}  // namespace
}  // namespace palpate
