// The grip of a hand that sees a force: refused with what fits, or calm at the wall.

#include "engine/cli/grip_check.h"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/live/led_hand.h"
#include "engine/live/live_run.h"
#include "engine/trials/paper_plan.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

struct Seen {
  Seen(double stiffness_N_per_m, double damping_Ns_per_m, double grip_stiffness_N_per_m = 300.0)
      : plan(plan_of(stiffness_N_per_m, damping_Ns_per_m, grip_stiffness_N_per_m)),
        scenes(made(load_live_scenes(plan, {find_trial_way, run_trial}))) {}

  static ExperimentPlan plan_of(double stiffness_N_per_m, double damping_Ns_per_m,
                                double grip_stiffness_N_per_m) {
    Json json = Json::parse(shipped_plan_text("paper-live-mouse", ""));
    json["objects"] = {{"O1", PALPATE_MODELS_DIR "/star.glb"}};
    json["haptic"] = {"seen-H"};
    json["device"]["stiffness_N_per_m"] = stiffness_N_per_m;
    json["device"]["damping_Ns_per_m"] = 0;
    json["live"]["force"] = "seen";
    json["live"]["grip"] = {{"stiffness_N_per_m", grip_stiffness_N_per_m},
                            {"damping_Ns_per_m", damping_Ns_per_m},
                            {"mass_kg", 0.1}};
    return made(parse_plan(json.dump(), "plan.json", ""));
  }
  std::string refusal() const {
    const auto error = check_grip(plan, scenes);
    return error ? error->to_string() : "";
  }
  // How far the frame moves in a second, a second after the pointer went 2 mm into the wall.
  double swing_m() const {
    RunSetup setup = scenes.front().setup;
    setup.haptics.force = ForceMode::kFull;
    const TrialWay& way = scenes.front().way;
    const ScenePose& pose = setup.haptics.initial_pose;
    PointedDevice pointer(setup.device, pose.point(way.green_m));
    LedHand hand(pointer, setup, *plan.live->grip, pose.point(way.green_m));
    auto loop =
        made(HapticLoop::create(scenes.front().scene.world(), setup.actuation, setup.haptics));
    HapticSession session(loop, hand.device(), {.observers = {}, .takes_motors = false});
    session.start();
    const std::size_t leg = leg_at(way.path.lengths_m(), way.green_along_m);
    const Vec3 aim_m = pose.point(way.green_m + 2e-3 * way.path.points[leg].inward);
    pointer.point({true, 1, {aim_m.x(), aim_m.y(), aim_m.z()}});
    Vec3 low_m = Vec3::Constant(1.0), high_m = -low_m;
    TickRecord record;
    for (int i = 0; i < 2000; ++i) {
      session.tick(setup.dt_s);
      EXPECT_TRUE(session.latest(record));
      if (i < 1000) continue;
      low_m = low_m.cwiseMin(vec3(record.device_m));
      high_m = high_m.cwiseMax(vec3(record.device_m));
    }
    return (high_m - low_m).norm();
  }

  ExperimentPlan plan;
  std::vector<ExperimentScene> scenes;
};

// The number behind the last "at least ".
double number_in(const std::string& text) {
  const std::size_t at = text.rfind("at least ");
  return at == std::string::npos ? -1.0 : std::stod(text.substr(at + 9));
}

// With a held force, a wall of stiffness K is stable to first order in the period T if the damping
// b of device and hand is above K T / 2: the check wants twice that.
TEST(GripCheck, RefusesAGripThatSwingsAtTheWallAndStatesTheDampingThatFits) {
  constexpr double kWall_N_per_m = 6000.0, kPeriod_s = 1e-3;
  const Seen loose(kWall_N_per_m, 0.0);
  const double device_Ns_per_m = loose.scenes.front().setup.device.damping_Ns_per_m;
  const std::string refusal = loose.refusal();
  EXPECT_NE(refusal.find("plan.json: /live/grip/damping_Ns_per_m: is 0, with which"),
            std::string::npos)
      << refusal;
  EXPECT_EQ(refusal.find('\n'), std::string::npos);
  const double fitting_Ns_per_m = number_in(refusal);
  const double first_order_Ns_per_m = kWall_N_per_m * kPeriod_s - device_Ns_per_m;
  EXPECT_NEAR(fitting_Ns_per_m, first_order_Ns_per_m, 0.1 * first_order_Ns_per_m) << refusal;
  const Seen held(kWall_N_per_m, fitting_Ns_per_m);
  EXPECT_EQ(held.refusal(), "");
  EXPECT_NE(Seen(kWall_N_per_m, fitting_Ns_per_m - 0.02).refusal(), "");
  // A step of the encoder is the smallest motion that the loop can answer.
  const double step_m = held.scenes.front().setup.device.encoder_quantum_m;
  EXPECT_GT(loose.swing_m(), 10.0 * step_m);
  EXPECT_LE(held.swing_m(), 2.0 * step_m);
}

TEST(GripCheck, RefusesAMotionThatCannotBeComputed) {
  // Ten steps a tick, of a mass of 0.2 kg: 2 m / h = 4000 N s/m.
  EXPECT_NE(Seen(1000.0, 5000.0).refusal().find("is 5000; expected less than 3999"),
            std::string::npos)
      << Seen(1000.0, 5000.0).refusal();
  EXPECT_EQ(Seen(1000.0, 3000.0).refusal(), "");
}

}  // namespace
}  // namespace palpate::test
