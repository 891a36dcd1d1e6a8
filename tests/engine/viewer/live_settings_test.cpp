// Settings that a page changes, as they reach the haptic thread.

#include "engine/viewer/live_settings.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/session/haptic_session.h"
#include "engine/session/run_setting.h"
#include "engine/session/run_setup.h"
#include "engine/viewer/held_device.h"
#include "engine/viewer/page_settings.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"

namespace palpate::test {
namespace {

constexpr std::size_t kA4 = live_setting("a4");
constexpr std::size_t kForce = live_setting("force");
constexpr std::size_t kStiffness = live_setting("stiffness");
constexpr std::size_t kDamping = live_setting("damping");

Scene loaded_scene(const std::string& model) {
  auto scene = Scene::load(PALPATE_MODELS_DIR "/" + model);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return std::move(*scene);
}

const Scene& star() {
  static const Scene scene = loaded_scene("star.glb");
  return scene;
}

PlantSettings quiet_plant(const RunSetup& setup) {
  PlantSettings plant;
  plant.device = setup.device;
  plant.intention_noise_m = 0.0;
  return plant;
}

// A target that moves slowly from outside of the star through its middle and back.
class Sweep final : public HandPlan {
 public:
  HandTarget target(double time_s, const ScenePose&, const TickRecord&) noexcept override {
    return {{-0.12 * std::cos(3.0 * time_s), 0.02, 0.0}, Vec3::Zero()};
  }
};

class Records final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    all.push_back(record);
    all.back().step_ns = 0;  // measured
  }
  std::vector<TickRecord> all;
};

RunSetup made_setup(const RunSettings& settings) {
  const auto setup = make_setup(settings);
  EXPECT_TRUE(setup.ok()) << setup.error().to_string();
  return *setup;
}

RunSettings planar_settings() {
  RunSettings settings;
  settings.sensors = 2;
  settings.actuators = 1;
  settings.haptics.a4.enabled = true;
  return settings;
}

// A session in simulated time with a device whose motors follow the settings.
struct Rig {
  explicit Rig(const RunSettings& settings)
      : setup(made_setup(settings)),
        live(star(), setup),
        simulated(quiet_plant(setup), plan, {-0.12, 0.02, 0.0}, setup.haptics.initial_pose,
                  setup.actuation.is_planar()),
        held(simulated, live),
        loop(test::made(HapticLoop::create(star().world(), setup.actuation, setup.haptics))),
        session(loop, held,
                {.changes = {&live}, .observers = {&records, &simulated}, .takes_motors = false}) {
    session.start();
  }
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) session.tick(setup.dt_s);
  }

  RunSetup setup;
  Sweep plan;
  LiveSettings live;
  SimulatedDevice simulated;
  HeldDevice held;
  Records records;
  HapticLoop loop;
  HapticSession session;
};

int contacts(const std::vector<TickRecord>& records) {
  int count = 0;
  for (const TickRecord& record : records) count += record.contact;
  return count;
}

void expect_same_bits(const Rig& a, const Rig& b) {
  ASSERT_EQ(a.records.all.size(), b.records.all.size());
  for (std::size_t n = 0; n < a.records.all.size(); ++n) {
    ASSERT_EQ(std::memcmp(&a.records.all[n], &b.records.all[n], sizeof(TickRecord)), 0)
        << "tick " << n;
  }
}

// The motors are those of the description, which a page's motors replace: the records tell whether
// the governor and the loop agree.
TEST(LiveSettings, SetBeforeTheFirstTickEqualThoseOfTheStart) {
  RunSettings other = planar_settings();
  other.haptics.a4.enabled = false;
  other.haptics.coupling.stiffness_N_per_m = 321.0;
  other.haptics.coupling.damping_Ns_per_m = 1.5;
  other.actuated_axes = {Vec3(0.6, 0.8, 0.0)};
  Rig started(other);
  Rig switched(planar_settings());
  ASSERT_FALSE(switched.live.set(kA4, 0.0));
  ASSERT_FALSE(switched.live.set(kStiffness, 321.0));
  ASSERT_FALSE(switched.live.set(kDamping, 1.5));
  ASSERT_FALSE(switched.live.set_axes({Vec3(0.6, 0.8, 0.0)}));
  started.run(1500);
  switched.run(1500);
  EXPECT_GT(contacts(started.records.all), 100);
  expect_same_bits(started, switched);
}

TEST(LiveSettings, ApplyInTheNextTickAllAtOnce) {
  Rig rig(planar_settings());
  rig.run(10);
  ASSERT_FALSE(rig.live.set(kA4, 0.0));
  ASSERT_FALSE(rig.live.set(kForce, static_cast<double>(ForceMode::kFull)));
  rig.run(1500);
  int pressed = 0;
  for (std::size_t n = 10; n < rig.records.all.size(); ++n) {
    const TickRecord& record = rig.records.all[n];
    ASSERT_EQ(record.rotation_rad, 0.0);
    ASSERT_EQ(vec3(record.force_device_N), vec3(record.full_force_device_N)) << "tick " << n;
    ASSERT_EQ(record.faults, 0u);
    ASSERT_EQ(record.rules, 0u) << "the governor dropped what its motors cannot push";
    pressed += record.contact;
  }
  EXPECT_GT(pressed, 100);
}

// Keeps the inputs of a session.
class Inputs final : public TickSink {
 public:
  void on_start(const SessionFacts&) noexcept override {}
  void on_input(const TickInput& input) noexcept override {
    kinds.push_back(input.kind);
    for (const LiveChange& change : LiveChanges(input).all()) changes.push_back(change);
    if (replayed == nullptr) return;
    EXPECT_TRUE(LoopChanges(*replayed).make(input));
  }
  void on_tick(const TickRecord&, const TickReading&) noexcept override {}
  void on_trip(const GovernorTrip&) noexcept override {}
  void on_late(LateCause, const TickCost&) noexcept override {}
  std::vector<InputKind> kinds;
  std::vector<LiveChange> changes;
  HapticLoop* replayed = nullptr;  // gets each input, as the loop of a replay does
};

// What is tested of each line of kLiveSettings is what a line gives that is added.

// Another value that a page may set.
double other_value(const LiveSetting& setting, double now) {
  if (setting.kind() != LiveSetting::Kind::kNumber) return now == 0.0 ? 1.0 : 0.0;
  return 0.5 * now + 0.25;
}

// Each setting reaches the loop alone, a recording gets one input for it, and a replay of this
// input changes the same. What the loop has already is no input.
TEST(AddedLiveSetting, ReachesTheLoopARecordingAndItsReplay) {
  const RunSetup setup = made_setup(planar_settings());
  LiveSettings live(star(), setup);
  auto loop = test::made(HapticLoop::create(star().world(), setup.actuation, setup.haptics));
  auto replayed = test::made(HapticLoop::create(star().world(), setup.actuation, setup.haptics));
  Inputs inputs;
  inputs.replayed = &replayed;
  const auto tick = [&] { live.before_tick(0.0, LoopChanges(loop, &inputs)); };
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    SCOPED_TRACE(kLiveSettings[i].name);
    const HapticSettings before = loop.settings();
    const double value = other_value(kLiveSettings[i], live.value(i));
    ASSERT_FALSE(live.set(i, value));
    tick();
    ASSERT_EQ(inputs.kinds, std::vector{InputKind::kSetting});
    ASSERT_EQ(inputs.changes.size(), 1u);
    EXPECT_EQ(inputs.changes[0].setting, i);
    EXPECT_EQ(inputs.changes[0].value, value);
    for (std::size_t k = 0; k < kLiveSettings.size(); ++k) {
      const double expected = k == i ? value : kLiveSettings[k].value(before);
      EXPECT_EQ(kLiveSettings[k].value(loop.settings()), expected);
      EXPECT_EQ(kLiveSettings[k].value(replayed.settings()), expected);
    }
    ASSERT_FALSE(live.set(i, value));  // again
    tick();
    EXPECT_EQ(inputs.kinds.size(), 1u);
    EXPECT_FALSE(live.is_pending());
    inputs.kinds.clear();
    inputs.changes.clear();
  }
  inputs.replayed = nullptr;
  ASSERT_FALSE(live.set_axes({Vec3(0, 1, 0)}));
  tick();
  EXPECT_EQ(inputs.kinds, std::vector{InputKind::kActuation});
}

// The control of the page has unit, range, words and value of the setting of the run, and changes
// the member of HapticSettings that this one has.
TEST(AddedLiveSetting, IsOnThePageAsTheSettingOfARunStates) {
  const RunSetup setup = made_setup(planar_settings());
  LiveSettings live(star(), setup);
  MaterialTuner tuner(star());
  PageSettings page(star(), live, tuner, false, true);
  const auto list = page.list();
  ASSERT_EQ(list.size(), kLiveSettings.size());
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    const LiveSetting& setting = kLiveSettings[i];
    SCOPED_TRACE(setting.name);
    const auto& shown = list[i];
    const RunSetting& of_run = setting.of_run();
    EXPECT_EQ(of_run.field, setting.field);
    EXPECT_EQ(shown["name"], setting.name);
    EXPECT_EQ(shown["label"], setting.label);
    EXPECT_EQ(shown["key"], setting.key);
    HapticSettings settings = setup.haptics;
    const double value = other_value(setting, setting.value(settings));
    setting.put(settings, value);
    EXPECT_EQ(setting.value(settings), value);
    if (const auto* flag = std::get_if<SettingPlace<bool>>(&of_run.value)) {
      EXPECT_EQ(shown["kind"], "flag");
      EXPECT_EQ(flag->in_haptics(settings), value == 1.0);
    } else if (const auto* choice = std::get_if<SettingChoice>(&of_run.value)) {
      EXPECT_EQ(shown["kind"], "choice");
      ASSERT_EQ(shown["choices"].size(), choice->words.size());
      for (std::size_t k = 0; k < choice->words.size(); ++k) {
        EXPECT_EQ(shown["choices"][k], choice->words[k]);
      }
      EXPECT_EQ(static_cast<double>(choice->get(settings)), value);
    } else {
      EXPECT_EQ(shown["kind"], "number");
      EXPECT_EQ(shown["unit"], of_run.unit);
      EXPECT_FALSE(of_run.unit.empty());
      EXPECT_EQ(shown["low"], of_run.range.least);
      EXPECT_LE(shown["high"], of_run.range.most);
      const auto* number = std::get_if<SettingPlace<double>>(&of_run.value);
      ASSERT_NE(number, nullptr);
      EXPECT_EQ(number->in_haptics(settings), value);
    }
  }
}

TEST(AddedLiveSetting, IsInTheReferenceByTheLabelOfThePage) {
  std::ifstream file(std::string(PALPATE_MODELS_DIR) + "/../docs/reference/view.md");
  std::string text;  // of one line, wherever it breaks in the file
  for (std::string word; file >> word;) text += (text.empty() ? "" : " ") + word;
  LiveSettings live(star(), made_setup(planar_settings()));
  MaterialTuner tuner(star());
  std::string labels;
  for (const auto& shown : PageSettings(star(), live, tuner, true, true).list()) {
    labels += (labels.empty() ? "" : ", ") + shown["label"].get<std::string>();
  }
  EXPECT_NE(text.find(labels), std::string::npos) << "docs/reference/view.md lacks: " << labels;
}

// A recording may be hostile.
TEST(LiveChanges, AreThoseThatTheSettingsCanHave) {
  const auto changes = [](InputKind kind, std::uint32_t handle, std::vector<double> numbers) {
    return LiveChanges({kind, handle, std::as_bytes(std::span(numbers))}).all().size();
  };
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  for (const LiveSetting& setting : kLiveSettings) {
    EXPECT_EQ(changes(InputKind::kSetting, setting.number, {1.0}), 1u);
    for (const double wrong : {nan, infinite, -infinite}) {
      EXPECT_EQ(changes(InputKind::kSetting, setting.number, {wrong}), 0u) << setting.name;
    }
    if (setting.kind() == LiveSetting::Kind::kNumber) continue;
    for (const double wrong : {-1.0, 0.5, 3.0, 1e300}) {
      EXPECT_EQ(changes(InputKind::kSetting, setting.number, {wrong}), 0u) << setting.name;
    }
  }
  EXPECT_EQ(changes(InputKind::kSetting, 0, {1.0}), 0u);
  EXPECT_EQ(changes(InputKind::kSetting, 1000, {1.0}), 0u);
  // Of earlier versions.
  EXPECT_EQ(changes(InputKind::kA4, 7, {}), 1u);
  EXPECT_EQ(changes(InputKind::kForce, 2, {}), 1u);
  EXPECT_EQ(changes(InputKind::kForce, 3, {}), 0u);
  EXPECT_EQ(changes(InputKind::kCoupling, 0, {500.0, 1.0}), 2u);
  EXPECT_EQ(changes(InputKind::kCoupling, 0, {500.0, nan}), 0u);
  EXPECT_EQ(changes(InputKind::kCoupling, 0, {nan, 1.0}), 0u);
}

// The commanded force lies in the span of the axes, and the governor drops nothing of it.
TEST(LiveSettings, MotorsFollowTheAxesFromTickToTick) {
  RunSettings soft = planar_settings();
  soft.haptics.coupling.stiffness_N_per_m = 100.0;  // the force stays below the device's peak
  Rig rig(soft);
  ASSERT_FALSE(rig.live.set(kA4, 0.0));
  rig.run(450);
  int pressed = 0;
  for (int n = 0; n < 600; ++n) {
    const double angle = 0.01 * n;
    const Vec3 axis(std::cos(angle), std::sin(angle), 0.0);
    ASSERT_FALSE(rig.live.set_axes({axis}));
    rig.run(1);
    const TickRecord& record = rig.records.all.back();
    const Vec3 force_N = vec3(record.force_device_N);
    const Vec3 full_N = vec3(record.full_force_device_N);
    // Two roundings of the axis and of its products.
    ASSERT_LE((force_N - full_N.dot(axis) * axis).norm(), 0x1p-49 * full_N.norm());
    ASSERT_EQ(record.faults, 0u);
    ASSERT_EQ(record.rules, 0u);
    pressed += record.contact;
  }
  EXPECT_GT(pressed, 100);
  ASSERT_FALSE(rig.live.set_axes({}));
  rig.run(1);
  EXPECT_EQ(vec3(rig.records.all.back().force_device_N), Vec3(Vec3::Zero()));
}

// The device gets its motors again when they change, and not with every setting.
TEST(LiveSettings, GiveMotorsOnlyWhenAxesOrForceChange) {
  const RunSetup setup = made_setup(planar_settings());
  LiveSettings live(star(), setup);
  auto loop = test::made(HapticLoop::create(star().world(), setup.actuation, setup.haptics));
  const auto motors = [&] {
    live.take();
    const std::size_t count = live.motors().size();
    live.before_tick(0.0, LoopChanges(loop));
    return count;
  };
  ASSERT_FALSE(live.set(kStiffness, 321.0));
  ASSERT_FALSE(live.set(kA4, 0.0));
  EXPECT_EQ(motors(), 0u);
  ASSERT_FALSE(live.set(kForce, static_cast<double>(ForceMode::kFull)));
  EXPECT_EQ(motors(), 2u);
  EXPECT_EQ(motors(), 0u);
  ASSERT_FALSE(live.set(kForce, static_cast<double>(ForceMode::kNone)));
  EXPECT_EQ(motors(), 1u);
  ASSERT_FALSE(live.set_axes({Vec3(0, 1, 0)}));
  EXPECT_EQ(motors(), 1u);
  ASSERT_FALSE(live.set(kDamping, 1.5));
  EXPECT_EQ(motors(), 0u);
}

TEST(LiveSettings, RefuseWhatALoopWouldRefuse) {
  Rig rig(planar_settings());
  for (const double wrong :
       {-1.0, -1e-300, 5000.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(rig.live.set(kStiffness, wrong)) << wrong;
    EXPECT_TRUE(rig.live.set(kDamping, wrong)) << wrong;
  }
  EXPECT_TRUE(rig.live.set(kDamping, 50.1));
  const double nan = std::nan("");
  for (const std::vector<Vec3>& wrong :
       {std::vector{Vec3(0, 0, 1)}, std::vector{Vec3(0, 0, 0)}, std::vector{Vec3(nan, 0, 0)},
        std::vector{Vec3(1, 0, 0), Vec3(2, 0, 0)},
        std::vector{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)}}) {
    const auto error = rig.live.set_axes(wrong);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->element, "axes");
  }
  EXPECT_EQ(rig.live.value(kStiffness), 1000.0);
  EXPECT_EQ(rig.live.axes().size(), 1u);
  Rig left(planar_settings());
  rig.run(800);
  left.run(800);
  expect_same_bits(rig, left);
}

// Before the first contact, a pause changes no bit. In contact, the force is zero during the pause.
TEST(HeldDevice, StandsStillWhilePaused) {
  Rig rig(planar_settings());
  Rig left(planar_settings());
  const auto set_paused = [&](bool paused) {
    rig.held.set_paused(paused);
    rig.session.set_paused(paused);
  };
  rig.run(50);
  ASSERT_EQ(contacts(rig.records.all), 0);
  set_paused(true);
  rig.run(700);
  EXPECT_EQ(rig.records.all.size(), 50u);
  set_paused(false);
  rig.run(450);
  left.run(500);
  EXPECT_GT(contacts(left.records.all), 10);
  expect_same_bits(rig, left);
  set_paused(true);
  const DeviceSample first = rig.held.read(rig.setup.dt_s);
  rig.run(100);
  const DeviceSample last = rig.held.read(rig.setup.dt_s);
  EXPECT_EQ(first.position_m, last.position_m);
  EXPECT_EQ(first.sequence, last.sequence);
}

// Each setting is read back as it was set.
TEST(PageSettings, ChangeAndShowEveryValue) {
  const Scene scene = loaded_scene("effect_friction.glb");
  const RunSetup setup = made_setup(planar_settings());
  LiveSettings live(scene, setup);
  MaterialTuner tuner(scene);
  PageSettings page(scene, live, tuner, true, true);
  std::size_t materials = 0;
  for (const auto& setting : page.list()) {
    const std::string name = setting["name"];
    const std::string kind = setting["kind"];
    SCOPED_TRACE(name);
    EXPECT_EQ(page.values()[name], setting["value"]);
    materials += name.rfind("material/", 0) == 0 ? 1 : 0;
    if (kind == "flag") {
      ASSERT_FALSE(page.set(name, false));
      EXPECT_EQ(page.values()[name], false);
    } else if (kind == "axes") {
      ASSERT_FALSE(page.set(name, std::vector<std::array<double, 3>>{{0, -2, 0}}));
      EXPECT_EQ(page.values()[name].dump(), "[[0.0,-1.0,0.0]]");
    } else if (kind == "choice") {
      for (const std::string choice : setting["choices"]) {
        ASSERT_FALSE(page.set(name, choice));
        EXPECT_EQ(page.values()[name], choice);
      }
      EXPECT_TRUE(page.set(name, std::string("other")));
    } else {
      const double low = setting["low"];
      const double high = setting["high"];
      const double now = setting["value"];
      EXPECT_LE(low, now);
      EXPECT_LE(now, high);
      ASSERT_FALSE(page.set(name, now));
      EXPECT_TRUE(page.set(name, std::nextafter(high, INFINITY)));
      EXPECT_TRUE(page.set(name, low - 1.0));
      EXPECT_TRUE(page.set(name, std::nan("")));
      EXPECT_EQ(page.values()[name], now);
    }
    EXPECT_TRUE(kind == "flag" || page.set(name, true));
  }
  EXPECT_GE(materials, 2u);  // two coefficients of friction
  EXPECT_TRUE(page.set("gravity", 1.0));
}

// A4 and the force belong to a strategy; everything else can be changed.
TEST(PageSettings, OfAStrategyAreRefusedByItsName) {
  for (const std::string strategy : {"a4-anticipate", "a4-passive:10", "anisotropic:4", "cd"}) {
    const Scene& scene = star();
    RunSettings settings = planar_settings();
    settings.strategy = *parse_strategy(strategy);
    LiveSettings live(scene, made_setup(settings));
    MaterialTuner tuner(scene);
    PageSettings page(scene, live, tuner, true, true);
    const auto before = page.values();
    for (const auto& [name, error] : {std::pair("a4", page.set("a4", false)),
                                      {"force", page.set("force", std::string("none"))}}) {
      ASSERT_TRUE(error) << strategy << " " << name;
      EXPECT_EQ(error->element, name);
      EXPECT_NE(error->problem.find("belongs to the strategy " + strategy), std::string::npos);
    }
    EXPECT_EQ(page.values(), before);
    EXPECT_FALSE(page.set("stiffness", 321.0));
    EXPECT_FALSE(page.set("axes", std::vector<std::array<double, 3>>{{0, 1, 0}}));
  }
}

TEST(PageSettings, MaterialReachesTheHapticThread) {
  const Scene scene = loaded_scene("effect_friction.glb");
  LiveSettings live(scene, made_setup(planar_settings()));
  MaterialTuner tuner(scene);
  PageSettings page(scene, live, tuner, true, true);
  std::string name;
  for (const auto& setting : page.list()) {
    const std::string candidate = setting["name"];
    if (candidate.find("/dynamicFriction") != std::string::npos) name = candidate;
  }
  ASSERT_FALSE(name.empty());
  auto loop = test::made(
      HapticLoop::create(scene.world(), *ActuationModel::from_counts(2, 1), HapticSettings()));
  const auto use = [&] { tuner.before_tick(0.0, LoopChanges(loop)); };
  EXPECT_FALSE(tuner.is_pending());
  ASSERT_FALSE(page.set(name, 0.125));
  EXPECT_EQ(page.values()[name], 0.125);
  EXPECT_TRUE(tuner.is_pending());
  use();
  EXPECT_FALSE(tuner.is_pending());
}

// What a page is told is what the loop runs with.
TEST(PageSettings, ShowTheValuesOfTheLoop) {
  Rig rig(planar_settings());
  MaterialTuner tuner(star());
  PageSettings page(star(), rig.live, tuner, true, true);
  StatePublisher publisher(rig.loop, nullptr, 0);
  rig.run(1);
  publisher.on_tick(rig.records.all.back());
  ASSERT_FALSE(rig.live.set(kA4, 0.0));
  ASSERT_FALSE(rig.live.set(kForce, static_cast<double>(ForceMode::kNone)));
  ASSERT_FALSE(rig.live.set(kStiffness, 321.0));
  ASSERT_FALSE(rig.live.set(kDamping, 2.5));
  ASSERT_FALSE(rig.live.set_axes({Vec3(0, 1, 0)}));
  EXPECT_TRUE(rig.live.is_pending());
  LoopValues before, after;
  ASSERT_TRUE(publisher.loop_values(before));
  rig.run(1);
  EXPECT_FALSE(rig.live.is_pending());
  publisher.on_tick(rig.records.all.back());
  ASSERT_TRUE(publisher.loop_values(after));
  EXPECT_EQ(page.values(before)["a4"], true);
  EXPECT_EQ(page.values(before)["force"], "actuated");
  EXPECT_EQ(before.axes[0], (std::array<double, 3>{1, 0, 0}));
  const auto values = page.values(after);
  EXPECT_EQ(values["a4"], false);
  EXPECT_EQ(values["force"], "none");
  EXPECT_EQ(values["stiffness"], 321.0);
  EXPECT_EQ(values["damping"], 2.5);
  EXPECT_EQ(after.axis_count, 1u);
  EXPECT_EQ(after.axes[0], (std::array<double, 3>{0, 1, 0}));
}

}  // namespace
}  // namespace palpate::test
