// `experiment live` with a board in the hand: a simulated board behind a pseudo-terminal, and a
// page without a network. The board's log is the judge.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "engine/drivers/drivers.h"
#include "engine/live/live_run.h"
#include "engine/live/start_place.h"
#include "engine/live/stroke.h"
#include "engine/session/closed_surfaces.h"
#include "engine/simulation/board_terminal.h"
#include "engine/trials/paper_plan.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/needs.h"

namespace palpate::test {
namespace {

using Json = nlohmann::ordered_json;

// The origin of the device frame, the middle of the workspace, in the frame of the linkage.
const Vec2 kMiddle_m(0.01, 0.0546);

bool wait_until(const std::function<bool()>& is_true) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    if (is_true()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

bool is_zero(const BoardCommand& command) {
  return std::abs(command.torques[0]) < 0x1p-119f && std::abs(command.torques[1]) < 0x1p-119f;
}

// Two conditions with one object, small enough for the board.
std::string plan_text(double scale) {
  Json plan = Json::parse(shipped_plan_text("paper-live", ""));
  plan["objects"] = {{"O1", PALPATE_MODELS_DIR "/star.glb"}};
  plan["haptic"] = {"UaH", "H"};
  plan["rotation"] = {"NoR"};
  plan["scale"] = {scale};
  plan["sphere_radius_m"] = 0.002;
  plan["device"]["stiffness_N_per_m"] = 300;
  plan["live"]["about"] = Json::array();
  plan["live"]["longest_picture_s"] = 10;
  plan["live"]["longest_lateness_s"] = 10;
  plan["live"].erase("about");
  return plan.dump();
}

// The page of the participant, on the thread of the test.
class Page {
 public:
  explicit Page(LivePages& pages) : pages_(pages) {}

  void say(const Json& message) {
    const auto answer = pages_.take_message(kParticipantPage, true, message.dump());
    ASSERT_TRUE(answer);
    ASSERT_EQ(*answer, "") << message;
  }
  // The next text of this type; every trial is answered. No value: none came. again: is called
  // meanwhile.
  std::optional<Json> next(
      const std::string& type, const std::function<void()>& again = [] {}) {
    std::optional<Json> found;
    wait_until([&] {
      again();
      while (const auto text = pages_.take_text()) {
        const Json json = take(*text);
        if (text->role != kParticipantPage || json["type"] != type) continue;
        found = json;
        return true;
      }
      return false;
    });
    return found;
  }
  // Takes the texts that wait.
  void read() {
    while (const auto text = pages_.take_text()) take(*text);
  }
  // Where the hand should go; null: nowhere.
  const Json& ring() const { return ring_; }
  // Through the steps before the first trial.
  void begin() {
    say({{"type", "next"}, {"step", "information"}});
    say({{"type", "consent"}, {"value", true}});
    say({{"type", "checked"},
         {"input", "board"},
         {"motion", "unknown"},
         {"css_px_per_mm", 3.78},
         {"device_pixel_ratio", 1},
         {"width_px", 1920},
         {"height_px", 1080},
         {"refresh_Hz", 60},
         {"unadjusted", nullptr},
         {"stroke_ratio", nullptr}});
    say({{"type", "next"}, {"step", "instructions"}});
  }

 private:
  Json take(const ViewModel::PageText& text) {
    Json json = Json::parse(text.text);
    if (text.role != kParticipantPage) return json;
    if (json["type"] == "ring") ring_ = json["p_scene_m"];
    if (json["type"] == "trial") say({{"type", "ready"}, {"trial", json["number"]}});
    return json;
  }

  LivePages& pages_;
  Json ring_;
};

class LiveOnBoard : public ::testing::Test {
 protected:
  void SetUp() override {
    PALPATE_NEEDS(lack_of_terminals());
    auto opened = BoardTerminal::open({});
    ASSERT_TRUE(opened) << opened.error().to_string();
    board_ = std::move(*opened);
    auto device = make_device(
        "--device", "hapi:port=" + board_->path() + ",torque-per-Nm=1,peak-torque=0.1", false);
    ASSERT_TRUE(device) << device.error().to_string();
    device_ = std::move(*device);
  }
  void TearDown() override {
    end();
    EXPECT_FALSE(error_) << error_->to_string();
  }

  Result<ExperimentPlan> plan(double scale) const {
    auto plan = parse_plan(plan_text(scale), "plan.json", "");
    if (!plan) return plan;
    plan->device.device = device_->description();
    plan->device.device.workspace_low_m[2] = -1.0;
    plan->device.device.workspace_high_m[2] = 1.0;
    return plan;
  }
  void start(double scale) {
    auto made = plan(scale);
    ASSERT_TRUE(made) << made.error().to_string();
    LiveRunSettings settings;
    settings.folder = folder_.path("out");
    settings.board = device_.get();
    settings.without_realtime = true;
    pose_ = make_setup(made->device)->haptics.initial_pose;
    auto run = LiveRun::open(plan_for_person(*made), settings);
    ASSERT_TRUE(run) << run.error().to_string();
    run_ = std::move(*run);
    thread_ = std::thread([this] { error_ = run_->run(stop_); });
  }
  // A hand that goes where the ring is.
  void follow_ring(const Page& page) {
    if (!page.ring().is_array()) return;
    const Vec3 ring_m = pose_.point(Vec3(page.ring()[0], page.ring()[1], page.ring()[2]));
    board_->set_hand(kMiddle_m + Vec2(ring_m.x(), ring_m.y()));
  }
  void end() {
    stop_.request();
    if (thread_.joinable()) thread_.join();
  }
  // Whether the answer to this request has come; it is then in answer_.
  bool answer_to(int id, PageRole role) {
    while (const auto text = run_->pages().take_text()) {
      const Json json = Json::parse(text->text);
      if (text->role != role || json["type"] != "answer" || json["id"] != id) continue;
      answer_ = json;
      return true;
    }
    return false;
  }
  bool has_force() const {
    const auto log = board_->log();
    return std::any_of(log.begin(), log.end(), [](const BoardCommand& c) { return !is_zero(c); });
  }

  TemporaryFolder folder_;
  Json answer_;
  std::unique_ptr<BoardTerminal> board_;
  std::unique_ptr<GuardableDevice> device_;
  std::unique_ptr<LiveRun> run_;
  ScenePose pose_;
  StopFlag stop_;
  std::optional<Error> error_;
  std::thread thread_;
};

TEST_F(LiveOnBoard, AWorkspaceThatIsTooSmallIsRefusedWithTheScaleThatFits) {
  auto large = plan(0.25);
  ASSERT_TRUE(large) << large.error().to_string();
  LiveRunSettings settings;
  settings.folder = folder_.path("out");
  settings.board = device_.get();
  const auto refused = LiveRun::open(plan_for_person(*large), settings);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().element, "/scale") << refused.error().to_string();
  EXPECT_NE(refused.error().problem.find("expected about 0."), std::string::npos)
      << refused.error().to_string();
}

TEST_F(LiveOnBoard, PauseAbortAndStopEndTheForce) {
  start(0.15);
  Page page(run_->pages());
  page.begin();
  for (int condition = 0; condition < 2; ++condition) {  // learning
    ASSERT_TRUE(page.next("trial_end", [&] {
      follow_ring(page);
      page.say({{"type", "next"}, {"step", "learning"}});
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }));
  }
  for (const std::string end : {"pause", "left", "stop"}) {
    const auto trial = page.next("trial");
    ASSERT_TRUE(trial);
    ASSERT_TRUE(wait_until([&] {
      page.read();
      follow_ring(page);
      const Json status = Json::parse(run_->pages().status(kExperimenterPage, 1));
      return status.value("runs", false);
    }));
    const std::uint64_t before = board_->commands();
    ASSERT_TRUE(wait_until([&] { return board_->commands() > before + 300; }));
    // From the start through the green sphere into the wall.
    Vec3 into = Vec3::Zero();
    for (int k = 0; k < 3; ++k) into[k] = (*trial)["green_m"][k];
    into = pose_.point(into);
    for (int k = 0; k < 2; ++k) into[k] -= static_cast<double>((*trial)["start_device_m"][k]);
    board_->set_hand(board_->log().back().tip_m + 6.0 * Vec2(into.x(), into.y()));
    ASSERT_TRUE(wait_until([&] { return !is_zero(board_->log().back()); })) << end;
    const std::int64_t asked_ns = BoardTerminal::now_ns();
    if (end == "left") {
      page.say({{"type", "left"}, {"why", "focus"}});
    } else if (end == "stop") {
      page.say({{"type", "stop"}, {"keep", true}});
    } else {
      page.say({{"type", "pause"}});
    }
    if (end != "stop") {
      ASSERT_TRUE(page.next("trial_end")) << end;
    }
    ASSERT_TRUE(wait_until([&] { return is_zero(board_->log().back()); }));
    const auto log = board_->log();
    const auto last =
        std::find_if(log.rbegin(), log.rend(), [](const BoardCommand& c) { return !is_zero(c); });
    if (last != log.rend() && last->time_ns > asked_ns) {
      std::cout << end << ": the last force came "
                << 1e-6 * static_cast<double>(last->time_ns - asked_ns)
                << " ms after the request\n";
    }
    if (end == "pause") page.say({{"type", "go_on"}});
  }
  if (thread_.joinable()) thread_.join();
  EXPECT_EQ(run_->course().step(), CourseStep::kStopped);
}

TEST_F(LiveOnBoard, AfterATripTheCourseWaitsForTheExperimenter) {
  start(0.15);
  Page page(run_->pages());
  page.begin();
  const auto status = [&] {
    page.read();
    return Json::parse(run_->pages().status(kExperimenterPage, 1));
  };
  bool has_seen_ring = false;
  ASSERT_TRUE(wait_until([&] {  // the hand is led to the start of a condition
    page.read();
    follow_ring(page);
    has_seen_ring = has_seen_ring || page.ring().is_array();
    return has_seen_ring && page.ring().is_null();
  }));
  const std::uint64_t before = board_->commands();
  ASSERT_TRUE(wait_until([&] { return board_->commands() > before + 300; }));
  constexpr std::int64_t kSilence_ns = 300'000'000;  // longer than the governor waits
  BoardFault silence;
  silence.from_ns = BoardTerminal::now_ns();
  silence.until_ns = silence.from_ns + kSilence_ns;
  board_->add_fault(silence);
  ASSERT_TRUE(wait_until([&] { return status()["trip"].is_string(); })) << status();
  EXPECT_TRUE(wait_until([&] { return status()["step"] == "paused"; }));
  for (const PageRole role : {kParticipantPage, kExperimenterPage}) {
    run_->pages().take_message(role, true, R"({"type":"go_on","id":7})");
    EXPECT_TRUE(wait_until([&] { return answer_to(7, role); }));
    EXPECT_NE(answer_.value("problem", "").find("rearm"), std::string::npos) << answer_;
    EXPECT_EQ(status()["step"], "paused");
  }
  run_->pages().take_message(kExperimenterPage, false, R"({"type":"rearm","id":8})");
  EXPECT_TRUE(wait_until([&] { return answer_to(8, kExperimenterPage); }));
  EXPECT_EQ(answer_["ok"], true) << answer_;
  EXPECT_TRUE(wait_until([&] { return status()["trip"].is_null(); }));
  EXPECT_EQ(status()["step"], "paused") << "until somebody goes on";
  run_->pages().take_message(kParticipantPage, true, R"({"type":"go_on","id":9})");
  EXPECT_TRUE(wait_until([&] { return answer_to(9, kParticipantPage); }));
  EXPECT_EQ(answer_["ok"], true) << answer_;
  EXPECT_TRUE(wait_until([&] { return status()["step"] == "learning"; }));
}

// The hand goes on while the scene is placed at it and the session begins.
TEST_F(LiveOnBoard, AHandThatBeginsInsideIsFreeUntilItHasLeft) {
  const auto made = plan(0.15);
  ASSERT_TRUE(made) << made.error().to_string();
  const auto scenes = load_live_scenes(plan_for_person(*made), {find_trial_way, run_trial});
  ASSERT_TRUE(scenes) << scenes.error().to_string();
  const ExperimentScene& scene = scenes->front();
  const auto start_m = start_place_m(scene.scene, scene.way, made->trial.sphere_radius_m);
  ASSERT_TRUE(start_m) << start_m.error().to_string();
  const Vec3 inside_m(0.0, 0.0, start_m->z());  // the middle of the star
  ASSERT_TRUE(enclosing_object(scene.scene, inside_m));
  const ScenePose& pose = scene.setup.haptics.initial_pose;
  PersonTrialSettings settings;
  settings.force = ForceMode::kFull;
  settings.without_realtime = true;
  settings.longest_lateness_s = 10.0;
  settings.hand_m = pose.point(*start_m) - pose.point(inside_m);  // and it has gone on to (0, 0)
  const auto pull_to = [&](const Vec3& p_scene_m) {
    const Vec3 p_device_m = pose.point(p_scene_m) - pose.point(inside_m);
    board_->set_hand(kMiddle_m + Vec2(p_device_m.x(), p_device_m.y()));
  };
  KeptDevice kept(*device_);
  ASSERT_FALSE(kept.start()) << "the board counts from the pose in which it is opened";
  pull_to(inside_m);
  const auto person = PersonTrial::create(scene, *start_m, settings, &kept);
  ASSERT_TRUE(person) << person.error().to_string();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the hand takes the tip there
  const auto problem = (*person)->start();
  ASSERT_FALSE(problem) << problem->to_string();
  ASSERT_TRUE(wait_until([&] { return (*person)->waits_inside(); }));
  const std::uint64_t before = board_->commands();
  ASSERT_TRUE(wait_until([&] { return board_->commands() > before + 500; }));
  EXPECT_FALSE(has_force());
  EXPECT_TRUE((*person)->waits_inside());
  pull_to(*start_m);
  ASSERT_TRUE(wait_until([&] { return !(*person)->waits_inside(); }));
  EXPECT_FALSE(has_force());
  EXPECT_FALSE((*person)->clock().measures()[kTotalTime]) << "the clock has not started";
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  pull_to(scene.way.green_m + (scene.way.green_m - *start_m));
  EXPECT_TRUE(wait_until([&] { return has_force(); }));
  (*person)->stop();
}

TEST(Stroke, RegionIsWhereTheStrokeFits) {
  DeviceDescription device;
  device.workspace_low_m = {-0.1, -0.05, 0.0};
  device.workspace_high_m = {0.1, 0.05, 0.0};
  const Box stroke{Vec3(-0.02, -0.01, 0.0), Vec3(0.06, 0.03, 0.0)};
  const auto region = start_region(stroke, device);
  ASSERT_TRUE(region);
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 p((corner & 1) != 0 ? region->low.x() : region->high.x(),
                 (corner & 2) != 0 ? region->low.y() : region->high.y(), 0.0);
    EXPECT_GE(p.x() + stroke.low.x(), device.workspace_low_m[0] - 1e-15);
    EXPECT_LE(p.x() + stroke.high.x(), device.workspace_high_m[0] + 1e-15);
    EXPECT_GE(p.y() + stroke.low.y(), device.workspace_low_m[1] - 1e-15);
    EXPECT_LE(p.y() + stroke.high.y(), device.workspace_high_m[1] + 1e-15);
  }
  EXPECT_FALSE(start_region({Vec3(-0.1, 0, 0), Vec3(0.11, 0, 0)}, device));
  EXPECT_FALSE(check_stroke(stroke, device, {}, "O1", 1.0));
  const auto error = check_stroke({Vec3(-0.2, 0, 0), Vec3(0.2, 0, 0)}, device, {}, "O1", 0.5);
  ASSERT_TRUE(error);
  EXPECT_NE(error->problem.find("expected about 0.25"), std::string::npos) << error->problem;
}

}  // namespace
}  // namespace palpate::test
