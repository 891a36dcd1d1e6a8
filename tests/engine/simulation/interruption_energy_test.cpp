// After an interruption or a sudden change, the motors give back no more than was in the spring
// before it, and a budget: by the account of the plant, whatever the engine counts.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "engine/devices/stiffness_zones.h"
#include "engine/session/live_setting.h"
#include "engine/simulation/calm_chart.h"
#include "engine/simulation/port_loop.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kBudget_J = 5e-3;
constexpr double kSettle_s = 1.0;  // of the hand, before the interruption and after it

// A tip of 0.1 kg in a light grip, at a wall of 1,000 N/m on a device that holds it: 2 N s/m and
// 0.5 ms give a stable limit of 2,000 N/m.
PortLoopSettings leaning(double peak_force_N) {
  PortLoopSettings settings;
  settings.device.device = motor_device(2, peak_force_N, 1000.0);
  settings.device.tip.damping_Ns_per_m = 2.0;
  settings.device.tip.hand = kLightGrip;
  settings.device.device.mass_kg = settings.device.tip.mass_kg;
  settings.device.device.damping_Ns_per_m = settings.device.tip.damping_Ns_per_m;
  settings.device.device.delay = {0.4e-3, 0.5e-3};
  settings.device.delay_s = 0.5e-3;
  settings.device.start_m = {2e-3, 0.0, 0.0};
  return settings;
}

// Moves the body, or sets the stiffness, before the next tick.
class Change final : public BeforeTick {
 public:
  void before_tick(double, LoopChanges loop) noexcept override {
    if (is_due) change(loop);
    is_due = false;
  }
  std::function<void(LoopChanges)> change;
  bool is_due = false;
};

struct Given {
  double stored_J = 0.0;
  double given_J = 0.0;  // the most that the motors gave since the interruption began
  double most_m = 0.0;   // how far the tip was from the place where the hand rested
  double rest_m = 0.0;   // the way of the tip in the last quarter of a second
  TripReason trip = TripReason::kNone;
};

// The hand presses with push_N at its rest; `interrupt` does something and runs ticks; then the
// hand settles again.
Given given_after(PortLoop& loop, double push_N, const std::function<void()>& interrupt) {
  loop.run(0.75);  // the governor's start
  const double grip = kLightGrip.stiffness_N_per_m;
  const double stiffness = loop.rig().loop().settings().coupling.stiffness_N_per_m;
  const double end_m = -push_N / grip - push_N / stiffness;
  const double start_m = loop.tip().position_m().x();
  constexpr double kApproach_s = 0.5;
  loop.tip().set_hand({start_m, 0.0, 0.0}, {(end_m - start_m) / kApproach_s, 0.0, 0.0});
  loop.run(kApproach_s);
  loop.tip().set_hand({end_m, 0.0, 0.0});
  loop.run(kSettle_s);
  Given given;
  const Vec3 rest_m = loop.tip().position_m();
  given.stored_J = 0.5 * stiffness * rest_m.x() * rest_m.x();
  loop.tip().open_account();
  interrupt();
  for (int n = 0; n < std::lround(kSettle_s / loop.dt_s()); ++n) {
    loop.tick();
    given.most_m = std::max(given.most_m, (loop.tip().position_m() - rest_m).norm());
  }
  given.given_J = loop.tip().account().most_given_J;
  const double before_m = loop.tip().position_m().x();
  loop.run(0.25);
  given.rest_m = std::abs(loop.tip().position_m().x() - before_m);
  given.trip = loop.trip().reason;
  return given;
}

void expect_at_most_the_stored_energy(const std::string& what, const Given& given) {
  std::printf("%-52s stored %5.1f mJ, given %6.1f mJ, tip moved %5.1f mm%s%s\n", what.c_str(),
              1e3 * given.stored_J, 1e3 * given.given_J, 1e3 * given.most_m,
              given.trip == TripReason::kNone ? "" : ", trip ",
              given.trip == TripReason::kNone
                  ? ""
                  : kTripReasonNames[static_cast<std::size_t>(given.trip)].data());
  EXPECT_GT(given.stored_J, 1e-3) << "the hand does not press: " << what;
  EXPECT_LE(given.given_J, given.stored_J + kBudget_J) << what;
}

std::string named(const char* what, double number, const char* unit, double push_N) {
  return std::string(what) + " " + std::to_string(number).substr(0, 5) + " " + unit + ", pressed " +
         std::to_string(push_N).substr(0, 4) + " N";
}

// ---- interruptions ------------------------------------------------------------------------------

TEST(InterruptionEnergy, AStallOfTheSamplesGivesNoMoreThanWasStored) {
  Random random(61);
  std::cout << "seed " << random.seed() << "\n";
  for (const double stall_ms : {12.0, 20.0, 35.0, 50.0, 70.0, 90.0}) {
    const double push_N = random.uniform(4.5, 7.0);
    const auto loop = test::made(PortLoop::create(leaning(10.0)));
    const Given given = given_after(*loop, push_N, [&] {
      const double now_s = loop->device().time_s();
      loop->device().lose_samples({now_s, now_s + 1e-3 * stall_ms});
    });
    expect_at_most_the_stored_energy(named("stall of", stall_ms, "ms", push_N), given);
  }
}

// The line loses messages to the board and answers, half and half. A board that gets no message
// does not answer it: then both the command and the sample are lost.
TEST(InterruptionEnergy, LostBytesGiveNoMoreThanWasStored) {
  Random random(62);
  std::cout << "seed " << random.seed() << "\n";
  for (const double share : {0.1, 0.3, 0.5}) {
    const double push_N = random.uniform(4.5, 7.0);
    const auto loop = test::made(PortLoop::create(leaning(10.0)));
    const Given given = given_after(*loop, push_N, [&] {
      for (int n = 0; n < 300; ++n) {
        const double now_s = loop->device().time_s();
        const TimeSpan span{now_s, now_s + 1.5 * loop->dt_s()};
        const bool is_lost = random.uniform(0.0, 1.0) < share;
        const bool is_message = is_lost && random.index(2) == 0;
        loop->device().lose_samples(is_lost ? span : TimeSpan{});
        loop->device().lose_commands(is_message ? span : TimeSpan{});
        loop->tick();
      }
      loop->device().lose_samples({});
      loop->device().lose_commands({});
    });
    expect_at_most_the_stored_energy(named("bytes lost:", share, "of all", push_N), given);
  }
}

TEST(InterruptionEnergy, APauseGivesNoMoreThanWasStored) {
  for (const double pause_ms : {15.0, 60.0, 300.0}) {
    const auto loop = test::made(PortLoop::create(leaning(10.0)));
    const Given given = given_after(*loop, 6.0, [&] {
      loop->rig().session().set_paused(true);
      loop->run(1e-3 * pause_ms);
      loop->rig().session().set_paused(false);
    });
    expect_at_most_the_stored_energy(named("pause of", pause_ms, "ms", 6.0), given);
  }
}

// The motors hold their force while the host is late, and the hand stays.
TEST(InterruptionEnergy, ALateTickGivesNoMoreThanWasStored) {
  for (const double late_ms : {15.0, 25.0, 45.0, 80.0}) {
    const auto loop = test::made(PortLoop::create(leaning(10.0)));
    const Given given = given_after(*loop, 6.0, [&] { loop->tick_late(1e-3 * late_ms); });
    expect_at_most_the_stored_energy(named("late by", late_ms, "ms", 6.0), given);
  }
}

// ---- sudden changes -----------------------------------------------------------------------------

TEST(InterruptionEnergy, AJumpOfANodeGivesNoMoreThanWasStored) {
  for (const double peak_N : {10.0, 20.0}) {
    for (const double jump_mm : {2.0, 5.0, 10.0, 20.0}) {
      Change change;
      const auto loop = test::made(PortLoop::create(leaning(peak_N), {&change}));
      change.change = [&](LoopChanges changes) {
        RigidTransform T_scene_body = changes.loop().T_scene_body(0);
        T_scene_body.translation_m.x() += 1e-3 * jump_mm;
        changes.move_body(0, T_scene_body);
      };
      const Given given = given_after(*loop, 5.0, [&] { change.is_due = true; });
      expect_at_most_the_stored_energy(
          std::to_string(static_cast<int>(peak_N)) + " N: " + named("jump of", jump_mm, "mm", 5.0),
          given);
    }
  }
}

TEST(InterruptionEnergy, AStepOfTheStiffnessGivesNoMoreThanWasStored) {
  for (const double peak_N : {10.0, 20.0}) {
    for (const double before : {150.0, 300.0, 500.0}) {
      Change change;
      PortLoopSettings settings = leaning(peak_N);
      settings.coupling.stiffness_N_per_m = before;
      const auto loop = test::made(PortLoop::create(settings, {&change}));
      change.change = [](LoopChanges changes) { changes.set(live_setting("stiffness"), 1500.0); };
      const Given given = given_after(*loop, 5.0, [&] { change.is_due = true; });
      ASSERT_EQ(loop->rig().loop().settings().coupling.stiffness_N_per_m, 1500.0);
      expect_at_most_the_stored_energy(std::to_string(static_cast<int>(peak_N)) + " N: " +
                                           named("step to 1500 N/m from", before, "N/m", 5.0),
                                       given);
    }
  }
}

// ---- the engine's own count ---------------------------------------------------------------------

// Where the delay is known and whole ticks long, the engine can know the work exactly.
TEST(InterruptionEnergy, ThePrintedEnergyIsThatOfThePlant) {
  Random random(63);
  std::cout << "seed " << random.seed() << "\n";
  for (int ticks = 0; ticks <= 4; ++ticks) {
    PortLoopSettings settings = leaning(10.0);
    settings.coupling.stiffness_N_per_m = 300.0;
    settings.device.delay_s = 1e-3 * ticks;
    // No delay at all cannot be told from an unknown one.
    const double stated_s = std::max(settings.device.delay_s, 1e-12);
    settings.device.device.delay = {stated_s, stated_s};
    const auto loop = test::made(PortLoop::create(settings));
    double moved_J = 0.0;
    double last_J = 0.0;
    for (int n = 0; n < 5000; ++n) {
      if (n % 200 == 199) {
        loop->tip().set_hand({random.uniform(-0.04, 0.01), random.uniform(-0.02, 0.02), 0.0});
      }
      loop->tick();
      moved_J += std::abs(loop->tip().account().motors_J - last_J);
      last_J = loop->tip().account().motors_J;
    }
    EXPECT_GT(moved_J, 0.01);
    EXPECT_NEAR(loop->governor().given_J, last_J, 1e-9 * moved_J) << ticks << " ticks";
  }
}

// ---- the default of a run on a device -----------------------------------------------------------

// A hAPI board knows neither its mass nor its damping; the stiffness is the one of --stiffness
// auto.
TEST(InterruptionEnergy, TheDefaultStiffnessComesToRestWithEveryGrip) {
  for (const double delay_ms : {0.2, 1.0, 3.0}) {
    for (const ChartGrip grip : {ChartGrip::kBare, ChartGrip::kLight, ChartGrip::kFirm}) {
      for (const PortShape shape : {PortShape::kWall, PortShape::kGroove}) {
        for (const ChartContact contact : {ChartContact::kThrown, ChartContact::kPressed}) {
          ChartCase chart_case{.shape = shape, .grip = grip, .contact = contact};
          chart_case.delay_s = 1e-3 * delay_ms;
          DeviceDescription device = motor_device(2, 10.0, 1000.0);
          device.delay = {0.9 * chart_case.delay_s, chart_case.delay_s};
          chart_case.stiffness_N_per_m =
              test::made(stiffness_zones(device, 0.0, 1e-3)).auto_N_per_m;
          const ChartResult result = test::made(run_chart_case(chart_case));
          EXPECT_EQ(result.outcome, ChartOutcome::kStable)
              << delay_ms << " ms, " << name_of(grip) << ", " << name_of(shape) << ", "
              << name_of(contact);
        }
      }
    }
  }
}

}  // namespace
}  // namespace palpate
