// What a run amounts to, from ticks made by hand. The figures are sums of powers of two, so exact.

#include "engine/session/run_summary.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/session/trace_csv.h"
#include "engine/simulation/run_judgement.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TickRecord free_tick(const Vec3& device) {
  TickRecord r;
  put(device, r.device_m);
  put(device, r.goal_scene_m);
  put(device, r.proxy_scene_m);
  return r;
}

TickRecord contact_tick(const Vec3& device, double depth_m, double alpha_rad, const Vec3& full_N,
                        const Vec3& commanded_N) {
  TickRecord r = free_tick(device);
  r.contact = true;
  put(Vec3(8, 8, 8), r.goal_scene_m);
  put(vec3(r.goal_scene_m) + Vec3(0, 0, depth_m), r.proxy_scene_m);
  r.alpha_rad = alpha_rad;
  put(full_N, r.full_force_device_N);
  put(commanded_N, r.force_device_N);
  return r;
}

RunSummary summary_of(const std::vector<TickRecord>& records) {
  SummaryAccumulator sums;
  for (const TickRecord& r : records) sums.add(r);
  return sums.finish({});
}

TickRecord with_fault(TickRecord r, std::uint32_t faults) {
  r.faults = faults;
  return r;
}

TEST(RunSummary, OfNothingIsZero) {
  const RunSummary s = SummaryAccumulator().finish({});
  EXPECT_EQ(s.ticks, 0u);
  EXPECT_EQ(s.mean_penetration_m, 0.0);
  EXPECT_EQ(s.mean_contact_angle_deg, 0.0);
  EXPECT_EQ(s.share_within_30deg, 0.0);
  EXPECT_EQ(s.device_extent_m, Vec3::Zero());
  EXPECT_EQ(s.step_ns.max_ns, 0);
}

TEST(RunSummary, TakesMeansOverContactTicksOnly) {
  const Vec3 none = Vec3::Zero();
  const RunSummary s = summary_of({
      free_tick({5, 5, 5}),
      contact_tick(none, 0.25, 10 * kDegree, none, none),
      contact_tick(none, 0.75, 60 * kDegree, none, none),
      free_tick(none),
      contact_tick(none, 0.5, 20 * kDegree, none, none),
      contact_tick(none, 0.5, 90 * kDegree, none, none),
  });
  EXPECT_EQ(s.ticks, 6u);
  EXPECT_EQ(s.contact_ticks, 4u);
  EXPECT_EQ(s.mean_penetration_m, 0.5);
  EXPECT_EQ(s.max_penetration_m, 0.75);
  EXPECT_NEAR(s.mean_contact_angle_deg, 45.0, 1e-13);
  EXPECT_EQ(s.share_within_30deg, 0.5);
}

TEST(RunSummary, CountsAnAngleAsWithin30DegUpToAndWith30Deg) {
  const Vec3 none = Vec3::Zero();
  const double limit = std::numbers::pi / 6;
  EXPECT_EQ(summary_of({contact_tick(none, 1, limit * (1 - 1e-12), none, none)}).share_within_30deg,
            1.0);
  EXPECT_EQ(summary_of({contact_tick(none, 1, limit * (1 + 1e-12), none, none)}).share_within_30deg,
            0.0);
}

// The force of a tick acts until the next sample: it is paired with the way that follows.
TEST(RunSummary, PairsEachForceWithTheWayThatFollowsIt) {
  const Vec3 none = Vec3::Zero();
  const RunSummary s = summary_of({
      free_tick({0, 0, 0}),
      contact_tick({1, 0, 0}, 1, 0, {4, 2, 0}, {4, 0, 0}),   // way (1,0,0) under no force
      contact_tick({3, 1, 0}, 1, 0, {8, -2, 1}, {8, 0, 0}),  // way (2,1,0): port 8, lost 2
      free_tick({2, 5, 3}),                                  // way (-1,4,3): port -8, lost -8+3
      free_tick({0, 0, 0}),                                  // under no force
      contact_tick({0, 0, 0}, 1, 0, {16, 16, 16}, none),     // no way follows
  });
  EXPECT_EQ(s.port_work_J, 8.0 - 8.0);
  EXPECT_EQ(s.work_lost_J, 2.0 - 5.0);
}

TEST(RunSummary, HasNoWorkInTheFirstSample) {
  const RunSummary s =
      summary_of({contact_tick({1000, 0, 0}, 1, 0, {1, 0, 0}, {1, 0, 0}), free_tick({1002, 0, 0})});
  EXPECT_EQ(s.port_work_J, 2.0);
  EXPECT_EQ(s.work_lost_J, 0.0);
}

TEST(RunSummary, CountsEveryLossOfContactUndebounced) {
  const Vec3 none = Vec3::Zero();
  const TickRecord on = contact_tick(none, 1, 0, none, none);
  const TickRecord off = free_tick(none);
  EXPECT_EQ(summary_of({off, off}).losses_of_contact, 0u);
  EXPECT_EQ(summary_of({off, on, on}).losses_of_contact, 0u);
  EXPECT_EQ(summary_of({on, off}).losses_of_contact, 1u);
  EXPECT_EQ(summary_of({off, on, off, on, off, off, on, on, off}).losses_of_contact, 3u);
}

TEST(RunSummary, CountsFaultsByName) {
  const TickRecord good = free_tick(Vec3::Zero());
  const RunSummary s = summary_of({
      good,
      with_fault(good, kFaultNonFiniteSample),
      with_fault(good, kFaultNonFiniteSample),
      with_fault(good, kFaultBadTimeStep),
      with_fault(good, kFaultSolverCapped),
      with_fault(good, kFaultSolverCapped | kFaultNonFiniteSample),
      with_fault(good, kFaultJump),
  });
  EXPECT_EQ(s.ticks, 7u);
  EXPECT_EQ(kFaultNames[0], "non_finite_sample");
  EXPECT_EQ(s.faults[0], 3u);
  EXPECT_EQ(kFaultNames[1], "bad_time_step");
  EXPECT_EQ(s.faults[1], 1u);
  EXPECT_EQ(kFaultNames[2], "solver_capped");
  EXPECT_EQ(s.faults[2], 2u);
  EXPECT_EQ(kFaultNames[3], "jump");
  EXPECT_EQ(s.faults[3], 1u);
}

TEST(RunSummary, NamesTheFaultsOfATick) {
  EXPECT_EQ(fault_names(kFaultNone), "");
  EXPECT_EQ(fault_names(kFaultFarSample), "far_sample");
  EXPECT_EQ(fault_names(kFaultBadSettings), "bad_settings");
  EXPECT_EQ(fault_names(kFaultSolverCapped | kFaultBodyHeld), "solver_capped+body_held");
  for (const std::string_view name : kFaultNames) EXPECT_FALSE(name.empty());
}

// Its position is no number, its force zero, the rest of it what was before: the trace says
// contact, and so do the means. Work and extent leave it out.
TEST(RunSummary, CountsABadSampleAsTheStateItHoldsButNotItsPosition) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TickRecord bad = contact_tick(Vec3::Constant(nan), 0.5, 0, Vec3::Zero(), Vec3::Zero());
  bad.faults = kFaultNonFiniteSample;
  TickRecord far = contact_tick(Vec3::Constant(1e200), 0.5, 0, Vec3::Zero(), Vec3::Zero());
  far.faults = kFaultFarSample;
  const RunSummary s = summary_of({
      bad,
      contact_tick({0, 0, 0}, 0.5, 0, {2, 0, 0}, {2, 0, 0}),
      contact_tick({1, 0, 0}, 0.5, 0, {2, 0, 0}, {2, 0, 0}),  // way 1: 2 J
      bad,                                                    // the device is told zero
      contact_tick({64, 0, 0}, 0.5, 0, {2, 0, 0}, {2, 0, 0}),
      free_tick({65, 0, 0}),  // way 1: 2 J
      contact_tick({65, 0, 0}, 0.5, 0, {2, 0, 0}, {2, 0, 0}),
      far,
      free_tick({64, 0, 0}),
  });
  EXPECT_EQ(s.ticks, 9u);
  EXPECT_EQ(s.contact_ticks, 7u);
  EXPECT_EQ(s.mean_penetration_m, 0.5);
  EXPECT_EQ(s.max_penetration_m, 0.5);
  EXPECT_EQ(s.mean_contact_angle_deg, 0.0);
  EXPECT_EQ(s.port_work_J, 4.0);
  EXPECT_EQ(s.faults[0], 2u);
  EXPECT_EQ(s.device_extent_m, Vec3(65, 0, 0));
}

TEST(RunSummary, KeepsTheResultsOfACappedSolver) {
  TickRecord capped = contact_tick({1, 0, 0}, 0.5, 0, {2, 0, 0}, {2, 0, 0});
  capped.faults = kFaultSolverCapped;
  const RunSummary s = summary_of({capped, free_tick({2, 0, 0})});
  EXPECT_EQ(s.contact_ticks, 1u);
  EXPECT_EQ(s.port_work_J, 2.0);
}

TEST(RunSummary, MeasuresTheExtentOfTheDevice) {
  const RunSummary s =
      summary_of({free_tick({-1, 2, 0}), free_tick({3, 2, -4}), free_tick({0, 5, 0})});
  EXPECT_EQ(s.device_extent_m, Vec3(4, 3, 4));
  EXPECT_EQ(s.device_travel_m(), 4.0);
  RunSummary across;
  across.device_extent_m = Vec3(1, 3, 2);
  EXPECT_EQ(across.device_travel_m(), 3.0);
}

// ---- whether it is comparable ------------------------------------------------------------------

// A run of 1000 ticks of 1 ms, the first of them in contact, that came near to all of its way.
ExplorationRun run_with(std::uint64_t contact_ticks) {
  ExplorationRun run;
  run.summary.ticks = 1000;
  run.summary.contact_ticks = contact_ticks;
  run.way_share = 1.0;
  run.contour_scene_m = {Vec3::Zero(), Vec3(0.1, 0.05, 0)};
  return run;
}

bool mentions(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(),
                     [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

TEST(RunJudgement, RejectsRunsWhoseMeansAreNotPrinted) {
  EXPECT_EQ(shortfalls(run_with(0)), std::vector{Shortfall::kNeverTouched});
  EXPECT_EQ(shortfalls(run_with(49)), std::vector{Shortfall::kLittleContact});
  EXPECT_TRUE(
      mentions(reasons(run_with(49)), "in contact for 4.9 % of the run; expected at least 5 %"));
  EXPECT_FALSE(mentions(reasons(run_with(49)), "slips off"));
  EXPECT_TRUE(is_comparable(run_with(50)));
  for (const std::uint64_t ticks : {0, 1, 49, 50, 51, 1000}) {
    EXPECT_TRUE(has_means(run_with(ticks).summary) || !is_comparable(run_with(ticks))) << ticks;
  }
}

TEST(RunJudgement, NamesTheSmallObjectIfThereIsLittleContact) {
  ExplorationRun run = run_with(20);
  run.places_scene_m = {Vec3(1, 0, 0), Vec3(1.002, 0.001, 0)};
  run.contour_scene_m.clear();
  EXPECT_TRUE(mentions(reasons(run), "which spans only 2.0 mm where the hand presses 4.0 mm deep"));
}

TEST(RunJudgement, NamesTheSphereIfLittleIsCovered) {
  ExplorationRun run = run_with(500);
  run.way_share = 0.5;
  EXPECT_FALSE(mentions(reasons(run), "radius_m"));
  run.proxy_radius_m = 0.01;
  EXPECT_TRUE(
      mentions(reasons(run),
               "the sphere of `HapticSettings::god_object.radius_m` 0.01 m is too large to enter"));
}

TEST(StepTimes, AreThoseOfTheSmallestTickThatTheShareDoesNotExceed) {
  std::vector<std::int64_t> steps;
  for (std::int64_t n = 1000; n >= 1; --n) steps.push_back(n);
  const StepTimes s = StepTimes::of(steps);
  EXPECT_EQ(s.p50_ns, 500);
  EXPECT_EQ(s.p99_ns, 990);
  EXPECT_EQ(s.p999_ns, 999);
  EXPECT_EQ(s.max_ns, 1000);
  const StepTimes one = StepTimes::of({7});
  EXPECT_EQ(one.p50_ns, 7);
  EXPECT_EQ(one.p999_ns, 7);
  EXPECT_EQ(one.max_ns, 7);
  const StepTimes three = StepTimes::of({30, 10, 20});
  EXPECT_EQ(three.p50_ns, 20);
  EXPECT_EQ(three.p99_ns, 30);
}

}  // namespace
}  // namespace palpate
