// A force that is seen: the simulated hand that a pointer leads, against the statics of a wall.

#include "engine/live/led_hand.h"

#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "engine/live/person_trial.h"
#include "engine/live/start_place.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/paper_plan.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

constexpr HandImpedance kGrip{0.1, 6.0, 300.0};  // kg, N s/m, N/m
// So small that a hand which rests is where spring and wall are in balance.
constexpr double kFriction_N = 1e-3;

// A plan with one object and a seen force.
ExperimentPlan seen_plan() {
  Json json = Json::parse(shipped_plan_text("paper-live-mouse", ""));
  json["objects"] = {{"O1", PALPATE_MODELS_DIR "/star.glb"}};
  json["haptic"] = {"NoH", "seen-UaH", "seen-H"};
  json["live"]["force"] = "seen";
  json["live"]["grip"] = {{"stiffness_N_per_m", 300}, {"damping_Ns_per_m", 6}, {"mass_kg", 0.1}};
  auto plan = parse_plan(json.dump(), "plan.json", "");
  EXPECT_TRUE(plan.ok()) << plan.error().to_string();
  return std::move(*plan);
}

// A hand on the object, tick by tick, in simulated time.
class Led {
 public:
  // turn_rad: of the scene about A3.
  Led(const ExperimentScene& scene, ForceMode force, double turn_rad, const Vec3& start_scene_m)
      : setup_(setup_of(scene, force, turn_rad)),
        start_m_(pose().point(start_scene_m)),
        pointer_(setup_.device, start_m_),
        hand_(pointer_, setup_, kGrip, start_m_),
        loop_(made(HapticLoop::create(scene.scene.world(), setup_.actuation, setup_.haptics))),
        session_(loop_, hand_.device(), {.observers = {}, .takes_motors = false}) {
    EXPECT_FALSE(session_.start());
  }

  const ScenePose& pose() const { return setup_.haptics.initial_pose; }
  const RunSetup& setup() const { return setup_; }
  const Vec3& start_m() const { return start_m_; }
  void aim(const Vec3& target_m, bool holds = true) {
    pointer_.point({holds, ++sequence_, {target_m.x(), target_m.y(), target_m.z()}});
  }
  const TickRecord& tick() {
    session_.tick(setup_.dt_s);
    EXPECT_TRUE(session_.latest(record_));
    return record_;
  }
  const TickRecord& ticks(double length_s) {
    const auto count = static_cast<int>(std::lround(length_s / setup_.dt_s));
    for (int i = 0; i < count; ++i) tick();
    return record_;
  }

 private:
  static RunSetup setup_of(const ExperimentScene& scene, ForceMode force, double turn_rad) {
    RunSetup setup = turned_setup(scene.setup, turn_rad * 180.0 / std::numbers::pi);
    setup.haptics.force = force;
    setup.device.encoder_quantum_m = 0.0;
    setup.device.coulomb_friction_N = kFriction_N;
    return setup;
  }

  RunSetup setup_;
  Vec3 start_m_;
  PointedDevice pointer_;
  LedHand hand_;
  HapticLoop loop_;
  HapticSession session_;
  TickRecord record_;
  std::uint64_t sequence_ = 0;
};

class SeenForce : public ::testing::Test {
 protected:
  SeenForce() : plan_(seen_plan()) {
    auto scenes = load_experiment_scenes(plan_, {find_trial_way, run_trial});
    EXPECT_TRUE(scenes.ok()) << scenes.error().to_string();
    scenes_ = std::move(*scenes);
  }
  const ExperimentScene& scene() const { return scenes_.front(); }
  Vec3 start_m() const {
    return *start_place_m(scene().scene, scene().way, plan_.trial.sphere_radius_m);
  }

  ExperimentPlan plan_;
  std::vector<ExperimentScene> scenes_;
};

// The pointer rests at the depth a behind a flat wall with the normal n. With the stiffness k of
// the grip and K of the wall, the frame rests at the depth a k / (k + K m), where m is 1 in H, the
// squared component of n along the motor's axis in UaH, and 0 in NoH. Friction holds it within
// kFriction_N / (k + K m) of that.
TEST_F(SeenForce, YieldsByTheStiffnessOfTheGripAgainstThatOfTheWall) {
  const double wall_N_per_m = plan_.device.haptics.coupling.stiffness_N_per_m;
  constexpr double kAim_m = 4e-3;
  for (const double turn_rad : {0.0, 0.4, 1.0, 1.5, 2.6}) {
    for (const ForceMode force : {ForceMode::kNone, ForceMode::kActuated, ForceMode::kFull}) {
      SCOPED_TRACE(testing::Message() << "turn " << turn_rad << ", force " << int(force));
      Led led(scene(), force, turn_rad, start_m());
      const Vec3 green_m = led.pose().point(scene().way.green_m);
      const Vec3 normal = (led.start_m() - green_m).normalized();
      led.aim(green_m - kAim_m * normal);
      const TickRecord& record = led.ticks(3.0);
      ASSERT_EQ(record.contact, 1);
      const double share = force == ForceMode::kNone       ? 0.0
                           : force == ForceMode::kActuated ? normal.x() * normal.x()
                                                           : 1.0;
      const double sum_N_per_m = kGrip.stiffness_N_per_m + wall_N_per_m * share;
      const double depth_m = normal.dot(green_m - vec3(record.device_m));
      EXPECT_NEAR(depth_m, kAim_m * kGrip.stiffness_N_per_m / sum_N_per_m,
                  kFriction_N / sum_N_per_m);
      const Vec3 proxy_m = led.pose().point(vec3(record.proxy_scene_m));
      EXPECT_NEAR(normal.dot(proxy_m - vec3(record.device_m)), depth_m, kFriction_N / sum_N_per_m);
    }
  }
}

// A pointer that moves steadily is ahead of the frame by ((c + b) v + f) / k, for the dampings of
// grip and device and the friction f. The frame is sampled once a tick, and the target moves once.
TEST_F(SeenForce, WithoutForceFollowsThePointerWithTheLagOfTheGrip) {
  Led led(scene(), ForceMode::kNone, 0.0, start_m());
  const Vec3 away = (led.start_m() - led.pose().point(scene().way.green_m)).normalized();
  constexpr double kSpeed_m_per_s = 0.05;
  const double step_m = kSpeed_m_per_s * led.setup().dt_s;
  double gone_m = 0.0;
  for (int i = 0; i < 2000; ++i) {
    gone_m += step_m;
    led.aim(led.start_m() + gone_m * away);
    led.tick();
  }
  const double frame_m = away.dot(vec3(led.tick().device_m) - led.start_m());
  const double damping_Ns_per_m = kGrip.damping_Ns_per_m + led.setup().device.damping_Ns_per_m;
  EXPECT_NEAR(gone_m - frame_m,
              (damping_Ns_per_m * kSpeed_m_per_s + kFriction_N) / kGrip.stiffness_N_per_m,
              2.0 * step_m);
}

TEST_F(SeenForce, DrawsTheHandToTheLastPlaceOfAPenThatIsLifted) {
  Led led(scene(), ForceMode::kFull, 0.0, start_m());
  const Vec3 aside_m = led.start_m() + Vec3(0.0, 0.01, 0.0);
  led.aim(aside_m);
  led.tick();
  led.aim(aside_m, false);
  const double rest_m = kFriction_N / kGrip.stiffness_N_per_m;
  EXPECT_LE((vec3(led.ticks(3.0).device_m) - aside_m).norm(), rest_m);
}

// The aims of a hand that wanders about the wall.
std::vector<Vec3> wandering(const ScenePose& pose, const Vec3& green_m) {
  Random random(20);
  std::vector<Vec3> aims_m;
  for (int i = 0; i < 400; ++i) aims_m.push_back(pose.point(green_m) + random.in_box(0.006));
  return aims_m;
}

TEST_F(SeenForce, IsTheSameToTheBitForTheSamePointer) {
  const auto run = [&] {
    Led led(scene(), ForceMode::kActuated, 0.3, start_m());
    std::vector<double> numbers;
    for (const Vec3& aim_m : wandering(led.pose(), scene().way.green_m)) {
      led.aim(aim_m);
      const TickRecord& record = led.ticks(5e-3);
      for (const double* const vector :
           {record.device_m, record.proxy_scene_m, record.force_device_N}) {
        numbers.insert(numbers.end(), vector, vector + 3);
      }
    }
    return numbers;
  };
  const std::vector<double> first = run(), second = run();
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)), 0);
}

// The levels of a trial have the force that their names say.
TEST(SeenLevels, HaveTheForceOfTheFeltOnes) {
  const std::vector<std::pair<const char*, ForceMode>> expected = {
      {"NoH", ForceMode::kNone},
      {"UaH", ForceMode::kActuated},
      {"H", ForceMode::kFull},
      {"seen-UaH", ForceMode::kActuated},
      {"seen-H", ForceMode::kFull}};
  ASSERT_EQ(expected.size(), kHapticLevels.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(kHapticLevels[i].name, expected[i].first);
    EXPECT_EQ(force_of(kHapticLevels[i].value), expected[i].second);
    EXPECT_EQ(is_seen_only(kHapticLevels[i].value), i >= 3);
  }
}

TEST_F(SeenForce, RefusesAGripWhoseMotionCannotBeComputed) {
  PersonTrialSettings settings;
  settings.grip = HandImpedance{0.0, 1e4, 300.0};
  const auto trial = PersonTrial::create(scene(), start_m(), settings, nullptr);
  ASSERT_FALSE(trial.ok());
  EXPECT_NE(trial.error().problem.find("unstable"), std::string::npos);
}

}  // namespace
}  // namespace palpate::test
