// Trials of the experiment: the place on the contour, the operator's sight, and whole trials.

#include "engine/trials/trial.h"

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/simulation/intention_wander.h"
#include "engine/trials/contour_place.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/operator_hand.h"
#include "engine/trials/seen_picture.h"
#include "engine/trials/trials_file.h"
#include "haptics/record_vectors.h"
#include "haptics/strategies/control_display.h"
#include "models/primitives.h"
#include "tests/engine/trials/prepared_object.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kPaperObjects;
using test::prepared_model;
using test::PreparedObject;
using test::Random;

// A person whose hand does not shake.
OperatorParameters steady_person() {
  OperatorParameters person;
  person.force_noise = 0.0;
  person.intention_noise_m = 0.0;
  return person;
}

OperatorParameters shaking_person() {
  OperatorParameters person;
  person.intention_noise_m = 6.6e-3;
  return person;
}

TrialOutcome run(const std::string& object, const OperatorParameters& person,
                 const TrialConditions& conditions) {
  const PreparedObject& p = prepared_model(object);
  auto outcome = run_trial(p.scene, p.way, p.setup, {}, person, conditions);
  EXPECT_TRUE(outcome.ok());
  return *outcome;
}

// A square of this side with material on the left of the path.
HandPath square(double side_m) {
  HandPath path;
  const Vec3 corners[] = {{0, 0, 0}, {side_m, 0, 0}, {side_m, side_m, 0}, {0, side_m, 0}};
  for (int i = 0; i < 4; ++i) {
    const Vec3 tangent = (corners[(i + 1) % 4] - corners[i]).normalized();
    path.points.push_back({corners[i], Vec3::UnitZ().cross(tangent), std::numbers::pi / 2});
  }
  path.points.push_back({corners[0], path.points.back().inward});
  return path;
}

TEST(ContourPlace, MovesToContactsAheadAndNeverBack) {
  const HandPath path = square(0.2);
  ContourPlace place(path, 0.05, 8e-4);
  const Vec3 down = -Vec3::UnitY();
  EXPECT_TRUE(place.see({0.07, 0.0, 0.0}, down));
  EXPECT_DOUBLE_EQ(place.along_m(), 0.07);
  EXPECT_TRUE(place.see({0.065, 0.0, 0.0}, down));
  EXPECT_DOUBLE_EQ(place.along_m(), 0.07);
  EXPECT_FALSE(place.see({0.07 - 1.01 * ContourPlace::kKept_m, 0.0, 0.0}, down));
  EXPECT_FALSE(place.see({0.07 + 1.01 * ContourPlace::kReach_m, 0.0, 0.0}, down));
  EXPECT_FALSE(place.see({0.08, 2e-4, 0.0}, down)) << "off the contour";
  EXPECT_FALSE(place.see({0.08, 0.0, 0.0}, Vec3::UnitY())) << "from behind the wall";
  EXPECT_FALSE(place.see({0.08, 0.2, 0.0}, Vec3::UnitY())) << "the opposite wall";
  EXPECT_DOUBLE_EQ(place.along_m(), 0.07);
}

TEST(ContourPlace, PassesACorner) {
  const HandPath path = square(0.2);
  ContourPlace place(path, 0.19, 8e-4);
  EXPECT_TRUE(place.see({0.2, 0.015, 0.0}, Vec3::UnitX()));
  EXPECT_DOUBLE_EQ(place.along_m(), 0.215);
}

TEST(TrialWay, IsWhatTheModelsState) {
  for (const char* object : kPaperObjects) {
    const TrialWay& way = prepared_model(object).way;
    // The spheres are 10 mm on either side of the middle of a wall. The coordinates of the files
    // are single precision.
    const double once_m = way.path.lengths_m().back() - way.green_along_m;
    EXPECT_NEAR(once_m - (way.red_along_m - way.green_along_m), 0.02, 1e-7) << object;
    EXPECT_NEAR((way.green_m - way.red_m).norm(), 0.02, 1e-7) << object;
    for (std::size_t i = 0; i + 1 < way.path.points.size(); ++i) {
      const Vec3 tangent = way.path.points[i + 1].p_m - way.path.points[i].p_m;
      EXPECT_GT(Vec3::UnitZ().cross(tangent).dot(way.path.points[i].inward), 0.0) << object;
    }
  }
}

// The crossings of a level by Rice's formula, and the variance.
TEST(IntentionWander, HasTheVarianceAndTheCrossingsOfItsDefinition) {
  for (const double dt_s : {1e-3, 2.5e-3}) {
    SCOPED_TRACE(dt_s);
    std::mt19937_64 random(7);
    IntentionWander wander;
    const double natural_Hz = 2.0;
    const double level = -1.0;
    const auto steps = static_cast<int>(2000.0 / dt_s);
    double square_sum = 0.0;
    int crossings = 0;
    Vec3 before = wander.advance(natural_Hz, dt_s, random);
    for (int n = 0; n < steps; ++n) {
      const Vec3 now = wander.advance(natural_Hz, dt_s, random);
      for (int k = 0; k < 3; ++k) crossings += before[k] >= level && now[k] < level ? 1 : 0;
      square_sum += now.squaredNorm();
      before = now;
    }
    EXPECT_NEAR(square_sum / (3.0 * steps), 1.0, 0.03);
    const double per_s = crossings / (3.0 * steps * dt_s);
    EXPECT_NEAR(per_s, natural_Hz * std::exp(-0.5 * level * level), 0.03 * natural_Hz);
  }
}

// The correlation of eta'' = -2 z w eta' - w^2 eta + q xi with itself, tau later, is the solution
// of the equation without noise that begins at rest at 1; with w' = w sqrt(1 - z^2): exp(-z w tau)
// (cos w' tau + z / sqrt(1 - z^2) sin w' tau).
TEST(IntentionWander, ForgetsAsItsDampingStates) {
  constexpr double kDampingRatio = 0.7;
  constexpr double kNatural_Hz = 2.0;
  constexpr double kStep_s = 5e-3;
  constexpr double kDuration_s = 4000.0;
  constexpr std::size_t kLag = 24;  // w tau = 1.5, where the correlation depends most on z
  const double w = 2.0 * std::numbers::pi * kNatural_Hz;
  const double root = std::sqrt(1.0 - kDampingRatio * kDampingRatio);
  const double turn = root * w * kStep_s * kLag;
  const double expected = std::exp(-kDampingRatio * w * kStep_s * kLag) *
                          (std::cos(turn) + kDampingRatio / root * std::sin(turn));
  const test::Random seeded(11);
  std::mt19937_64 random(seeded.seed());
  IntentionWander wander;
  std::array<Vec3, kLag> before;
  for (Vec3& noise : before) noise = wander.advance(kNatural_Hz, kStep_s, random);
  const auto steps = static_cast<std::size_t>(kDuration_s / kStep_s);
  double sum = 0.0;
  for (std::size_t n = 0; n < steps; ++n) {
    const Vec3 now = wander.advance(kNatural_Hz, kStep_s, random);
    sum += before[n % kLag].dot(now);
    before[n % kLag] = now;
  }
  // A product of two normal numbers has a variance of at most 2. Three axes of this duration have
  // the scatter of independent products every 4 z / w, the integral of the correlation.
  const double independent = 3.0 * kDuration_s / (4.0 * kDampingRatio / w);
  const double deviation = std::sqrt(2.0 / independent);
  EXPECT_NEAR(sum / (3.0 * static_cast<double>(steps)), expected, 4.0 * deviation);
}

// Feeds a hand with records whose other fields are poison; it must behave as with clean ones.
TEST(OperatorHand, KnowsNothingButItsPictures) {
  const PreparedObject& p = prepared_model("star");
  const OperatorParameters person = steady_person();
  OperatorHand clean(p.way, person, Following::kPredict, {}, 0.0);
  OperatorHand poisoned(p.way, person, Following::kPredict, {}, 0.0);
  bool has_differed = false;
  const TrialSink compare = [&](const TickRecord& r) {
    TickRecord poison;
    std::memset(static_cast<void*>(&poison), 0xff, sizeof poison);  // every double is NaN
    put(pose_after(r), poison.q_after_wxyz, poison.o_after_m);
    put(vec3(r.proxy_scene_m), poison.proxy_scene_m);
    put(vec3(r.device_m), poison.device_m);
    poison.contact = r.contact;
    const HandTarget a = clean.target(r.time_s, pose_after(r), r);
    const HandTarget b = poisoned.target(r.time_s, pose_after(r), poison);
    has_differed =
        has_differed || a.position_m != b.position_m || a.velocity_m_per_s != b.velocity_m_per_s;
  };
  TrialConditions conditions;
  conditions.a4 = true;
  ASSERT_TRUE(run_trial(p.scene, p.way, p.setup, {}, person, conditions, compare).ok());
  EXPECT_FALSE(has_differed);
}

// The scene is displaced at once; the target moves when the first picture that shows it is as old
// as the delay of sight.
TEST(OperatorHand, SeesADisplacedSceneAfterItsDelay) {
  const PreparedObject& p = prepared_model("star");
  OperatorParameters person = steady_person();
  person.speed_m_per_s = 0.0;
  const TrialSettings settings;
  for (const double delay_s : {0.117, 0.15, 0.2}) {
    person.sight_delay_s = delay_s;
    OperatorHand hand(p.way, person, Following::kDelayed, settings, 0.0);
    ScenePose pose = p.setup.haptics.initial_pose;
    TickRecord record;
    put(hand.start_scene_m(), record.proxy_scene_m);
    Vec3 first = Vec3::Zero();
    double moved_s = 0.0;
    for (int n = 0; n < 2000 && moved_s == 0.0; ++n) {
      if (n == 1000) pose.translation_m.x() += 0.01;
      put(pose.point(hand.start_scene_m()), record.device_m);
      const HandTarget target = hand.target(1e-3 * n, pose, record);
      if (n == 999) first = target.position_m;
      if (n >= 1000 && target.position_m != first) moved_s = 1e-3 * n;
    }
    EXPECT_GE(moved_s, 1.0 + delay_s);
    EXPECT_LE(moved_s, 1.0 + delay_s + 1.0 / settings.display_Hz + 2e-3);
  }
}

// A person stands and presses on the wall with a hand that is where the person aims, and later is
// displaced along the wall. The correction begins when the first picture that shows this is as old
// as the delay of sight.
TEST(OperatorHand, CorrectsADisplacedHandAfterItsDelay) {
  const PreparedObject& p = prepared_model("star");
  OperatorParameters person = steady_person();
  person.speed_m_per_s = 0.0;
  const TrialSettings settings;
  constexpr double kDisplaced_m = 1e-3;
  constexpr int kDisplacedAt =
      20'000;  // the person has long corrected the place of the first touch
  constexpr double kTick_s = 1e-3;
  const ScenePose& pose = p.setup.haptics.initial_pose;
  const std::size_t leg = leg_at(p.way.path.lengths_m(), p.way.green_along_m);
  const Vec3 inward = p.way.path.points[leg].inward;
  const Vec3 along = inward.cross(Vec3::UnitZ());
  for (const double delay_s : {0.117, 0.15, 0.2}) {
    person.sight_delay_s = delay_s;
    OperatorHand hand(p.way, person, Following::kDelayed, settings, 0.0);
    TickRecord record;
    record.contact = 1;
    Vec3 hand_m = p.way.green_m + person.press_depth_m * inward;
    Vec3 aim_m = Vec3::Zero();
    double before_m = 0.0;
    int moved = 0;
    for (int n = 0; n < kDisplacedAt + 1000 && moved == 0; ++n) {
      const Vec3 aside_m = n < kDisplacedAt ? Vec3(Vec3::Zero()) : Vec3(kDisplaced_m * along);
      put(pose.point(hand_m + aside_m), record.device_m);
      put(hand_m + aside_m - inward.dot(hand_m - p.way.green_m) * inward, record.proxy_scene_m);
      aim_m = pose.inverse_point(hand.target(kTick_s * n, pose, record).position_m);
      // A tick corrects gain * displacement * tick; half of it is far above rounding.
      const double least_m = 0.5 * person.gain_per_s * kDisplaced_m * kTick_s;
      if (n >= kDisplacedAt && (aim_m - hand_m).norm() >= least_m) moved = n;
      before_m = hand_m.dot(along);
      // Until the person has felt the wall, the aim is outside.
      if ((aim_m - p.way.green_m).dot(inward) > 0.0) hand_m = aim_m;
    }
    const double waited_s = kTick_s * (moved - kDisplacedAt);
    EXPECT_GE(waited_s, delay_s);
    EXPECT_LE(waited_s, delay_s + 1.0 / settings.display_Hz + 2 * kTick_s);
    EXPECT_LT(aim_m.dot(along), before_m) << "away from the displacement";
  }
}

// A random pose of a device with two sensors: turned about A3.
ScenePose random_planar_pose(Random& random) {
  const double turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  return {Quat(Eigen::AngleAxisd(turn_rad, Vec3::UnitZ())), 0.3 * random.unit_vector()};
}

Eigen::Matrix4d matrix_of(const ScenePose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = pose.translation_m;
  return m;
}

constexpr double kSize_m = 0.2;  // of a scene

TEST(SeenPicture, IsInTheStillViewTheTurningOneMappedBackByThePose) {
  Random random(2301);
  for (int i = 0; i < 10'000; ++i) {
    const ScenePose first = random_planar_pose(random);
    const ScenePose now = random_planar_pose(random);
    const Vec3 proxy_m = kSize_m * random.unit_vector();
    const Vec3 device_m = kSize_m * random.unit_vector();
    const SeenPicture turning = seen_picture(View::kTurning, first, now, proxy_m, device_m);
    const SeenPicture still = seen_picture(View::kStill, first, now, proxy_m, device_m);
    const Eigen::Matrix4d back = matrix_of(first) * matrix_of(now).inverse();
    const auto mapped = [&](const Vec3& p_m) { return Vec3((back * p_m.homogeneous()).head<3>()); };
    ASSERT_EQ(turning.device_m(), now.point(device_m));
    ASSERT_LE((still.proxy_m() - mapped(turning.proxy_m())).norm(), 1e-12 * kSize_m);
    ASSERT_LE((still.device_m() - mapped(turning.device_m())).norm(), 1e-12 * kSize_m);
    // The scene keeps its first pose.
    const Vec3 p_scene_m = kSize_m * random.unit_vector();
    ASSERT_EQ(still.T_picture_scene.point(p_scene_m), first.point(p_scene_m));
    ASSERT_LE((first.point(p_scene_m) - mapped(now.point(p_scene_m))).norm(), 1e-12 * kSize_m);
  }
}

TEST(AdaptedPose, HasTheTurnThatThePersonAdaptsTo) {
  Random random(2302);
  for (int i = 0; i < 10'000; ++i) {
    const ScenePose first = random_planar_pose(random);
    const double turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Vec3 pivot_m = kSize_m * random.unit_vector();
    const ScenePose now = turned_about(first, pivot_m, {Vec3::UnitZ(), turn_rad});
    ASSERT_NEAR(turn_since_rad(first, now), turn_rad, 1e-14);
    const Vec3 seen_m = kSize_m * random.unit_vector();
    const Vec3 felt_m = now.point(seen_m);
    for (const double share : {0.0, 0.5, 1.0}) {
      const ScenePose pose = adapted_pose(first, now, seen_m, felt_m, share);
      ASSERT_LE((pose.point(seen_m) - felt_m).norm(), 1e-12 * kSize_m);
      const Vec3 v = random.unit_vector();
      const Vec3 expected = Eigen::AngleAxisd(share * turn_rad, Vec3::UnitZ()) * first.direction(v);
      ASSERT_LE((pose.direction(v) - expected).norm(), 1e-14);
      if (share < 1.0) continue;
      const Vec3 p_m = kSize_m * random.unit_vector();
      ASSERT_LE((pose.point(p_m) - now.point(p_m)).norm(), 1e-12 * kSize_m);
    }
    // A scene that has moved without turning, as the strategy cd moves it.
    const ScenePose moved{now.rotation, now.translation_m + kSize_m * random.unit_vector()};
    for (const double share : {0.0, 0.5, 1.0}) {
      const ScenePose same = adapted_pose(now, moved, seen_m, moved.point(seen_m), share);
      ASSERT_EQ(same.rotation.coeffs(), moved.rotation.coeffs());
      ASSERT_EQ(same.translation_m, moved.translation_m);
    }
  }
}

TEST(AdaptedPose, TakesHalfATurnForPositive) {
  const ScenePose first;
  for (const double sign : {1.0, -1.0}) {
    const ScenePose now{Quat(0.0, 0.0, 0.0, sign), Vec3::Zero()};
    EXPECT_EQ(turn_since_rad(first, now), std::numbers::pi);
  }
}

// The scene turns about the proxy, as A4 turns it, once round and more. A person who adapts wholly
// aims where a person aims who sees the scene turn.
TEST(OperatorHand, ThatAdaptsWhollyBelievesInTheTurningPose) {
  const PreparedObject& p = prepared_model("star");
  OperatorParameters person = steady_person();
  person.speed_m_per_s = 0.0;
  OperatorHand turning(p.way, person, Following::kDelayed, {}, 0.0);
  OperatorHand adapting(p.way, person, Following::kAdaptsWhole, {}, 0.0);
  const std::size_t leg = leg_at(p.way.path.lengths_m(), p.way.green_along_m);
  const Vec3 inward = p.way.path.points[leg].inward;
  const Vec3 goal_m = p.way.green_m + 0.5 * person.press_depth_m * inward;
  ScenePose pose = p.setup.haptics.initial_pose;
  TickRecord record;
  record.contact = 1;
  for (int n = 0; n < 10'000; ++n) {
    put(p.way.green_m, record.proxy_scene_m);
    put(pose.point(goal_m), record.device_m);
    const HandTarget seen = turning.target(1e-3 * n, pose, record);
    const HandTarget adapted = adapting.target(1e-3 * n, pose, record);
    ASSERT_EQ(seen.position_m, adapted.position_m) << n;
    pose = turned_about(pose, p.way.green_m, {Vec3::UnitZ(), 1e-3});
  }
}

// The hand stands still at a wall while the scene turns under it by 40 deg. A target that is ahead
// of the hand in the scene is ahead of it in the direction of the first pose.
TEST(OperatorHand, ThatDoesNotAdaptMovesInTheFirstDirection) {
  const PreparedObject& p = prepared_model("star");
  OperatorParameters person = steady_person();
  person.speed_m_per_s = 0.0;
  const std::size_t leg = leg_at(p.way.path.lengths_m(), p.way.green_along_m);
  const Vec3 inward = p.way.path.points[leg].inward;
  const Vec3 goal_m = p.way.green_m + 0.5 * person.press_depth_m * inward;
  for (const auto& [following, share] :
       {std::pair(Following::kAdaptsNone, 0.0), std::pair(Following::kAdaptsHalf, 0.5),
        std::pair(Following::kAdaptsWhole, 1.0)}) {
    OperatorHand hand(p.way, person, following, {}, 0.0);
    const ScenePose first = p.setup.haptics.initial_pose;
    const double turn_rad = 40.0 * std::numbers::pi / 180.0;
    const ScenePose now = turned_about(first, p.way.green_m, {Vec3::UnitZ(), turn_rad});
    TickRecord record;
    record.contact = 1;
    HandTarget target;
    for (int n = 0; n < 3000; ++n) {
      const ScenePose& pose = n < 1000 ? first : now;
      put(p.way.green_m, record.proxy_scene_m);
      put(pose.point(goal_m), record.device_m);
      target = hand.target(1e-3 * n, pose, record);
    }
    const Vec3 felt_m = now.point(goal_m);
    const Vec3 ahead_m = target.position_m - felt_m;
    // In the coordinates of the believed pose the aim is D inside the wall at the green sphere,
    // with a correction along the wall.
    const Vec3 wall = Eigen::AngleAxisd(share * turn_rad, Vec3::UnitZ()) * first.direction(inward);
    EXPECT_NEAR(ahead_m.dot(wall), 0.5 * person.press_depth_m, 1e-9);
  }
}

// The outcome as trials.csv writes it, but for the name of the following.
std::string row_of(const TrialOutcome& outcome) {
  CsvLines lines("");
  lines.clear();
  TrialRow row;
  row.status = outcome.status;
  row.measures = outcome.measures;
  add_row(lines, row);
  return lines.text();
}

TEST(Trial, GivesTheSameRowAgainAndForEachFollowingIfTheSceneDoesNotTurn) {
  struct Case {
    const char* object;
    ForceMode force;
  };
  for (const Case& c : {Case{"star", ForceMode::kActuated}, Case{"labyrinth", ForceMode::kFull},
                        Case{"lock", ForceMode::kNone}}) {
    TrialConditions conditions;
    conditions.force = c.force;
    conditions.noise_seed = 42;
    SCOPED_TRACE(std::string(c.object) + ", seed " + std::to_string(conditions.noise_seed));
    const TrialOutcome first = run(c.object, shaking_person(), conditions);
    for (const Following following :
         {Following::kDelayed, Following::kPredict, Following::kReplan, Following::kFrozen,
          Following::kAdaptsNone, Following::kAdaptsHalf, Following::kAdaptsWhole}) {
      conditions.following = following;
      const TrialOutcome again = run(c.object, shaking_person(), conditions);
      EXPECT_EQ(again.ticks, first.ticks);
      EXPECT_EQ(row_of(again), row_of(first));
    }
    conditions.noise_seed = 43;
    EXPECT_NE(row_of(run(c.object, shaking_person(), conditions)), row_of(first));
  }
}

// With rotation too, a person who adapts wholly does what a person does who sees the scene turn.
TEST(Trial, OfAPersonWhoAdaptsWhollyIsTheTrialOfOneWhoSeesTheSceneTurn) {
  for (const char* const object : kPaperObjects) {
    TrialConditions conditions;
    conditions.a4 = true;
    conditions.noise_seed = 44;
    const TrialOutcome seen = run(object, shaking_person(), conditions);
    conditions.following = Following::kAdaptsWhole;
    EXPECT_EQ(row_of(run(object, shaking_person(), conditions)), row_of(seen)) << object;
  }
}

// Nothing turns: in a large scene, farther than an arm reaches, and in a scene that `cd` moves.
TEST(Trial, InTheStillViewIsTheTurningOneIfNothingTurns) {
  SceneSettings large;
  large.fit_size_m = 3.0;
  auto star = Scene::load(std::string(PALPATE_MODELS_DIR) + "/star.glb", large);
  ASSERT_TRUE(star.ok());
  RunSettings device = test::paper_device();
  set_workspace_extent(device.device, 10.0);
  const PreparedObject far = test::prepared(std::move(*star), device);
  OperatorParameters fast = shaking_person();
  fast.speed_m_per_s = 0.5;
  auto small = Scene::load(std::string(PALPATE_MODELS_DIR) + "/star.glb");
  ASSERT_TRUE(small.ok());
  PreparedObject turned = test::prepared(std::move(*small));
  turned.setup = turned_setup(turned.setup, 33.0);
  TrialConditions cd;
  cd.strategy = Strategy{&kControlDisplayStrategy};
  struct Case {
    const PreparedObject* object;
    OperatorParameters person;
    TrialConditions conditions;
  };
  for (const Case& c : {Case{&far, fast, {}}, Case{&turned, shaking_person(), cd}}) {
    TrialConditions conditions = c.conditions;
    const auto row = [&](Following following) {
      conditions.following = following;
      const auto outcome =
          run_trial(c.object->scene, c.object->way, c.object->setup, {}, c.person, conditions);
      EXPECT_TRUE(outcome.ok());
      return row_of(*outcome);
    };
    const std::string turning = row(Following::kDelayed);
    EXPECT_NE(turning.find("done"), std::string::npos) << turning;
    for (const Following following :
         {Following::kAdaptsNone, Following::kAdaptsHalf, Following::kAdaptsWhole}) {
      EXPECT_EQ(row(following), turning);
    }
  }
}

// The weakest hand with the slowest motion and the largest gain, pushed sideways by one motor.
TEST(Trial, OfAWeakHandWithoutNoiseGetsRoundEveryObject) {
  OperatorParameters person = steady_person();
  person.hand_stiffness_N_per_m = 135.0;
  person.gain_per_s = 4.0;
  person.speed_m_per_s = 0.03;
  for (const char* object : kPaperObjects) {
    const TrialOutcome outcome = run(object, person, {});
    EXPECT_EQ(outcome.status, TrialStatus::kDone) << object;
  }
}

// A square with two sides of fine saw teeth, which the hand ignores and which make half of the
// contour longer: lengths along the contour and along the hand's path grow differently.
TEST(Trial, GetsRoundAContourWhoseHalvesDifferInDetail) {
  constexpr double kHalf_m = 0.06;
  constexpr double kTooth_m = 4e-4;
  constexpr int kTeeth = 80;
  Contour contour{{-kHalf_m, -kHalf_m}, {kHalf_m, -kHalf_m}};
  const auto at_m = [&](int i) { return kHalf_m * (i / double{kTeeth} - 1.0); };
  for (int i = 1; i < 2 * kTeeth; ++i) contour.push_back({kHalf_m - i % 2 * kTooth_m, at_m(i)});
  contour.push_back({kHalf_m, kHalf_m});
  for (int i = 1; i < 2 * kTeeth; ++i) contour.push_back({-at_m(i), kHalf_m - i % 2 * kTooth_m});
  contour.push_back({-kHalf_m, kHalf_m});
  const auto mesh = prism(contour, -0.02, 0.02);
  ASSERT_TRUE(mesh.ok());
  SceneDescription description;
  description.meshes.push_back({"", mesh->positions_m, mesh->triangles});
  description.nodes.emplace_back();
  description.tree.emplace_back();
  const PreparedObject p = test::prepared(test::compiled(std::move(description)));
  for (const ForceMode force : {ForceMode::kNone, ForceMode::kActuated, ForceMode::kFull}) {
    for (const bool a4 : {false, true}) {
      const auto outcome = run_trial(p.scene, p.way, p.setup, {}, shaking_person(),
                                     {.force = force, .a4 = a4, .noise_seed = 3});
      ASSERT_TRUE(outcome.ok());
      EXPECT_EQ(outcome->status, TrialStatus::kDone);
    }
  }
}

// The depth follows from the springs, the angle from A4.
TEST(Trial, ForceReducesTheDepthAndRotationReducesTheAngle) {
  const OperatorParameters person = shaking_person();
  std::map<bool, double> angle_deg;
  for (const bool a4 : {false, true}) {
    std::map<ForceMode, double> depth_m;
    for (const char* object : kPaperObjects) {
      for (const ForceMode force : {ForceMode::kNone, ForceMode::kActuated, ForceMode::kFull}) {
        const TrialOutcome outcome =
            run(object, person, {.force = force, .a4 = a4, .noise_seed = 5});
        depth_m[force] += outcome.measures[kPenetration].value_or(0.0);
        angle_deg[a4] += outcome.measures[kContactAngle].value_or(0.0) / 12.0;
      }
    }
    EXPECT_LT(depth_m[ForceMode::kFull], depth_m[ForceMode::kActuated]);
    EXPECT_LT(depth_m[ForceMode::kActuated], depth_m[ForceMode::kNone]);
  }
  EXPECT_LT(angle_deg[true], angle_deg[false] - 10.0);
}

TEST(Trial, ReportsTheTimeLimitAsAStatusAndCoversOnlyClockedTicks) {
  const PreparedObject& p = prepared_model("star");
  TrialSettings settings;
  settings.limit_s = 3.0;
  std::uint64_t ticks = 0;
  const auto outcome = run_trial(p.scene, p.way, p.setup, settings, steady_person(), {},
                                 [&](const TickRecord&) { ++ticks; });
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->status, TrialStatus::kTimeout);
  EXPECT_EQ(outcome->ticks, 3000u);
  EXPECT_EQ(ticks, 3000u);
  EXPECT_LT(outcome->measures[kTotalTime].value_or(9.0), 3.0);
  EXPECT_GT(outcome->measures[kTotalTime].value_or(0.0), 1.0);
}

// Without contact within the green sphere the clock does not start, and no measure is defined.
TEST(Trial, LeavesMeasuresEmptyIfTheClockNeverStarts) {
  const PreparedObject& p = prepared_model("star");
  TrialSettings settings;
  settings.limit_s = 0.2;
  const auto outcome = run_trial(p.scene, p.way, p.setup, settings, steady_person(), {});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->status, TrialStatus::kTimeout);
  for (const auto& measure : outcome->measures) EXPECT_FALSE(measure.has_value());
}

TEST(TrialWay, RefusesThreeSensors) {
  const auto setup = make_setup(RunSettings{});
  const auto way = find_trial_way(prepared_model("star").scene, *setup, {});
  ASSERT_FALSE(way.ok());
  EXPECT_EQ(way.error().element, "device.sensors");
}

}  // namespace
}  // namespace palpate
