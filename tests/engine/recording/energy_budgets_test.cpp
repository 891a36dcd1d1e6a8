// The energy budgets of a run: in its recording, and in the replay.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/recording/recorder.h"
#include "engine/recording/recording_replay.h"
#include "engine/rig/rig.h"
#include "engine/simulation/port_device.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

using test::TemporaryFolder;

// A box whose front is the plane x = 0.
std::string box_file(const TemporaryFolder& folder) {
  test::GltfBuilder gltf;
  std::vector<Eigen::Vector3f> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back((k & 1) != 0 ? 0.0f : -0.1f, (k & 2) != 0 ? 0.1f : -0.1f,
                         (k & 4) != 0 ? 0.1f : -0.1f);
  }
  const auto positions = gltf.add_positions(corners);
  const auto indices = gltf.add_indices({0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
  gltf.add_mesh({{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}});
  gltf.add_node({{"mesh", 0}});
  return gltf.write_glb(folder);
}

// One motor along A1 and a wall that is turned by 45 degrees: a hand that presses and slides along
// the wall gets energy, which the missing motor gives.
struct MaskedWall {
  explicit MaskedWall(const EnergyBudgets& budgets)
      : file(box_file(folder)), scene(test::made(Scene::load(file, {}))), path(folder.path("a")) {
    RunSettings settings;
    settings.sensors = 2;
    settings.actuators = 1;
    settings.device = motor_device(1, 10.0, 1000.0);
    settings.device.delay = {1e-3, 1e-3};
    settings.haptics.coupling.stiffness_N_per_m = 200.0;
    settings.haptics.force = ForceMode::kActuated;
    settings.haptics.initial_pose.rotation = Quat(Eigen::AngleAxisd(kTurn_rad, Vec3::UnitZ()));
    settings.energy_budgets = budgets;
    const RunSetup setup = test::made(make_setup(settings));
    RecordedSetup recorded;
    recorded.scene_path = file;
    recorded.actuation = setup.actuation;
    recorded.haptics = setup.haptics;
    recorded.dt_s = setup.dt_s;
    recorded.virtual_time = true;
    auto recorder = test::made(
        Recorder::create(path, test::made(meta_of(scene, recorded)), {.virtual_time = true}));
    run(setup, *recorder);
    EXPECT_FALSE(recorder->finish("end").error);
  }

  RecordedSession session() const {
    const auto reader = test::made(RecordingReader::open(path));
    return test::made(session_of(test::made(reader.meta())));
  }
  ReplayOutcome replay(const RecordedSession& session) const {
    const auto reader = test::made(RecordingReader::open(path));
    return test::made(replay_recording(reader, session, scene));
  }

  static constexpr double kTurn_rad = 0.8;
  TemporaryFolder folder;
  std::string file;
  Scene scene;
  std::string path;
  GovernorStatus governor;
  std::uint32_t rules = 0;

 private:
  // The hand goes round and round: into the wall along the motor, and out across it.
  void run(const RunSetup& setup, Recorder& recorder) {
    const Mat3 R = Eigen::AngleAxisd(kTurn_rad, Vec3::UnitZ()).toRotationMatrix();
    PortDevice device({.device = setup.device,
                       .tip = {.hand = HandImpedance{}},
                       .start_m = R * Vec3(0.02, 0.0, 0.0),
                       .delay_s = 1e-3});
    auto rig = test::made(Rig::create(scene, setup, device, {.sink = &recorder}));
    EXPECT_FALSE(rig->session().start());
    TickRecord record;
    for (int n = 0; n < 6000; ++n) {
      const double angle = 0.01 * std::max(0, n - 1500);
      const Vec3 place_m(n < 1500 ? 0.02 : -0.005 + 0.015 * std::sin(angle),
                         n < 1500 ? 0.0 : -0.03 * std::cos(angle), 0.0);
      device.tip().set_hand(R * place_m);
      rig->session().tick(setup.dt_s, 0, 0);
      if (rig->session().latest(record)) rules |= record.rules;
    }
    rig->session().latest(governor);
    rig->session().stop();
  }
};

EnergyBudgets no_energy_of_motors() {
  EnergyBudgets budgets;
  budgets.of[static_cast<std::size_t>(EnergySource::kMotors)] = {0.0, 0.0};
  return budgets;
}

TEST(EnergyBudgetsOfARun, DecideWhatTheControllerTakesOut) {
  const MaskedWall usual({}), strict(no_energy_of_motors());
  const auto motors = static_cast<std::size_t>(EnergySource::kMotors);
  EXPECT_GT(usual.governor.given_by_source_J[motors], 1e-3);
  EXPECT_EQ(usual.rules & (kRuleDamping | kRuleSoft), 0u);
  EXPECT_NE(strict.rules & kRuleDamping, 0u);
}

TEST(EnergyBudgetsOfARun, AreInItsRecordingAndMakeItsReplay) {
  const EnergyBudgets strict = no_energy_of_motors();
  const MaskedWall recorded(strict);
  RecordedSession session = recorded.session();
  EXPECT_EQ(session.governor.budgets, strict);
  const ReplayOutcome same = recorded.replay(session);
  EXPECT_FALSE(same.difference);
  EXPECT_FALSE(same.stopped);
  EXPECT_EQ(same.proved, 6000u);
  // Others make other forces: the replay needs the recorded ones.
  session.governor.budgets = {};
  EXPECT_TRUE(recorded.replay(session).difference);
}

// A recording of a version in which the budgets were constants.
TEST(EnergyBudgetsOfARun, AreTheInitialOnesInARecordingWithoutThem) {
  const MaskedWall recorded({});
  const auto reader = test::made(RecordingReader::open(recorded.path));
  RecordingMeta meta = test::made(reader.meta());
  std::size_t keys = 0;
  for (auto entry = meta.begin(); entry != meta.end();) {
    const bool is_budget = entry->first.starts_with("session.energy_budgets.");
    keys += is_budget ? 1 : 0;
    entry = is_budget ? meta.erase(entry) : std::next(entry);
  }
  EXPECT_EQ(keys, 2 * kEnergySourceCount);
  const RecordedSession session = test::made(session_of(meta));
  EXPECT_EQ(session.governor.budgets, EnergyBudgets{});
  EXPECT_FALSE(recorded.replay(session).difference);
}

TEST(EnergyBudgetsOfARun, BeyondTheirRangeAreRefusedInARecording) {
  const MaskedWall recorded({});
  const auto reader = test::made(RecordingReader::open(recorded.path));
  for (const double wrong : {-1e-9, 1.0000001, std::nan("")}) {
    RecordingMeta meta = test::made(reader.meta());
    meta["session.energy_budgets.gravity_W"] = wrong;
    const auto session = session_of(meta);
    ASSERT_FALSE(session) << wrong;
    EXPECT_EQ(session.error().element, "session.energy_budgets.gravity_W");
  }
}

TEST(EnergyBudgetsOfARun, BeyondTheirRangeAreRefused) {
  for (const EnergyBudget& wrong : {EnergyBudget{-1e-9, 0.1}, EnergyBudget{0.1, 1.0000001},
                                    EnergyBudget{std::nan(""), 0.1}, EnergyBudget{1.1, 0.0}}) {
    RunSettings settings;
    settings.energy_budgets.of[static_cast<std::size_t>(EnergySource::kMagnet)] = wrong;
    const auto setup = make_setup(settings);
    ASSERT_FALSE(setup);
    EXPECT_EQ(setup.error().element, "energy_budgets");
    EXPECT_NE(setup.error().problem.find("for magnet; expected 0 to 1000 mJ and 0 to 1 W"),
              std::string::npos)
        << setup.error().problem;
  }
  for (const EnergyBudget& budget : EnergyBudgets{}.of) EXPECT_TRUE(budget.is_in_range());
}

}  // namespace
}  // namespace palpate
