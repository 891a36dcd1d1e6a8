// Governor, driver's link and simulated board, joined by buffers in virtual time, under random
// schedules of faults. The board's log is the judge.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/hapi_view.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"
#include "tests/engine/devices/hapi_rig.h"
#include "tests/helpers/random.h"
#include "tests/helpers/sanitizers.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::HapiRig;
using test::is_zero;
using test::kMillisecond_ns;
using test::Random;
using Kind = BoardFault::Kind;

constexpr double kClamp_N = 12.0;  // the slew needs several ticks for it
constexpr double kWall_N_per_m = 1'000.0;
constexpr int kTicks = 3'400;      // of a schedule
constexpr int kFirstFault = 850;   // when the force has its full size
constexpr int kLastFault = 1'350;  // after one swing into the wall
constexpr std::int64_t kRigStep_ns = 200'000;
constexpr double kWall_m = 0.05;  // y, in the frame of the linkage
// Torques are rounded to single precision; the force has that error times the condition.
constexpr double kRounding = 1.0 + kNoForceCondition * std::numeric_limits<float>::epsilon();

HapiSettings schedule_settings() {
  HapiSettings settings;
  settings.torque_per_Nm = 2.0;
  settings.peak_torque_Nm = 3.0;  // the clamp counts, not the peak
  return settings;
}

// A stretch of time in which the governor has tripped, or waits before its start ramp.
struct Stretch {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
  bool is_gentle = false;  // a trip after which the force may fall (GentleRelease)
};

// A hand that presses a wall, through the governor and the driver, with faults.
class Schedule {
 public:
  explicit Schedule(std::uint64_t seed)
      : random_(seed),
        view_(schedule_settings()),
        governor_(view_.description(), SafetyGovernor::clamp_of(view_.description(), kClamp_N)),
        rig_(schedule_settings(), board_settings(), kRigStep_ns) {
    rig_.run_until_working();
    first_ns_ = rig_.now_ns;
    draw_faults();
  }

  void run() {
    for (int tick = 0; tick < kTicks; ++tick) {
      set_hand(tick);
      rig_.most_bytes = is_within(tick, block_) ? block_bytes_ : 64;
      if (tick == guard_trip_) ++rig_.guard.epoch;
      if (!is_within(tick, pause_)) run_tick(tick);
      rig_.run(kMillisecond_ns);
    }
  }

  bool has_hung_up() const { return rig_.board.has_hung_up(rig_.now_ns); }
  bool is_working() const { return rig_.link.sample().is_working; }
  const std::vector<BoardCommand>& log() const { return rig_.board.log(); }
  const std::vector<Stretch>& tripped() const { return tripped_; }
  const std::vector<Stretch>& waited() const { return waited_; }
  const GovernorStatus& status() const { return governor_.status(); }
  std::int64_t first_ns() const { return first_ns_; }
  std::int64_t now_ns() const { return rig_.now_ns; }
  HapiCounts counts() const { return rig_.link.counts(); }

 private:
  struct Ticks {
    int from = -1;
    int to = -1;
  };
  static bool is_within(int tick, const Ticks& ticks) {
    return tick >= ticks.from && tick < ticks.to;
  }
  static BoardSettings board_settings() {
    BoardSettings board;
    board.torque_per_Nm = 2.0;
    board.largest_torque = 6.0;
    return board;
  }

  std::int64_t a_time_ns(std::uint64_t most_us) {
    return static_cast<std::int64_t>(random_.index(most_us)) * 1'000;
  }
  Ticks some_ticks(std::uint64_t longest) {
    const int from = kFirstFault + static_cast<int>(random_.index(kLastFault - kFirstFault));
    return {from, from + 1 + static_cast<int>(random_.index(longest))};
  }

  void draw_faults() {
    const std::uint64_t faults = 1 + random_.index(5);
    for (std::uint64_t n = 0; n < faults; ++n) {
      const std::uint64_t kind = random_.index(9);
      const Ticks when = some_ticks(random_.index(2) == 0 ? 3 : 60);
      if (kind < 5) {
        BoardFault fault;
        fault.kind = static_cast<Kind>(kind);
        fault.from_ns = first_ns_ + when.from * kMillisecond_ns + a_time_ns(1'000);
        fault.until_ns = fault.from_ns + (when.to - when.from) * kMillisecond_ns;
        fault.delay_ns = a_time_ns(15'000);
        fault.byte = random_.index(kHapiAnswerSize);
        if (fault.kind == Kind::kCorrupt) {
          // The protocol has no checksum: only a wrong device byte or a jump can be found.
          fault.byte = random_.index(2) == 0 ? 0 : 4;
          fault.mask = 0x10;
        }
        rig_.board.add_fault(fault);
      } else if (kind == 5) {
        block_ = when;
        block_bytes_ = random_.index(kHapiTickSize);
      } else if (kind == 6) {
        pause_ = when;
      } else if (kind == 7) {
        guard_trip_ = when.from;
      } else if (random_.index(4) == 0) {
        BoardFault fault;
        fault.kind = Kind::kHangUp;
        fault.from_ns = first_ns_ + when.from * kMillisecond_ns;
        rig_.board.add_fault(fault);
      }
    }
  }

  // The hand waits in free space until the force has grown, and then swings into the wall and out.
  void set_hand(int tick) {
    const double swing_s = std::max(0.0, 1e-3 * (tick - kFirstFault + 50));
    const double y_m = kWall_m - 0.005 + 0.03 * std::sin(5.0 * swing_s);
    rig_.board.set_hand({0.01 + 0.01 * std::sin(3.0 * swing_s), y_m});
  }

  void run_tick(int tick) {
    const std::int64_t late_ns = last_tick_ < 0 ? 0 : (tick - last_tick_ - 1) * kMillisecond_ns;
    last_tick_ = tick;
    const DeviceSample sample =
        governor_.begin_tick(view_.take(rig_.link.sample()), {1e-3, late_ns, rig_.now_ns});
    governor_.set_motors(view_.motors());
    TickRecord record;
    record.tick = static_cast<std::uint64_t>(tick);
    std::copy_n(sample.position_m.begin(), 3, record.device_m);
    if (!sample.is_valid) record.faults |= kFaultInvalidSample;
    // The frame of the linkage has its origin at the first motor.
    const double depth_m = rig_.link.sample().tip_m[1] - kWall_m;
    record.contact = depth_m > 0.0;
    if (depth_m > 0.0) {
      Vec3 force_N = kWall_N_per_m * depth_m * Vec3(0.1, -1.0, 0.0);
      // The wall has knocks in any direction, so that clamp and slew have to act.
      if (tick % 40 < 6) force_N += 20.0 * Vec3(std::cos(tick / 40), std::sin(tick / 40), 0.0);
      put(force_N, record.force_device_N);
    }
    const GovernorState before = governor_.status().state;
    maybe_rearm();
    governor_.govern(record);
    note(before, governor_.status().state);
    rig_.link.set_force({{record.force_device_N[0], record.force_device_N[1]}, rig_.now_ns});
  }

  void maybe_rearm() {
    if (governor_.status().state != GovernorState::kTripped || !is_working()) return;
    if (random_.index(50) == 0) governor_.rearm();
  }

  void note(GovernorState before, GovernorState after) {
    if (after == GovernorState::kTripped) {
      if (before != GovernorState::kTripped) {
        const TripReason reason = governor_.status().trip.reason;
        const bool is_gentle = reason == TripReason::kSpeed || reason == TripReason::kUnstable;
        tripped_.push_back({rig_.now_ns, rig_.now_ns, is_gentle});
      }
      tripped_.back().to_ns = rig_.now_ns + kMillisecond_ns;
    }
    if (before == GovernorState::kWaits && after == GovernorState::kStarts) {
      waited_.push_back({rig_.now_ns - 100 * kMillisecond_ns, rig_.now_ns});
    }
  }

  Random random_;
  HapiView view_;
  SafetyGovernor governor_;
  HapiRig rig_;
  std::int64_t first_ns_ = 0;
  Ticks block_, pause_;
  std::size_t block_bytes_ = 64;
  int guard_trip_ = -1;
  int last_tick_ = -1;
  std::vector<Stretch> tripped_;
  std::vector<Stretch> waited_;
};

// The least and the largest length of a command's force in any of the poses that the board has
// answered shortly before; the driver has used one of them.
struct ForceRange {
  double least_N = std::numeric_limits<double>::infinity();
  double most_N = 0.0;
};

ForceRange force_range(const std::vector<BoardCommand>& log, std::size_t k) {
  ForceRange range;
  if (is_zero(log[k])) return {0.0, 0.0};
  for (std::size_t back = 1; back <= std::min<std::size_t>(k, 4); ++back) {
    const double length_N =
        test::force_N(log[k], log[k - back].answered_deg, schedule_settings()).norm();
    range.least_N = std::min(range.least_N, length_N);
    range.most_N = std::max(range.most_N, length_N);
  }
  return range;
}

// largest_N: becomes the largest force if that is larger.
void judge_forces(const std::vector<BoardCommand>& log, double& largest_N) {
  double last_N = 0.0;
  for (std::size_t k = 1; k < log.size(); ++k) {
    const ForceRange force = force_range(log, k);
    ASSERT_LE(force.least_N, kClamp_N * kRounding) << "above the clamp: command " << k;
    const double since_s = 1e-9 * static_cast<double>(log[k].time_ns - log[k - 1].time_ns);
    ASSERT_LE(force.least_N,
              last_N + GovernorLimits::kSlew_N_per_s * since_s + kClamp_N * (kRounding - 1.0))
        << "above the slew: command " << k;
    last_N = force.most_N;
    largest_N = std::max(largest_N, force.least_N);
  }
}

void judge_zero(const Schedule& schedule) {
  for (const Stretch& stretch : schedule.tripped()) {
    int slipped = 0;
    for (const BoardCommand& command : schedule.log()) {
      if (command.time_ns <= stretch.from_ns || command.time_ns > stretch.to_ns) continue;
      if (is_zero(command)) continue;
      ++slipped;
      // A message that was cut when the governor tripped must be completed.
      const std::int64_t fall_ns = stretch.is_gentle ? GentleReleaseLimits::kFall_ns : 0;
      ASSERT_LE(command.time_ns - stretch.from_ns, HapiLink::kAnswer_ns + fall_ns)
          << "a force after a trip";
    }
    if (!stretch.is_gentle) {
      ASSERT_LE(slipped, 1) << "a force after a trip";
    }
  }
  for (const Stretch& stretch : schedule.waited()) {
    for (const BoardCommand& command : schedule.log()) {
      // The message of a force that ended with the rearm must be completed.
      const bool is_in = command.time_ns > stretch.from_ns + HapiLink::kAnswer_ns &&
                         command.time_ns <= stretch.to_ns;
      ASSERT_TRUE(!is_in || is_zero(command)) << "a force before a start";
    }
  }
}

bool has_force(const Schedule& schedule, std::int64_t from_ns, std::int64_t to_ns) {
  return std::any_of(schedule.log().begin(), schedule.log().end(), [&](const auto& command) {
    return command.time_ns >= from_ns && command.time_ns < to_ns && !is_zero(command);
  });
}

// AddressSanitizer makes a schedule five times slower.
constexpr std::uint64_t kSchedules = test::kHasAddressSanitizer ? 200 : 1'000;

TEST(HapiSchedules, TheBoardNeverGetsWhatTheRulesForbid) {
  const std::uint64_t count = test::in_soak_or_else<std::uint64_t>(20'000, kSchedules);
  const std::uint64_t first = test::from_environment("PALPATE_FIRST_SCHEDULE", 1);
  double largest_N = 0.0;
  std::uint64_t pushed = 0;
  std::uint64_t tripped = 0;
  std::uint64_t hung_up = 0;
  std::uint64_t returned = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("PALPATE_FIRST_SCHEDULE=" + std::to_string(seed));
    Schedule schedule(seed);
    schedule.run();
    judge_forces(schedule.log(), largest_N);
    judge_zero(schedule);
    if (HasFatalFailure()) return;
    pushed += has_force(schedule, schedule.first_ns(), schedule.now_ns());
    tripped += schedule.status().trips > 0;
    hung_up += schedule.has_hung_up();
    if (schedule.has_hung_up()) {
      ASSERT_FALSE(schedule.is_working());
      ASSERT_EQ(schedule.status().state, GovernorState::kTripped);
      continue;
    }
    ASSERT_TRUE(schedule.is_working()) << "the driver does not recover";
    returned += has_force(schedule, schedule.now_ns() - 1'300 * kMillisecond_ns, schedule.now_ns());
  }
  std::cout << count << " schedules from " << first << ": " << tripped << " with a trip, "
            << hung_up << " with a hang-up, " << returned << " with force at the end\n";
  EXPECT_GT(largest_N, kClamp_N * (2.0 - kRounding)) << "no force has reached the clamp";
  EXPECT_GT(pushed, count - count / 20) << "too little to judge";
  EXPECT_GT(tripped, count / 4);
  EXPECT_GT(hung_up, count / 100);
  EXPECT_GT(returned, (count - hung_up) / 2);
}

TEST(HapiSchedules, SameSeedGivesTheSameCommands) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Schedule first(seed);
    Schedule second(seed);
    first.run();
    second.run();
    ASSERT_EQ(first.log().size(), second.log().size());
    for (std::size_t k = 0; k < first.log().size(); ++k) {
      ASSERT_EQ(first.log()[k].time_ns, second.log()[k].time_ns);
      ASSERT_EQ(first.log()[k].torques, second.log()[k].torques);
    }
  }
}

}  // namespace
}  // namespace palpate
