// When a trial of a person is over, and when the person is lost.

#include "engine/live/trial_watch.h"

#include <gtest/gtest.h>

#include "engine/live/start_place.h"
#include "engine/session/closed_surfaces.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/paper_plan.h"

namespace palpate::test {
namespace {

constexpr double kDt_s = 1e-3;
constexpr double kLength_m = 0.4;

// A straight wall along x, below the hand, with the material on the left of a hand that goes to -x.
TrialWay straight_way() {
  TrialWay way;
  for (const double x_m : {0.0, kLength_m}) {
    way.path.points.push_back({Vec3(x_m, 0.0, 0.0), Vec3(0.0, -1.0, 0.0)});
  }
  way.green_along_m = 0.05;
  way.red_along_m = 0.35;
  way.green_m = Vec3(way.green_along_m, 0.0, 0.0);
  way.red_m = Vec3(way.red_along_m, 0.0, 0.0);
  return way;
}

class Watched {
 public:
  explicit Watched(double longest_lateness_s = 1.0)
      : clock_(way_, TrialSettings{}, 0.0, kDt_s),
        watch_(&clock_, kDt_s, longest_lateness_s, &clutch_) {}

  // The hand is at x, 1 mm in the wall or 1 mm above it.
  void tick(double x_m, bool is_in_contact, std::int64_t late_ns = 0, std::uint32_t rules = 0) {
    TickRecord record;
    record.rules = rules;
    record.tick = tick_++;
    record.proxy_scene_m[0] = record.goal_scene_m[0] = x_m;
    record.goal_scene_m[1] = is_in_contact ? -1e-3 : 1e-3;
    record.proxy_scene_m[1] = is_in_contact ? 0.0 : 1e-3;
    record.normal_scene[1] = is_in_contact ? 1.0 : 0.0;
    record.contact = is_in_contact ? 1 : 0;
    record.late_ns = late_ns;
    clock_.on_tick(record);
    watch_.on_tick(record);
  }
  void ticks(int count, double x_m, bool is_in_contact) {
    for (int i = 0; i < count; ++i) tick(x_m, is_in_contact);
  }

  // A pen leaves the screen; the clutch, which the plan does not permit, judges it.
  void lift() {
    Clutch::Presses presses;
    presses.count = ++lifts_;
    presses.is_lift = 1;
    clutch_.take(presses);
    clutch_.judge();
  }

  TrialWay way_ = straight_way();
  Clutch clutch_{false};
  std::uint64_t lifts_ = 0;
  TrialClock clock_;
  TrialWatch watch_;
  std::uint64_t tick_ = 0;
};

TEST(TrialWatch, FindsAPersonWhoIsOffTheWayForASecond) {
  Watched w;
  w.ticks(5000, 0.05, false);
  EXPECT_FALSE(w.watch_.is_lost()) << "the clock has not started";
  w.ticks(1000, 0.2, true);
  EXPECT_TRUE(w.watch_.is_lost()) << "the person touches the object elsewhere";
  EXPECT_DOUBLE_EQ(w.watch_.along_m(), 0.05) << "the green sphere";
  w.ticks(10, 0.05, true);
  w.ticks(999, 0.06, false);
  EXPECT_FALSE(w.watch_.is_lost());
  w.tick(0.06, false);
  EXPECT_TRUE(w.watch_.is_lost());
  EXPECT_DOUBLE_EQ(w.watch_.along_m(), 0.05);
  EXPECT_EQ(w.watch_.times_lost(), 2u);
  w.ticks(3000, 0.06, false);
  EXPECT_EQ(w.watch_.times_lost(), 2u) << "one time, however long";
}

// The clock does not move its place more than 30 mm ahead.
TEST(TrialWatch, FindsAPersonWhoGoesOnFartherAway) {
  Watched w;
  w.ticks(10, 0.05, true);
  w.ticks(1000, 0.12, true);
  EXPECT_TRUE(w.watch_.is_lost());
  w.tick(0.055, true);
  EXPECT_FALSE(w.watch_.is_lost()) << "back on the way";
  w.ticks(1000, 0.2, true);
  EXPECT_EQ(w.watch_.times_lost(), 2u);
  EXPECT_DOUBLE_EQ(w.watch_.along_m(), 0.055);
}

TEST(TrialWatch, IsOverWithTheClock) {
  Watched w;
  for (double x_m = 0.05; !w.clock_.is_over() && x_m < kLength_m; x_m += 1e-4) {
    EXPECT_FALSE(w.watch_.is_over());
    w.tick(x_m, true);
  }
  EXPECT_TRUE(w.clock_.is_over());
  EXPECT_TRUE(w.watch_.is_over());
  EXPECT_EQ(w.watch_.cut(), TrialCut::kNone);
  EXPECT_EQ(w.clock_.status(), TrialStatus::kDone);
}

TEST(TrialWatch, CutsATrialWithALateTickOrATrip) {
  Watched late(0.05);
  late.tick(0.05, true, 50'000'000);
  EXPECT_FALSE(late.watch_.is_over());
  late.tick(0.05, true, 50'000'001);
  EXPECT_TRUE(late.watch_.is_over());
  EXPECT_EQ(late.watch_.cut(), TrialCut::kLateTick);

  Watched often(0.05);
  often.ticks(10, 0.05, true);
  for (int i = 0; i < 5; ++i) often.tick(0.05, true, 10'900'000);  // leaves out 10 ms each
  EXPECT_FALSE(often.watch_.is_over());
  often.tick(0.05, true, 900'000);  // within its period
  EXPECT_FALSE(often.watch_.is_over());
  often.tick(0.05, true, 1'000'000);
  EXPECT_EQ(often.watch_.cut(), TrialCut::kLateTick);

  Watched tripped;
  tripped.watch_.on_trip({});
  for (int i = 0; i < 30; ++i) {
    tripped.tick(0.05, true, 0, kRuleTripped | kRuleRelease);
    EXPECT_FALSE(tripped.watch_.is_over()) << "the force falls, and the hand is not dropped";
  }
  tripped.tick(0.05, true, 0, kRuleTripped);
  EXPECT_TRUE(tripped.watch_.is_over());
  EXPECT_EQ(tripped.watch_.cut(), TrialCut::kTrip);
}

TEST(TrialWatch, CutsATrialInWhichAPenIsLiftedOnceTheClockHasStarted) {
  Watched w;
  w.ticks(10, 0.01, false);
  w.lift();
  w.ticks(10, 0.05, false);
  w.ticks(10, 0.05, true);
  EXPECT_FALSE(w.watch_.is_over()) << "nothing was measured yet";
  w.lift();
  w.tick(0.05, true);
  EXPECT_TRUE(w.watch_.is_over());
  EXPECT_EQ(w.watch_.cut(), TrialCut::kLift);
}

TEST(StartPlace, IsOutsideThePaperObjectsBesideTheGreenSphere) {
  const auto plan =
      parse_plan(shipped_plan_text("paper-live-mouse", ""), "plan", PALPATE_MODELS_DIR);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  const auto scenes = load_experiment_scenes(*plan, {find_trial_way, run_trial});
  ASSERT_TRUE(scenes.ok()) << scenes.error().to_string();
  for (const ExperimentScene& scene : *scenes) {
    const double radius_m = plan->trial.sphere_radius_m;
    const auto place_m = start_place_m(scene.scene, scene.way, radius_m);
    ASSERT_TRUE(place_m.ok()) << place_m.error().to_string();
    EXPECT_FALSE(enclosing_object(scene.scene, *place_m));
    const double away_m = (*place_m - scene.way.green_m).norm();
    EXPECT_LE(away_m, 2.0 * radius_m * (1.0 + 1e-12));
    EXPECT_GT(away_m, 0.0);
    // No other wall is nearer than the one of the green sphere.
    const auto lengths_m = scene.way.path.lengths_m();
    const double along_m = nearest_along_m(scene.way.path, lengths_m, *place_m);
    EXPECT_NEAR((point_along(scene.way.path, lengths_m, along_m) - *place_m).norm(), away_m,
                1e-9 * radius_m);
  }
}

}  // namespace
}  // namespace palpate::test
