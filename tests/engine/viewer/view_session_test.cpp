// A viewed session: the haptic thread, what it publishes, and what a page can do to it.

#include "engine/viewer/view_session.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/viewer/tick_statistics.h"
#include "haptics/record_vectors.h"

namespace palpate::test {
namespace {

constexpr auto kLongest = std::chrono::seconds(60);  // a test that waits longer fails

Scene loaded(const std::string& model) {
  auto scene = Scene::load(PALPATE_MODELS_DIR "/" + model);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return std::move(*scene);
}

RunSetup setup_of(int sensors, int actuators, const std::vector<SteadyMotion>& moves = {}) {
  RunSettings settings;
  settings.sensors = sensors;
  settings.actuators = actuators;
  settings.moves = moves;
  return *make_setup(settings);
}

ViewSettings named(const std::string& name) {
  ViewSettings settings;
  settings.scene_name = name;
  return settings;
}

struct Viewed {
  explicit Viewed(const Scene& scene, const RunSetup& setup)
      : session(std::move(*ViewSession::create(scene, setup, named("a scene")))) {
    EXPECT_FALSE(session->start());
  }

  ViewState newest() {
    ViewState state;
    std::vector<BodyPose> bodies;
    const auto end = std::chrono::steady_clock::now() + kLongest;
    while (!session->newest(state, bodies) && std::chrono::steady_clock::now() < end) {
      std::this_thread::yield();
    }
    poses = bodies;
    return state;
  }
  // The first state that fulfils the condition. Repeats the pointer like a page.
  template <typename Condition>
  ViewState wait_for(const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + kLongest;
    ViewState state;
    do {
      if (pointer.holds) {
        ++pointer.sequence;
        session->point(pointer);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      state = newest();
    } while (!condition(state) && std::chrono::steady_clock::now() < end);
    EXPECT_TRUE(condition(state));
    return state;
  }
  std::string carry_out(PageRequest::Kind kind, const SettingValue& value = false,
                        const std::string& name = "") {
    PageRequest request;
    request.kind = kind;
    request.name = name;
    request.value = value;
    return session->carry_out(request).value_or("");
  }

  std::unique_ptr<ViewSession> session;
  std::vector<BodyPose> poses;
  PointerMessage pointer;
};

// A person who holds the tip of a device at one place.
class HeldTip final : public GuardableDevice {
 public:
  HeldTip() {
    description_.name = "a device of a test";
    description_.sensed_axes = 3;
    description_.motor_count = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      description_.motors[k].direction_device = {};
      description_.motors[k].direction_device[k] = 1.0;
      description_.motors[k].peak_force_N = description_.motors[k].continuous_force_N = 3.0;
    }
    description_.workspace_low_m.fill(-2.0);
    description_.workspace_high_m.fill(2.0);
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double) noexcept override {
    DeviceSample sample;
    sample.position_m = {0.0, 0.0, height_m.load()};
    sample.sequence = ++sequence_;
    return sample;
  }
  void command(const DeviceCommand& command) noexcept override {
    for (const double force_N : command.force_N) {
      if (force_N != 0.0) has_pushed = true;
    }
  }
  int descriptor() const noexcept override { return -1; }
  std::vector<std::uint8_t> zero_bytes() const override { return {}; }
  void set_guard(WriteGuard*) noexcept override {}
  std::string summary() const override { return {}; }

  std::atomic<double> height_m{0.0};
  std::atomic<bool> has_pushed{false};

 private:
  DeviceDescription description_;
  std::uint64_t sequence_ = 0;
};

// The status of a session whose device begins in the middle of the sphere: `inside` once it is
// known.
struct HeldInside {
  HeldInside() : scene(loaded("sphere.glb")) {
    ViewSettings settings = named("a sphere");
    settings.has_guard = false;
    settings.without_realtime = true;
    session = std::move(*ViewSession::create(scene, setup_of(3, 3), settings, &tip));
    EXPECT_FALSE(session->start());
  }
  nlohmann::json inside() const {
    return nlohmann::json::parse(session->status(kMainPage, 1))["inside"];
  }
  bool wait_for_inside(bool is_inside) const {
    const auto end = std::chrono::steady_clock::now() + kLongest;
    while (inside().is_null() == is_inside && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return inside().is_null() != is_inside;
  }
  std::optional<std::string> stay() const {
    PageRequest request;
    request.kind = PageRequest::Kind::kStay;
    return session->carry_out(request);
  }

  Scene scene;
  HeldTip tip;
  std::unique_ptr<ViewSession> session;
};

TEST(ViewSession, NamesTheNodeInsideWhichAPersonBeginsUntilThePersonHasLeft) {
  HeldInside held;
  ASSERT_TRUE(held.wait_for_inside(true));
  EXPECT_EQ(held.inside(), held.scene.objects().front().name);
  held.tip.height_m = 1.5;  // the sphere has a radius of 1 m
  EXPECT_TRUE(held.wait_for_inside(false));
  EXPECT_FALSE(held.tip.has_pushed);
  EXPECT_TRUE(held.stay()) << "nobody is inside";
}

TEST(ViewSession, APersonWhoBeginsInsideCanStay) {
  HeldInside held;
  ASSERT_TRUE(held.wait_for_inside(true));
  EXPECT_EQ(held.stay(), std::nullopt);
  EXPECT_TRUE(held.wait_for_inside(false));
}

// Refuses a stiffness above 1000 N/m, and tells one above 500 N/m.
class TestJudge final : public WallJudge {
 public:
  Result<std::string> judge(const std::string& name, double value) override {
    if (name != "stiffness") return std::string();
    if (value > 1000.0) return invalid_argument(name, "is too much; expected at most 1000 N/m");
    return value > 500.0 ? std::string("calm only by the controller") : std::string();
  }
  void keep() override { ++kept; }

  int kept = 0;
};

TEST(ViewSession, RefusesAndTellsWhatTheJudgeOfTheWallsSays) {
  const Scene scene = loaded("sphere.glb");
  HeldTip tip;
  TestJudge judge;
  ViewSettings settings = named("a sphere");
  settings.has_guard = false;
  settings.without_realtime = true;
  settings.judge = &judge;
  const auto session = std::move(*ViewSession::create(scene, setup_of(3, 3), settings, &tip));
  ASSERT_FALSE(session->start());
  const auto set = [&](const std::string& name, const SettingValue& value) {
    PageRequest request;
    request.kind = PageRequest::Kind::kSet;
    request.name = name;
    request.value = value;
    return session->carry_out(request).value_or("");
  };
  const auto stiffness = [&] {
    return nlohmann::json::parse(session->status(kMainPage, 1))["settings"]["stiffness"]
        .get<double>();
  };
  EXPECT_EQ(set("stiffness", 400.0), "");
  EXPECT_EQ(judge.kept, 1);
  EXPECT_FALSE(session->take_event());
  EXPECT_EQ(set("stiffness", 1500.0), "stiffness: is too much; expected at most 1000 N/m");
  EXPECT_EQ(judge.kept, 1);
  EXPECT_EQ(set("stiffness", 600.0), "");
  const auto event = session->take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, "stiffness");
  EXPECT_EQ(event->text, "calm only by the controller");
  EXPECT_FALSE(session->take_event());
  // What the page refuses is not kept, and what is no number is not judged.
  EXPECT_NE(set("stiffness", -1.0), "");
  EXPECT_EQ(judge.kept, 2);
  EXPECT_EQ(set("a4", false), "");
  EXPECT_EQ(judge.kept, 2);
  EXPECT_EQ(stiffness(), 600.0);
}

TEST(ViewSession, RestsInFrontOfTheSceneUntilAPointerComes) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  const ViewState state = viewed.wait_for([](const ViewState& s) { return s.record.tick > 100; });
  EXPECT_EQ(state.record.contact, 0);
  EXPECT_EQ(state.flags, 0u);
  EXPECT_EQ(state.pointer, 0u);
  EXPECT_LT(state.record.device_m[0], scene.statistics().bounds_scene.low.x());
}

// A wall stops the ball and not the pointer.
TEST(ViewSession, PointerPressesTheHandAgainstAWall) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 2));
  const ViewState start = viewed.newest();
  viewed.pointer.holds = true;
  viewed.pointer.target_m = {0.0, start.record.device_m[1], 0.0};
  const ViewState pressed = viewed.wait_for([](const ViewState& s) {
    return s.record.contact != 0 && vec3(s.record.force_device_N).norm() > 0.5;
  });
  EXPECT_EQ(pressed.target_m[0], 0.0);
  EXPECT_EQ(pressed.flags, kHandHasTarget | kHandIsHeld);
  EXPECT_GT(pressed.pointer, 0u);
  // The force pushes back along -A1, and the proxy is behind the device.
  EXPECT_LT(pressed.record.force_device_N[0], 0.0);
  EXPECT_GT((vec3(pressed.record.goal_scene_m) - vec3(pressed.record.proxy_scene_m)).norm(), 0.0);
  viewed.session->let_go();
  viewed.pointer.holds = false;
  viewed.wait_for([](const ViewState& s) { return s.record.contact == 0 && s.flags == 0; });
}

TEST(ViewSession, TargetStaysInTheWorkspace) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  viewed.pointer.holds = true;
  viewed.pointer.target_m = {-1e300, 5.0, 0.0};
  const ViewState state = viewed.wait_for([](const ViewState& s) { return s.pointer > 0; });
  EXPECT_EQ(state.target_m[0], -0.2);
  EXPECT_EQ(state.target_m[1], 0.2);
}

TEST(ViewSession, PausedSessionKeepsItsNewestRecord) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  viewed.wait_for([](const ViewState& s) { return s.record.tick > 10; });
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kPause, true), "");
  const std::uint64_t ticks = viewed.session->thread().ticks();
  ViewState paused;
  viewed.wait_for([&](const ViewState& s) {
    paused = s;
    return viewed.session->thread().ticks() > ticks + 50;
  });
  EXPECT_NE(paused.flags & kViewPaused, 0u);
  EXPECT_EQ(viewed.newest().record.tick, paused.record.tick);
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kPause, false), "");
  viewed.wait_for([&](const ViewState& s) { return s.record.tick > paused.record.tick; });
}

TEST(ViewSession, SettingsReachTheRecordAndTheStatus) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kSet, std::string("none"), "force"), "");
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kSet, 250.0, "stiffness"), "");
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kSet, -1.0, "stiffness"),
            "stiffness: is -1; expected a number from 0 to 5000 N/m");
  EXPECT_EQ(viewed.carry_out(PageRequest::Kind::kSet, 1.0, "no such"), "no such: is not a setting");
  const auto status = nlohmann::json::parse(viewed.session->status(kMainPage, 3));
  EXPECT_EQ(status["clients"], 3);
  EXPECT_EQ(status["settings"]["force"], "none");
  EXPECT_EQ(status["settings"]["stiffness"], 250.0);
  viewed.pointer.holds = true;
  viewed.pointer.target_m = {0.0, viewed.newest().record.device_m[1], 0.0};
  const ViewState state = viewed.wait_for([](const ViewState& s) { return s.record.contact != 0; });
  EXPECT_EQ(vec3(state.record.force_device_N), Vec3(Vec3::Zero()));
  EXPECT_NE(vec3(state.record.full_force_device_N), Vec3(Vec3::Zero()));
  EXPECT_EQ(state.record.body, 0);
  EXPECT_EQ(state.body_name, scene.objects()[0].name);
  EXPECT_EQ(state.material_name, scene.material_name(state.record.material));
}

TEST(ViewSession, HelloDescribesSceneAndDevice) {
  const Scene scene = loaded("gallery.glb");
  Viewed viewed(scene, setup_of(3, 2));
  const auto hello = nlohmann::json::parse(viewed.session->hello(kMainPage));
  EXPECT_EQ(hello["type"], "hello");
  EXPECT_EQ(hello["version"], 4);
  EXPECT_EQ(hello["display"], nlohmann::json({{"name", "full"}}));
  EXPECT_EQ(hello["scene"]["name"], "a scene");
  std::vector<Vec3> corners_m;
  std::vector<Triangle> triangles;
  scene.append_triangles_scene(corners_m, triangles);
  EXPECT_EQ(hello["scene"]["triangles"], triangles.size());
  EXPECT_EQ(hello["scene"]["simplified"], false);
  EXPECT_EQ(hello["device"]["sensors"], 3);
  EXPECT_EQ(hello["plane_height_m"], nullptr);
  for (const auto& setting : hello["settings"]) {
    if (setting["name"] == "axes") {
      EXPECT_EQ(setting["value"].dump(), "[[1.0,0.0,0.0],[0.0,1.0,0.0]]");
    }
  }
}

TEST(ViewSession, HelloDescribesThePapersDisplay) {
  const Scene scene = loaded("star.glb");
  ViewSettings settings = named("a star");
  settings.paper = PaperDisplay{60.0, 0.5, {}};
  auto display_of = [&] {
    const auto session = ViewSession::create(scene, setup_of(2, 1), settings);
    return nlohmann::json::parse((*session)->hello(kMainPage))["display"];
  };
  EXPECT_EQ(display_of(),
            nlohmann::json::parse(R"({"name":"paper","Hz":60.0,"scale":0.5,"spheres":null})"));
  settings.paper->spheres = DisplayedSpheres{Vec3(1, 2, 3), Vec3(4, 5, 6), 0.25};
  EXPECT_EQ(
      display_of()["spheres"],
      nlohmann::json::parse(R"({"green_m":[1.0,2.0,3.0],"red_m":[4.0,5.0,6.0],"radius_m":0.25})"));
}

// The published poses of a body that moves at a constant velocity, in the same tick as the record.
TEST(ViewSession, PublishesMovingBodiesBesideTheRecord) {
  const Scene scene = loaded("gallery.glb");
  ASSERT_GT(scene.objects().size(), 1u);
  const SceneObject& object = scene.objects()[1];
  SteadyMotion motion;
  motion.node = object.name;
  motion.velocity_m_per_s = Vec3(0.0, 0.0, 0.01);
  Viewed viewed(scene, setup_of(3, 3, {motion}));
  for (int i = 0; i < 50; ++i) {
    const ViewState state = viewed.wait_for(
        [&](const ViewState& s) { return s.record.tick > 5 && !viewed.poses.empty(); });
    ASSERT_EQ(viewed.poses.size(), 1u);
    EXPECT_EQ(viewed.poses[0].body, 1u);
    // The tick n moves the body to its place at the sum of the n time steps before it.
    const double expected_m = object.T_scene_body.translation_m.z() + 0.01 * state.record.time_s;
    EXPECT_NEAR(viewed.poses[0].o_m[2], expected_m, 1e-5 * 0.5)  // half of the way of one tick
        << "tick " << state.record.tick;
  }
}

TEST(ViewSession, TicksArriveInOrderWithoutLoss) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  std::vector<TickSummary> rows;
  std::uint64_t lost = 0;
  viewed.wait_for([&](const ViewState&) {
    lost += viewed.session->take_ticks(rows);
    return rows.size() > 200;
  });
  viewed.session->stop();
  lost += viewed.session->take_ticks(rows);
  EXPECT_EQ(rows.size() + lost, viewed.session->thread().ticks());
  for (std::size_t i = 1; i < rows.size(); ++i) ASSERT_GT(rows[i].time_s, rows[i - 1].time_s);
}

TEST(ViewSession, SmallSceneIsShownWhole) {
  const Scene scene = loaded("star.glb");
  Viewed viewed(scene, setup_of(2, 1));
  EXPECT_EQ(viewed.session->scene_bytes(true), viewed.session->scene_bytes(false));
}

TEST(TickRing, CountsOverwrittenRowsAsLost) {
  TickRing<TickSummary, 8> ring;
  std::vector<double> times;
  const auto add = [&](int first, int last) {
    for (int n = first; n <= last; ++n) {
      TickSummary row;
      row.time_s = n;
      ring.add(row);
    }
  };
  const auto take = [&](const TickSummary& row) { times.push_back(row.time_s); };
  EXPECT_EQ(ring.read(take), 0u);
  add(1, 3);
  EXPECT_EQ(ring.read(take), 0u);
  EXPECT_EQ(times, (std::vector<double>{1, 2, 3}));
  times.clear();
  add(4, 23);
  EXPECT_EQ(ring.read(take), 12u);
  EXPECT_EQ(times, (std::vector<double>{16, 17, 18, 19, 20, 21, 22, 23}));
}

// A reader beside the writer sees each row at most once, in order, whole, and misses none silently.
TEST(TickRing, RowsAreWholeBesideAFastWriter) {
  constexpr std::uint64_t kRows = 200'000;
  TickRing<std::array<std::uint64_t, 5>, 64> ring;
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kRows; ++n) ring.add({n, 2 * n, 3 * n, 4 * n, 5 * n});
  });
  std::uint64_t seen = 0, lost = 0, last = 0;
  const auto take = [&](const std::array<std::uint64_t, 5>& row) {
    for (std::uint64_t k = 0; k < row.size(); ++k) ASSERT_EQ(row[k], (k + 1) * row[0]);
    ASSERT_GT(row[0], last);
    last = row[0];
    ++seen;
  };
  while (seen + lost < kRows) lost += ring.read(take);
  writer.join();
  EXPECT_EQ(seen + lost, kRows);
}

TEST(TickStatistics, PercentilesAndFaultsAreThoseOfTheRows) {
  TickStatistics statistics;
  EXPECT_EQ(statistics.late_us(0.5), std::nullopt);
  std::vector<TickSummary> rows(1000);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].late_us = static_cast<float>((i * 7) % 1000 + 1);  // 1 to 1000 in another order
    rows[i].step_us = 2.0f;
    rows[i].faults = i % 10 == 0 ? (1u << 3 | 1u << 20) : 0u;
  }
  statistics.add(rows);
  EXPECT_EQ(statistics.late_us(0.999), 999.0);
  EXPECT_EQ(statistics.late_us(0.5), 500.0);
  EXPECT_EQ(statistics.late_us(1.0), 1000.0);
  EXPECT_EQ(statistics.step_us(0.5), 2.0);
  const auto faults = statistics.take_faults();
  EXPECT_EQ(faults[3], 100u);
  EXPECT_EQ(faults[20], 100u);
  EXPECT_EQ(faults[0], 0u);
  EXPECT_EQ(statistics.take_faults()[3], 0u);
  for (TickSummary& row : rows) row.late_us = 5.0f;
  for (std::size_t i = 0; i < TickStatistics::kTicks; i += rows.size()) statistics.add(rows);
  EXPECT_EQ(statistics.late_us(1.0), 5.0);  // older ticks are forgotten
}

}  // namespace
}  // namespace palpate::test
