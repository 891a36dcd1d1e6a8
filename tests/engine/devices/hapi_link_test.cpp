// The conversation with a simulated board, in virtual time. The board's log is the judge of what
// the motors did.

#include "engine/devices/hapi_link.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/devices/hapi_rig.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::FakeGuard;
using test::force_N;
using test::HapiRig;
using test::is_zero;
using test::kMillisecond_ns;
using test::pushing_settings;
using Kind = BoardFault::Kind;

const Vec2 kPush_N(0.5, -0.25);

// A rig whose board pushes.
struct Pushing : HapiRig {
  explicit Pushing(const HapiSettings& settings = pushing_settings()) : HapiRig(settings) {
    run_until_working();
    push(kPush_N, 50 * kMillisecond_ns);
  }
};

bool all_zero(const std::vector<BoardCommand>& commands) {
  return !commands.empty() && std::all_of(commands.begin(), commands.end(), is_zero);
}

TEST(HapiLink, StopsTheMotorsSetsUpTheBoardAndReadsTheRestPose) {
  HapiRig rig;
  EXPECT_FALSE(rig.link.sample().is_working);
  rig.run_until_working();
  const HapiSample& sample = rig.link.sample();
  ASSERT_TRUE(sample.is_working);
  EXPECT_EQ(rig.board.set_ups(), 1u);
  EXPECT_EQ(sample.sequence, 1u);
  EXPECT_EQ(sample.trips, 0u);
  const auto tip = FiveBar(FiveBarLinks{}).forward({std::acos(-1.0), 0.0});
  EXPECT_EQ(sample.tip_m[0], tip->x());
  EXPECT_EQ(sample.tip_m[1], tip->y());
  EXPECT_TRUE(all_zero(rig.board.log()));
}

TEST(HapiLink, StopsABoardThatAnotherProgramHasLeftPushing) {
  HapiRig rig;
  // The board is set up, pushes, and is in the middle of a message.
  const HapiWiring wiring;
  const auto set_up = hapi_set_up(wiring, wiring.rest_deg);
  rig.board.receive(set_up, rig.now_ns);
  const auto tick = hapi_tick(wiring.device, {0.1f, 0.1f});
  rig.board.receive(tick, rig.now_ns);
  rig.board.receive(std::span(tick).first(5), rig.now_ns);
  EXPECT_EQ(rig.board.firmware().torques()[0], 0.1f);
  rig.step();
  EXPECT_LT(std::abs(rig.board.firmware().torques()[0]), 0x1p-119f);
  EXPECT_LT(std::abs(rig.board.firmware().torques()[1]), 0x1p-119f);
  rig.run_until_working();
  EXPECT_TRUE(rig.link.sample().is_working);
}

TEST(HapiLink, SendsOneMessageEachPeriodAndNumbersTheAnswers) {
  HapiRig rig;
  rig.run_until_working();
  const std::uint64_t first = rig.link.sample().sequence;
  const std::size_t commands = rig.board.log().size();
  rig.run(100 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().sequence, first + 100);
  EXPECT_EQ(rig.board.log().size(), commands + 100);
  const HapiCounts counts = rig.link.counts();
  EXPECT_EQ(counts.messages, counts.answers);
  EXPECT_EQ(counts.missed + counts.late + counts.malformed, 0u);
  EXPECT_EQ(counts.round_trip_longest_ns, 300'000);
  EXPECT_EQ(counts.round_trip_median_ns, 300'000);
}

// The rig's board has its angles quantised, and the driver knows only these: the force is exact in
// that pose, within the rounding of the torques to single precision, times the condition.
TEST(HapiLink, TorquesHaveTheForceOfTheNewestTick) {
  Pushing rig;
  rig.board.set_hand({0.02, 0.06});  // moves through other poses
  const HapiSettings settings = pushing_settings();
  std::size_t judged = 0;
  rig.run(200 * kMillisecond_ns, [&] {
    rig.link.set_force({{kPush_N.x(), kPush_N.y()}, rig.now_ns});
  });
  const auto& log = rig.board.log();
  for (std::size_t k = log.size() - 150; k < log.size(); ++k, ++judged) {
    const Vec2 force = force_N(log[k], log[k - 1].answered_deg, settings);
    const double bound = kNoForceCondition * std::numeric_limits<float>::epsilon();
    ASSERT_LE((force - kPush_N).norm(), bound * kPush_N.norm()) << "command " << k;
    // To the bit: within the limits, nothing changes a force on its way.
    const auto pose = hapi_pose(FiveBar(settings.links), log[k - 1].answered_deg);
    const Vec2 torques_Nm = pose->jacobian.transpose() * kPush_N;
    ASSERT_EQ(log[k].torques,
              (HapiNumbers{static_cast<float>(torques_Nm[0]), static_cast<float>(torques_Nm[1])}));
  }
  EXPECT_EQ(judged, 150u);
  EXPECT_GT((log.back().tip_m - log.front().tip_m).norm(), 0.01);
}

// A tick at 80 Hz is 12.5 ms long: its force holds until the next tick, and for five periods if
// there is none.
TEST(HapiLink, AForceOfSlowTicksIsHeldUntilTheNextTick) {
  HapiRig rig;
  rig.run_until_working();
  const std::int64_t tick_ns = 12'500'000;
  const auto tick = [&] { rig.link.set_force({{0.5, -0.25}, rig.now_ns, tick_ns}); };
  const std::int64_t start_ns = rig.now_ns;
  std::int64_t last_ns = 0;
  for (int n = 0; n < 8; ++n) {
    last_ns = rig.now_ns;
    tick();
    rig.run(tick_ns);
  }
  const auto pushed = rig.commands_since(start_ns + kMillisecond_ns);
  EXPECT_GE(pushed.size(), 98u);
  EXPECT_TRUE(std::none_of(pushed.begin(), pushed.end(), is_zero));
  rig.run(100 * kMillisecond_ns);
  for (const BoardCommand& command : rig.commands_since(last_ns + kMillisecond_ns)) {
    ASSERT_EQ(is_zero(command), command.time_ns - last_ns > 5 * tick_ns) << command.time_ns;
  }
}

TEST(HapiLink, CountsTheMessagesOfTheSlowestSecond) {
  HapiRig rig;
  rig.run_until_working();
  rig.run(500 * kMillisecond_ns);
  EXPECT_EQ(rig.link.counts().fewest_in_second, 0u);
  rig.run(600 * kMillisecond_ns);
  EXPECT_NEAR(static_cast<double>(rig.link.counts().fewest_in_second), 1000.0, 1.0);
  BoardFault slow = rig.fault(Kind::kDelay, 0, 900 * kMillisecond_ns);
  slow.delay_ns = 3 * kMillisecond_ns;
  rig.board.add_fault(slow);
  rig.run(2'000 * kMillisecond_ns);
  const HapiCounts counts = rig.link.counts();
  EXPECT_LT(counts.fewest_in_second, 500u);
  EXPECT_GT(counts.fewest_in_second, 250u);
  EXPECT_EQ(counts.missed, 0u);
}

TEST(HapiLink, CommandsZeroWithoutACalibration) {
  HapiSettings settings;
  settings.peak_torque_Nm = 0.1;
  HapiRig rig(settings);
  rig.run_until_working();
  rig.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_TRUE(rig.link.sample().is_working);
  EXPECT_TRUE(all_zero(rig.board.log()));
}

TEST(HapiLink, CommandsZeroWithoutAGuard) {
  for (const bool works_without : {false, true}) {
    HapiSettings settings = pushing_settings();
    settings.works_without_guard = works_without;
    HapiRig rig(settings);
    rig.link.set_guard(nullptr);
    rig.run_until_working();
    rig.push(kPush_N, 100 * kMillisecond_ns);
    EXPECT_EQ(all_zero(rig.board.log()), !works_without);
  }
}

TEST(HapiLink, CommandsZeroOnceTheNewestTickIsTooOld) {
  for (const double rate_Hz : {1000.0, 250.0}) {
    HapiSettings settings = pushing_settings();
    settings.rate_Hz = rate_Hz;
    Pushing rig(settings);
    const std::int64_t last_ns = rig.now_ns - kMillisecond_ns;  // of the last tick
    rig.run(100 * kMillisecond_ns);
    const std::int64_t limit_ns = (rate_Hz == 1000.0 ? 10 : 20) * kMillisecond_ns;
    int pushing = 0;
    int stopped = 0;
    for (const BoardCommand& command : rig.commands_since(last_ns + kMillisecond_ns)) {
      const bool is_old = command.time_ns - last_ns > limit_ns;
      EXPECT_EQ(is_zero(command), is_old) << command.time_ns - last_ns;
      ++(is_old ? stopped : pushing);
    }
    EXPECT_GT(pushing, 1);
    EXPECT_GT(stopped, 10);
    // It is no trip: the next tick counts, and the force grows again by the slew.
    EXPECT_EQ(rig.link.sample().trips, 0u);
    rig.push(kPush_N, 20 * kMillisecond_ns);
    EXPECT_FALSE(is_zero(rig.board.log().back()));
  }
}

TEST(HapiLink, ForceGrowsByTheSlewAfterAGap) {
  HapiSettings settings = pushing_settings();
  settings.peak_torque_Nm = 10.0;
  Pushing rig(settings);
  const Vec2 large_N(20.0, 0.0);
  rig.push(large_N, 50 * kMillisecond_ns);
  rig.run(50 * kMillisecond_ns);  // no ticks: zero
  const std::size_t before = rig.board.log().size();
  ASSERT_TRUE(is_zero(rig.board.log().back()));
  rig.push(large_N, 20 * kMillisecond_ns);
  double last_N = 0.0;
  for (std::size_t k = before; k < rig.board.log().size(); ++k) {
    const auto& command = rig.board.log()[k];
    const Vec2 force = force_N(command, rig.board.log()[k - 1].answered_deg, settings);
    // 5,000 N/s, and the rounding of the torques.
    const double bound = kNoForceCondition * std::numeric_limits<float>::epsilon() * 20.0;
    EXPECT_LE(force.norm(), last_N + 5.0 + bound);
    last_N = force.norm();
  }
  EXPECT_NEAR(last_N, 20.0, 1e-3);
}

TEST(HapiLink, TorquesStayBelowThePeakAndKeepTheDirection) {
  HapiSettings settings = pushing_settings();
  Pushing rig(settings);
  rig.push({-40.0, 30.0}, 100 * kMillisecond_ns);
  const BoardCommand& command = rig.board.log().back();
  const double largest = std::max(std::abs(command.torques[0]), std::abs(command.torques[1]));
  EXPECT_LE(largest, 0.1f);
  EXPECT_GT(largest, 0.0999);
  const HapiNumbers angles = rig.board.log()[rig.board.log().size() - 2].answered_deg;
  const Vec2 force = force_N(command, angles, settings);
  EXPECT_NEAR(force.normalized().dot(Vec2(-0.8, 0.6)), 1.0, 1e-9);
}

TEST(HapiLink, ForceFadesNearASingularPose) {
  // Distal links that are nearly in line in the rest pose.
  HapiSettings settings = pushing_settings();
  settings.links = {.base_m = 0.0399, .proximal_m = 0.05, .distal_m = 0.07};
  const auto pose = hapi_pose(FiveBar(settings.links), settings.wiring.rest_deg);
  ASSERT_TRUE(pose);
  ASSERT_EQ(pose->fade, 0.0);
  BoardSettings board;
  board.plant.links = settings.links;
  HapiRig rig(settings, board);
  rig.run_until_working();
  rig.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().fade, 0.0);
  EXPECT_TRUE(all_zero(rig.board.log()));
}

TEST(HapiTorques, FadeScalesTheForce) {
  const HapiSettings settings = pushing_settings();
  const FiveBar bar(settings.links);
  int fading = 0;
  for (float first_deg = 90.0f; first_deg < 240.0f; first_deg += 0.5f) {
    for (float second_deg = -60.0f; second_deg < 90.0f; second_deg += 0.5f) {
      const auto pose = hapi_pose(bar, {first_deg, second_deg});
      if (!pose) continue;
      fading += pose->fade > 0.0 && pose->fade < 1.0;
      HapiTorques torques(settings);
      const Vec2 force_N(1e-3, 2e-3);  // below every other limit
      const HapiNumbers numbers = torques.next(force_N, *pose, 1'000'000);
      const Vec2 full_Nm = pose->jacobian.transpose() * force_N;
      for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(static_cast<double>(numbers[static_cast<std::size_t>(k)]),
                    pose->fade * full_Nm[k],
                    std::numeric_limits<float>::epsilon() * full_Nm.norm());
      }
    }
  }
  EXPECT_GT(fading, 10);
}

TEST(HapiTorques, ForceThatIsNotFiniteIsZero) {
  const HapiSettings settings = pushing_settings();
  const auto pose = hapi_pose(FiveBar(settings.links), settings.wiring.rest_deg);
  HapiTorques torques(settings);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(torques.next({bad, 1.0}, *pose, 1'000'000), HapiNumbers{});
    EXPECT_EQ(torques.next({1.0, -bad}, *pose, 1'000'000), HapiNumbers{});
  }
}

TEST(HapiLink, CountsAMissingAnswerAndGoesOn) {
  Pushing rig;
  // One message: its answer is lost.
  rig.board.add_fault(rig.fault(Kind::kSilence, 0, kMillisecond_ns));
  const std::int64_t lost_ns = rig.now_ns;
  rig.push(kPush_N, 50 * kMillisecond_ns);
  const HapiCounts counts = rig.link.counts();
  EXPECT_EQ(counts.missed, 1u);
  EXPECT_EQ(counts.malformed, 0u);
  EXPECT_EQ(counts.set_ups, 1u);
  EXPECT_TRUE(rig.link.sample().is_working);
  EXPECT_EQ(rig.link.sample().trips, 0u);
  // The next message goes out after 5 ms.
  const auto commands = rig.commands_since(lost_ns);
  EXPECT_EQ(commands[1].time_ns - commands[0].time_ns, 5 * kMillisecond_ns);
  EXPECT_EQ(counts.messages, counts.answers + 1);
  // It soon sends one message a period again.
  EXPECT_EQ(rig.commands_since(rig.now_ns - 20 * kMillisecond_ns).size(), 20u);
}

TEST(HapiLink, MissingAnswersThatDoNotFollowEachOtherAreNoTrip) {
  Pushing rig;
  for (int n = 0; n < 10; ++n) {
    rig.board.add_fault(rig.fault(Kind::kSilence, 0, kMillisecond_ns));
    rig.push(kPush_N, 30 * kMillisecond_ns);
  }
  EXPECT_EQ(rig.link.counts().missed, 10u);
  EXPECT_EQ(rig.link.sample().trips, 0u);
}

TEST(HapiLink, MatchesALateAnswerWithItsMessage) {
  Pushing rig;
  BoardFault fault = rig.fault(Kind::kDelay, 0, kMillisecond_ns);
  fault.delay_ns = 7 * kMillisecond_ns;
  rig.board.add_fault(fault);
  const std::int64_t late_ns = rig.now_ns;
  rig.push(kPush_N, 30 * kMillisecond_ns);
  EXPECT_EQ(rig.link.counts().missed, 1u);
  EXPECT_EQ(rig.link.counts().late, 1u);
  EXPECT_EQ(rig.link.counts().round_trip_longest_ns, 7'300'000);
  EXPECT_EQ(rig.link.sample().trips, 0u);
  // Each answer belongs to its own message again: the newest sample has the time of the newest
  // message that the board has answered.
  const auto commands = rig.commands_since(late_ns);
  const std::uint64_t in_flight = rig.link.counts().messages - rig.link.counts().answers;
  ASSERT_LE(in_flight, 1u);
  EXPECT_EQ(rig.link.sample().time_ns, commands[commands.size() - 1 - in_flight].time_ns);
}

// A sample's time is that of a message which the board had not read before that time.
TEST(HapiLink, NoSampleClaimsToBeNewerThanItIs) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    test::Random random(seed);
    Pushing rig;
    for (int n = 0; n < 6; ++n) {
      const auto kind = random.index(2) == 0 ? Kind::kSilence : Kind::kDelay;
      BoardFault fault =
          rig.fault(kind, static_cast<std::int64_t>(random.index(300)) * kMillisecond_ns,
                    static_cast<std::int64_t>(1 + random.index(3)) * kMillisecond_ns);
      fault.delay_ns = static_cast<std::int64_t>(random.index(9'000)) * 1'000;
      rig.board.add_fault(fault);
    }
    // The hand moves, so that angles tell the time of sampling.
    rig.board.set_hand({0.03, 0.09});
    std::uint64_t last = 0;
    for (int n = 0; n < 8'000; ++n, rig.now_ns += HapiRig::kStep_ns) {
      if (n % 20 == 0) rig.link.set_force({{kPush_N.x(), kPush_N.y()}, rig.now_ns});
      rig.step();
      const HapiSample& sample = rig.link.sample();
      if (sample.sequence == last) continue;
      last = sample.sequence;
      // Some command of the log, not before the stated time, had this pose.
      bool is_true = false;
      for (const BoardCommand& command : rig.commands_since(sample.time_ns)) {
        const auto pose = hapi_pose(FiveBar(FiveBarLinks{}), command.answered_deg);
        is_true = is_true || (pose && pose->tip_m == Vec2(sample.tip_m.data()));
      }
      ASSERT_TRUE(is_true) << "seed " << seed << ", sample " << sample.sequence;
    }
  }
}

TEST(HapiLink, ThreeMissingAnswersInARowTrip) {
  for (int lost = 1; lost <= 4; ++lost) {
    Pushing rig;
    // Messages go out after 0, 5, 10, 15 ms.
    rig.board.add_fault(rig.fault(Kind::kSilence, 0, (5 * lost - 4) * kMillisecond_ns));
    rig.push(kPush_N, 100 * kMillisecond_ns);
    EXPECT_EQ(rig.link.sample().trips, lost >= 3 ? 1u : 0u) << lost;
    EXPECT_TRUE(rig.link.sample().is_working);
    EXPECT_EQ(rig.link.counts().set_ups, lost >= 3 ? 2u : 1u);
    if (lost >= 3) {
      EXPECT_EQ(rig.link.sample().problem, HapiProblem::kNoAnswers);
    }
  }
}

TEST(HapiLink, ABoardThatIsAlwaysLateTrips) {
  Pushing rig;
  BoardFault fault = rig.fault(Kind::kDelay, 0, 1'000 * kMillisecond_ns);
  fault.delay_ns = 6 * kMillisecond_ns;
  rig.board.add_fault(fault);
  rig.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_GE(rig.link.sample().trips, 1u);
  EXPECT_TRUE(is_zero(rig.board.log().back()));
}

TEST(HapiLink, CommandsZeroAfterATripUntilATickCommandsZero) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kSilence, 0, 12 * kMillisecond_ns));
  const std::int64_t fault_ns = rig.now_ns;
  // The haptic thread goes on as if nothing had happened.
  rig.push(kPush_N, 200 * kMillisecond_ns);
  ASSERT_EQ(rig.link.sample().trips, 1u);
  ASSERT_TRUE(rig.link.sample().is_working);
  EXPECT_TRUE(all_zero(rig.commands_since(fault_ns + 15 * kMillisecond_ns)));
  // It notices the trip, and later pushes again.
  const std::int64_t rearmed_ns = rig.now_ns;
  rig.push(Vec2::Zero(), 2 * kMillisecond_ns);
  rig.push(kPush_N, 10 * kMillisecond_ns);
  EXPECT_FALSE(is_zero(rig.commands_since(rearmed_ns).back()));
}

TEST(HapiLink, ATickBeforeTheTripDoesNotEndTheZero) {
  Pushing rig;
  rig.push(Vec2::Zero(), 5 * kMillisecond_ns);  // in free space
  const HapiForce old{{0.0, 0.0}, rig.now_ns - kMillisecond_ns};
  rig.guard.epoch = 1;
  const std::int64_t trip_ns = rig.now_ns;
  rig.step();
  rig.now_ns += HapiRig::kStep_ns;
  rig.link.set_force(old);  // the mailbox still has it
  rig.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_TRUE(rig.link.sample().is_working);
  EXPECT_TRUE(all_zero(rig.commands_since(trip_ns)));
}

TEST(HapiLink, CommandsZeroUntilTheBoardHasAnsweredAgain) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kSilence, 0, 100 * kMillisecond_ns));
  const std::int64_t fault_ns = rig.now_ns;
  rig.push(kPush_N, 30 * kMillisecond_ns);
  ASSERT_EQ(rig.link.sample().trips, 1u);
  rig.push(Vec2::Zero(), 2 * kMillisecond_ns);
  rig.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_TRUE(rig.link.sample().is_working);
  for (const BoardCommand& command : rig.commands_since(fault_ns + 15 * kMillisecond_ns)) {
    if (command.time_ns < fault_ns + 100 * kMillisecond_ns) {
      EXPECT_TRUE(is_zero(command));
    }
  }
}

// A torque that one byte of an answer garbles: found, drained and counted.
TEST(HapiLink, FindsALostByteSetsUpAgainAndKeepsTheAngles) {
  for (std::size_t byte = 0; byte < kHapiAnswerSize; ++byte) {
    Pushing rig;
    rig.board.set_hand({0.02, 0.05});
    rig.push(kPush_N, 300 * kMillisecond_ns);  // away from the rest pose, and at rest there
    const Vec2 before_m = rig.board.plant().tip_m();
    BoardFault fault = rig.fault(Kind::kSwallow, 0, kMillisecond_ns);
    fault.byte = byte;
    rig.board.add_fault(fault);
    rig.push(kPush_N, 100 * kMillisecond_ns);
    const HapiCounts counts = rig.link.counts();
    EXPECT_GE(counts.malformed, 1u) << "byte " << byte;
    EXPECT_LE(counts.malformed, 2u) << "byte " << byte;
    EXPECT_EQ(counts.set_ups, 1u + counts.malformed);
    EXPECT_TRUE(rig.link.sample().is_working);
    EXPECT_EQ(rig.link.sample().trips, 0u);
    // The driver's angles are the true ones, within what the hand moved during the drain.
    const Vec2 read_m(rig.link.sample().tip_m.data());
    const Vec2 true_m = rig.board.plant().tip_m();
    EXPECT_GT((before_m - FiveBar(FiveBarLinks{}).forward({std::acos(-1.0), 0.0}).value()).norm(),
              5e-3);
    EXPECT_LE((read_m - true_m).norm(), 2.0 * (true_m - before_m).norm() + 1e-4);
  }
}

// A set-up states the present angles, and the hand does not wait for it.
TEST(HapiLink, KeepsTheAnglesOfAHandThatMovesWhileItDrains) {
  Pushing rig;
  rig.board.set_hand({0.02, 0.05});
  rig.push(kPush_N, 300 * kMillisecond_ns);
  rig.board.set_hand({-0.01, 0.07});
  rig.push(kPush_N, 40 * kMillisecond_ns);  // on its way
  rig.board.add_fault(rig.fault(Kind::kCorrupt, 0, kMillisecond_ns));
  const Vec2 before_m = rig.board.plant().tip_m();
  rig.push(kPush_N, 20 * kMillisecond_ns);
  EXPECT_EQ(rig.link.counts().malformed, 1u);
  EXPECT_EQ(rig.board.set_ups(), 2u);
  const double moved_m = (rig.board.plant().tip_m() - before_m).norm();
  EXPECT_GT(moved_m, 5e-3);
  rig.push(Vec2::Zero(), 1'000 * kMillisecond_ns);  // at rest
  const Vec2 read_m(rig.link.sample().tip_m.data());
  // What it moves during an answer of 0.3 ms and a few steps of 0.05 ms, at the mean speed of these
  // 20 ms or twice that; and the steps of the encoders.
  EXPECT_LE((read_m - rig.board.plant().tip_m()).norm(), 2.0 * 0.5 / 20.0 * moved_m + 1e-4);
}

// A rig at rest away from the rest pose, with one malformed answer every 200 ms.
struct Draining : Pushing {
  explicit Draining(int drains) {
    board.set_hand({0.02, 0.05});
    push(kPush_N, 1'000 * kMillisecond_ns);
    for (int n = 0; n < drains; ++n) {
      if (n > 0) push(kPush_N, 200 * kMillisecond_ns);
      board.add_fault(fault(Kind::kCorrupt, 0, kMillisecond_ns));
      drain_ns = now_ns;
    }
  }
  std::int64_t drain_ns = 0;  // of the last malformed answer
};

// Without two good answers to the questions, the last good angles count. Each question in turn gets
// no answer, or one that is wrong by 16 to 64 degrees, also in a second drain.
TEST(HapiLink, SetsUpWithTheLastGoodAnglesIfTheBoardDoesNotSayItsAngles) {
  for (const int drains : {1, 2}) {
    for (const std::size_t question : {2u, 3u}) {  // after the malformed answer's message and zero
      Draining without(drains);
      without.push(kPush_N, 100 * kMillisecond_ns);
      const std::int64_t asked_ns = without.commands_since(without.drain_ns)[question].time_ns;
      for (const Kind kind : {Kind::kSilence, Kind::kCorrupt}) {
        Draining rig(drains);
        BoardFault fault = rig.fault(kind, asked_ns - rig.now_ns, 1);
        fault.byte = 3;
        fault.mask = 0x20;
        rig.board.add_fault(fault);
        rig.push(kPush_N, 100 * kMillisecond_ns);
        EXPECT_EQ(rig.link.counts().malformed, static_cast<std::uint64_t>(drains));
        EXPECT_TRUE(rig.link.sample().is_working);
        const Vec2 read_m(rig.link.sample().tip_m.data());
        EXPECT_LE((read_m - rig.board.plant().tip_m()).norm(), 1e-3)
            << "question " << question << ", drain " << drains << ", kind "
            << static_cast<int>(kind);
      }
    }
  }
}

// Found by fuzz_hapi_link: what the line brings before it has taken the whole question is no
// answer. The message that would follow it cut the question, and the board read on in the wrong
// place.
TEST(HapiLink, NeverCutsAQuestionThatTheLineTakesSlowly) {
  for (std::size_t taken = 1; taken < kHapiTickSize; ++taken) {
    for (const bool is_well_formed : {true, false}) {
      HapiRig rig;
      rig.run_until_working();
      const std::vector<std::uint8_t> wrong = {0};
      rig.link.receive(wrong, rig.now_ns);
      rig.step();  // it drains, and asks when the line was quiet
      while (rig.link.counts().set_ups < 2 && rig.link.to_send().empty()) {
        rig.most_bytes = rig.now_ns < rig.link.wake_ns() ? 64 : taken;
        rig.step();
        rig.now_ns += HapiRig::kStep_ns;
      }
      ASSERT_EQ(rig.link.to_send().size(), kHapiTickSize - taken);
      const auto answer = rig.board.firmware().answer({180.0, 0.0, 0.0, 0.0});
      rig.link.receive(is_well_formed ? answer : wrong, rig.now_ns);
      rig.most_bytes = 64;
      rig.run(100 * kMillisecond_ns);
      EXPECT_TRUE(rig.link.sample().is_working) << taken;
      EXPECT_EQ(rig.link.counts().missed, 0u) << taken;
      EXPECT_EQ(rig.board.set_ups(), 2u) << taken;
      EXPECT_TRUE(all_zero(rig.board.log())) << taken;
    }
  }
}

TEST(HapiLink, FindsAWrongDeviceByteAndAJumpAtOnce) {
  for (const std::size_t byte : {std::size_t{0}, std::size_t{4}, std::size_t{8}}) {
    Pushing rig;
    BoardFault fault = rig.fault(Kind::kCorrupt, 0, kMillisecond_ns);
    fault.byte = byte;
    fault.mask = 0x10;  // in an angle's last byte: its exponent
    rig.board.add_fault(fault);
    rig.push(kPush_N, 5 * kMillisecond_ns);
    EXPECT_EQ(rig.link.counts().malformed, byte == 0 || byte == 4 ? 1u : 0u) << byte;
    rig.push(kPush_N, 45 * kMillisecond_ns);
    EXPECT_EQ(rig.link.sample().trips, 0u);
    EXPECT_TRUE(rig.link.sample().is_working);
  }
}

// The first angle is about 180 degrees, of 0x43 in its last byte: 0x42 is 45 to 90 degrees less,
// and a change of the third byte is 1 to 64 degrees.
TEST(HapiLink, FindsAnAngleThatTurnsFasterThanAHand) {
  for (const auto& [byte, mask] : {std::pair<std::size_t, int>{4, 0x01}, {3, 0x20}, {3, 0x10}}) {
    Pushing rig;
    rig.board.set_hand({0.02, 0.05});
    rig.push(kPush_N, 300 * kMillisecond_ns);
    BoardFault fault = rig.fault(Kind::kCorrupt, 0, kMillisecond_ns);
    fault.byte = byte;
    fault.mask = static_cast<std::uint8_t>(mask);
    rig.board.add_fault(fault);
    Vec2 last_m(rig.link.sample().tip_m.data());
    double longest_m = 0.0;  // between two ticks
    rig.run(100 * kMillisecond_ns, [&] {
      rig.link.set_force({{kPush_N.x(), kPush_N.y()}, rig.now_ns});
      const Vec2 tip_m(rig.link.sample().tip_m.data());
      longest_m = std::max(longest_m, (tip_m - last_m).norm());
      last_m = tip_m;
    });
    EXPECT_LE(longest_m, 1e-3) << "a wrong position was taken";  // the hand is slower than 1 m/s
    EXPECT_EQ(rig.link.counts().malformed, 1u);
    EXPECT_TRUE(rig.link.sample().is_working);
  }
}

TEST(HapiLink, SendsZeroBeforeItDrains) {
  Pushing rig;
  BoardFault fault = rig.fault(Kind::kCorrupt, 0, kMillisecond_ns);
  rig.board.add_fault(fault);
  const std::int64_t fault_ns = rig.now_ns;
  rig.push(kPush_N, 8 * kMillisecond_ns);
  const auto commands = rig.commands_since(fault_ns);
  ASSERT_EQ(commands.size(), 2u);  // the one with the bad answer, and zero; nothing while draining
  EXPECT_TRUE(is_zero(commands[1]));
  EXPECT_LE(commands[1].time_ns - commands[0].time_ns, 350'000);
}

TEST(HapiLink, DrainsUntilTheLineWasQuietForTenMilliseconds) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kCorrupt, 0, kMillisecond_ns));
  // The answer to the zero comes late, in the middle of the drain.
  BoardFault late = rig.fault(Kind::kDelay, 0, 5 * kMillisecond_ns);
  late.delay_ns = 4 * kMillisecond_ns;
  rig.board.add_fault(late);
  const std::int64_t fault_ns = rig.now_ns;
  rig.push(kPush_N, 40 * kMillisecond_ns);
  EXPECT_EQ(rig.link.counts().malformed, 1u);
  const auto commands = rig.commands_since(fault_ns);
  ASSERT_GT(commands.size(), 3u);
  const std::int64_t last_byte_ns = commands[1].time_ns + 4'300'000;
  EXPECT_EQ(commands[2].time_ns, last_byte_ns + 10 * kMillisecond_ns);
  EXPECT_TRUE(is_zero(commands[2]));  // the question for the angles
}

TEST(HapiLink, ForceGrowsByTheSlewAfterADrain) {
  HapiSettings settings = pushing_settings();
  settings.peak_torque_Nm = 10.0;
  Pushing rig(settings);
  rig.push({20.0, 0.0}, 50 * kMillisecond_ns);
  rig.board.add_fault(rig.fault(Kind::kCorrupt, 0, kMillisecond_ns));
  const std::int64_t fault_ns = rig.now_ns;
  rig.push({20.0, 0.0}, 40 * kMillisecond_ns);
  ASSERT_EQ(rig.link.counts().malformed, 1u);
  double last_N = 20.0;
  for (std::size_t k = 1; k < rig.board.log().size(); ++k) {
    const BoardCommand& command = rig.board.log()[k];
    if (command.time_ns < fault_ns) continue;
    const double N = force_N(command, rig.board.log()[k - 1].answered_deg, settings).norm();
    EXPECT_LE(N, last_N + 5.0 + 1e-3) << command.time_ns - fault_ns;
    last_N = N;
  }
  EXPECT_NEAR(last_N, 20.0, 1e-3);
}

TEST(HapiLink, ALineThatBlocksWhileItDrainsTrips) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kCorrupt, 0, kMillisecond_ns));
  rig.push(kPush_N, 500'000);
  rig.most_bytes = 0;
  rig.push(kPush_N, 50 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 0u);
  rig.push(kPush_N, 60 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 1u);
}

TEST(HapiLink, ThreeMalformedAnswersInARowTrip) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kCorrupt, 0, 40 * kMillisecond_ns));
  rig.push(kPush_N, 200 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kBadAnswers);
  EXPECT_GE(rig.link.counts().malformed, 3u);
  EXPECT_TRUE(rig.link.sample().is_working);
  EXPECT_TRUE(is_zero(rig.board.log().back()));
}

TEST(HapiLink, SplitAnswersAreWhole) {
  for (std::size_t byte = 0; byte < kHapiAnswerSize; ++byte) {
    Pushing rig;
    BoardFault fault = rig.fault(Kind::kSplit, 0, 50 * kMillisecond_ns);
    fault.byte = byte;
    fault.delay_ns = 3 * kMillisecond_ns;
    rig.board.add_fault(fault);
    rig.push(kPush_N, 60 * kMillisecond_ns);
    const HapiCounts counts = rig.link.counts();
    EXPECT_EQ(counts.missed + counts.late + counts.malformed, 0u) << byte;
    EXPECT_EQ(counts.round_trip_longest_ns, 3'300'000);
  }
}

TEST(HapiLink, ContinuesACutMessage) {
  for (std::size_t most = 1; most < kHapiTickSize; ++most) {
    Pushing rig;
    rig.most_bytes = most;
    const std::int64_t cut_ns = rig.now_ns;
    rig.push(kPush_N, 100 * kMillisecond_ns);
    EXPECT_EQ(rig.link.counts().malformed + rig.link.counts().missed, 0u) << most;
    const auto commands = rig.commands_since(cut_ns);
    EXPECT_GE(commands.size(), 95u);
    for (const BoardCommand& command : commands) EXPECT_FALSE(is_zero(command));
  }
}

TEST(HapiLink, AMessageThatWaitsIsMadeAnew) {
  Pushing rig;
  rig.most_bytes = 0;
  rig.push(kPush_N, 3 * kMillisecond_ns);
  const std::int64_t free_ns = rig.now_ns;
  rig.most_bytes = 64;
  rig.push(Vec2::Zero(), kMillisecond_ns);
  const auto commands = rig.commands_since(free_ns);
  ASSERT_FALSE(commands.empty());
  EXPECT_TRUE(is_zero(commands.front())) << "an old force was sent";
}

TEST(HapiLink, ALineThatTakesNoBytesTrips) {
  Pushing rig;
  rig.most_bytes = 0;
  rig.push(kPush_N, 30 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_FALSE(rig.link.sample().is_working);
  // Also in the middle of a message; the board then gets the zero bytes.
  Pushing cut;
  cut.most_bytes = 4;
  cut.push(kPush_N, HapiRig::kStep_ns);
  cut.most_bytes = 0;
  cut.push(kPush_N, 30 * kMillisecond_ns);
  EXPECT_EQ(cut.link.sample().trips, 1u);
  const std::int64_t free_ns = cut.now_ns;
  cut.most_bytes = 64;
  cut.push(kPush_N, 100 * kMillisecond_ns);
  EXPECT_TRUE(all_zero(cut.commands_since(free_ns)));
  EXPECT_TRUE(cut.link.sample().is_working);
}

TEST(HapiLink, AHangUpTripsForEver) {
  Pushing rig;
  rig.board.add_fault(rig.fault(Kind::kHangUp, 0, 0));
  rig.push(kPush_N, 50 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kHungUp);
  EXPECT_FALSE(rig.link.sample().is_working);
  EXPECT_TRUE(rig.link.to_send().empty());
  EXPECT_TRUE(rig.link.has_released());
}

TEST(HapiLink, ATripOfTheGuardIsFollowedByZeroASetUpAndAnAcknowledgement) {
  Pushing rig;
  rig.guard.epoch = 3;
  const std::int64_t trip_ns = rig.now_ns;
  rig.push(kPush_N, 9 * kMillisecond_ns);
  EXPECT_EQ(rig.guard.acknowledged, 0u) << "acknowledged before the set-up";
  rig.push(kPush_N, 91 * kMillisecond_ns);
  EXPECT_TRUE(all_zero(rig.commands_since(trip_ns)));
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kGuardTripped);
  EXPECT_EQ(rig.guard.acknowledged, 3u);
  EXPECT_EQ(rig.board.set_ups(), 2u);
  rig.push(Vec2::Zero(), 2 * kMillisecond_ns);
  rig.push(kPush_N, 10 * kMillisecond_ns);
  EXPECT_FALSE(is_zero(rig.board.log().back()));
}

TEST(HapiLink, TellsASuspendedMachineFromASilentProgram) {
  Pushing rig;
  rig.guard.suspended = true;
  rig.guard.epoch = 1;
  rig.push(kPush_N, 10 * kMillisecond_ns);
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kSuspended);
}

TEST(HapiLink, WithAFrozenGuardItCommandsZeroForEver) {
  Pushing rig;
  rig.guard.at_present = GuardState::kFrozen;
  const std::int64_t frozen_ns = rig.now_ns;
  rig.push(kPush_N, 50 * kMillisecond_ns);
  rig.guard.at_present = GuardState::kAlive;  // too late: the run is over
  rig.push(Vec2::Zero(), 2 * kMillisecond_ns);
  rig.push(kPush_N, 50 * kMillisecond_ns);
  EXPECT_TRUE(all_zero(rig.commands_since(frozen_ns)));
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kGuardFrozen);
}

TEST(HapiLink, WithoutALivingGuardItCommandsZeroForEver) {
  Pushing rig;
  rig.guard.at_present = GuardState::kEnded;
  const std::int64_t gone_ns = rig.now_ns;
  rig.push(kPush_N, 50 * kMillisecond_ns);
  rig.push(Vec2::Zero(), 2 * kMillisecond_ns);
  rig.push(kPush_N, 50 * kMillisecond_ns);
  EXPECT_TRUE(all_zero(rig.commands_since(gone_ns)));
  EXPECT_EQ(rig.link.sample().trips, 1u);
  EXPECT_EQ(rig.link.sample().problem, HapiProblem::kGuardGone);
  EXPECT_FALSE(rig.link.sample().is_working);
}

TEST(HapiLink, BeatsAfterEachCommandWithTheTimeOfItsTick) {
  Pushing rig;
  const std::uint64_t beats = rig.guard.beats;
  const std::size_t commands = rig.board.log().size();
  std::int64_t last_ns = 0;
  rig.run(20 * kMillisecond_ns, [&] {
    if (rig.guard.beats > beats) {
      EXPECT_EQ(rig.guard.last_beat_ns, last_ns);
    }
    last_ns = rig.now_ns;
    rig.link.set_force({{kPush_N.x(), kPush_N.y()}, rig.now_ns});
  });
  EXPECT_EQ(rig.guard.beats - beats, rig.board.log().size() - commands);
  // The haptic thread hangs: the beats go on with its last tick.
  rig.run(20 * kMillisecond_ns);
  EXPECT_GT(rig.guard.beats - beats, 30u);
  EXPECT_EQ(rig.guard.last_beat_ns, last_ns);
}

TEST(HapiLink, ReleaseSendsZero) {
  Pushing rig;
  EXPECT_FALSE(rig.link.has_released());
  rig.link.release();
  EXPECT_FALSE(rig.link.has_released());
  const std::int64_t release_ns = rig.now_ns;
  rig.push(kPush_N, 10 * kMillisecond_ns);
  EXPECT_TRUE(rig.link.has_released());
  EXPECT_TRUE(all_zero(rig.commands_since(release_ns)));
}

TEST(HapiLink, SameFaultsGiveTheSameCommands) {
  const auto log = [] {
    Pushing rig;
    rig.board.add_fault(rig.fault(Kind::kSilence, 5 * kMillisecond_ns, 12 * kMillisecond_ns));
    rig.board.add_fault(rig.fault(Kind::kCorrupt, 60 * kMillisecond_ns, 3 * kMillisecond_ns));
    rig.push(kPush_N, 200 * kMillisecond_ns);
    return rig.board.log();
  };
  const auto first = log();
  const auto second = log();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].time_ns, second[k].time_ns);
    EXPECT_EQ(first[k].torques, second[k].torques);
    EXPECT_EQ(first[k].answered_deg, second[k].answered_deg);
  }
}

}  // namespace
}  // namespace palpate
