#pragma once

// Judges each tick of a safety governor by the definitions of its rules, which it computes in its
// own way.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "geometry/base/types.h"
#include "haptics/safety_governor.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate::test {

// The directions of one to three motors, and their efforts by the normal equations.
class JudgedMotors {
 public:
  explicit JudgedMotors(std::span<const MotorDescription> motors);

  Vec3 part(const Vec3& force_N) const;
  // What each motor exerts; 0 for those that are not there.
  Vec3 efforts_N(const Vec3& force_N) const;
  Vec3 loads(const Vec3& force_N) const;
  // What no motor exceeds under any force of this length.
  Vec3 largest_loads(double force_N) const;
  // The largest ratio of an effort to its peak.
  double overload(const Vec3& force_N) const;
  std::size_t count() const { return count_; }

 private:
  std::size_t count_ = 0;
  Mat3 directions_ = Mat3::Zero();  // columns
  Mat3 inverse_ = Mat3::Zero();     // rows: a motor's share of a force
  Vec3 peak_N_ = Vec3::Zero(), continuous_N_ = Vec3::Zero();
};

// All that the judge may see of a tick.
struct JudgedTick {
  DeviceSample sample;  // as given to begin_tick()
  DeviceSample used;    // as returned by it
  TickTime time;
  std::span<const MotorDescription> motors;
  bool rearms = false;    // rearm() was called before the tick
  bool restarts = false;  // restart() was called before the tick
  TickRecord wanted;      // before govern()
  TickRecord record;      // after it
  ForceSources sources;
  GovernorStatus status;
};

// What the judge has seen, to show that a test reaches what it judges.
struct JudgeCounts {
  std::uint64_t ticks = 0;
  std::uint64_t exact = 0;   // ticks whose force was predicted
  std::uint64_t damped = 0;  // ticks whose damping was separated
  std::uint64_t spring = 0;  // ticks whose spring was weighed
  std::uint64_t released = 0;
  std::uint64_t rules[kGovernorRuleCount] = {};
  std::uint64_t trips[kTripReasonNames.size()] = {};
};

class GovernorJudge {
 public:
  GovernorJudge(const DeviceDescription& device, double clamp_N, bool watches_energy);

  // Fails the running test (gtest) if the tick breaks a promise.
  void judge(const JudgedTick& tick);
  void pause();

  const JudgeCounts& counts() const { return counts_; }

 private:
  // A way between two good samples, and the work of the forces that acted on it.
  struct Way {
    bool is_known = false;
    Vec3 way_m = Vec3::Zero();
    double time_s = 0.0;
    bool is_gap = false;
    double work_J = 0.0, late_J = 0.0;
    double uncertain_J = 0.0;  // by the steps of the encoders
    double size_J = 0.0;       // of force and way, whatever their directions: what rounds
  };
  // Rules that must have acted, and rules that may have.
  struct Rules {
    std::uint32_t must = 0, may = 0;
    void add(GovernorRule rule, bool acts) {
      if (acts) must |= rule, may |= rule;
    }
    // A factor that is 1 up to rounding may have been taken for 1.
    void add_factor(GovernorRule rule, double factor);
  };

  void find_times(const JudgedTick& tick);
  void find_way(const JudgedTick& tick);
  Vec3 acting_N(double delay_s) const;
  void find_speeds();
  void find_trip(const JudgedTick& tick, bool has_bad_force);
  void find_state(const JudgedTick& tick, const Vec3& pushed_N);
  double workspace_factor(const TickRecord& record) const;
  void judge_limits(const JudgedTick& tick, const JudgedMotors& motors);
  void judge_force(const JudgedTick& tick, const JudgedMotors& motors, const Vec3& pushed_N,
                   double factor, Rules& rules);
  double heat_factor(const Vec3& loads) const;
  void judge_heat(const JudgedTick& tick, const JudgedMotors& motors, const Vec3& wanted);
  void judge_damping(const JudgedTick& tick, const JudgedMotors& motors, const Vec3& even_N,
                     double factor);
  void judge_spring(const JudgedTick& tick, double least, double most);
  void judge_release(const JudgedTick& tick);
  void judge_energy(const JudgedTick& tick);
  void begin_start();

  DeviceDescription device_;
  double clamp_N_;
  bool moves_, watches_;
  AssumedMechanics mechanics_;
  JudgeCounts counts_;

  // Times, ns.
  std::int64_t period_ns_ = 0, step_ns_ = 0, late_ns_ = 0, now_ns_ = 0, last_now_ns_ = 0;
  std::int64_t paused_at_ns_ = 0;  // 0: there was no pause
  std::int64_t age_ns_ = 0;
  double period_s_ = 0.0;

  bool has_sample_ = false, is_new_ = false, is_out_of_order_ = false, is_bad_ = false;
  std::uint64_t sequence_ = 0;
  bool is_stale_ = false, is_late_ = false, is_interrupted_ = false;
  std::deque<std::int64_t> bad_ns_;
  std::int64_t since_interruption_ns_ = 0;
  bool has_been_interrupted_ = false;

  struct Place {
    std::int64_t time_ns;
    Vec3 p_m;
    std::uint64_t tick = 0;
  };
  std::deque<Place> places_;  // of the speed
  bool has_speed_ = false;
  double least_speed_ = 0.0, most_speed_ = 0.0;

  GovernorState state_ = GovernorState::kRuns;
  std::uint64_t trips_ = 0;
  TripReason reason_ = TripReason::kNone;  // of a trip in this tick
  bool may_trip_by_speed_ = false;
  std::int64_t least_calm_ns_ = 0, most_calm_ns_ = 0, start_ns_ = 0;

  double wanted_N_ = 0.0;  // the length of the wanted force
  Vec3 last_N_ = Vec3::Zero();
  std::deque<Vec3> commanded_;  // the newest first
  // Since the last good sample.
  bool has_last_ = false;
  Vec3 last_m_ = Vec3::Zero();
  std::int64_t way_ns_ = 0;
  std::int64_t hold_ns_ = 0, hold_since_ns_ = 0;  // the longest way in time, lately
  int way_ticks_ = 0;
  Vec3 acted_N_ = Vec3::Zero(), acted_late_N_ = Vec3::Zero();
  Way way_;
  double given_J_ = 0.0, given_late_J_ = 0.0, worked_J_ = 0.0;
  double half_step_m_ = 0.0, encoder_J_ = 0.0;
  double largest_N_ = 0.0;  // sum of a force's parts along the axes
  int path_ends_ = 0;

  Vec3 mean_square_ = Vec3::Zero();
  bool has_long_steps_ = false;  // for the heat

  // Of the damping.
  std::deque<Place> row_;                      // of samples in a row
  std::deque<std::optional<Vec3>> watched_N_;  // without damping and vibration, the newest first
  bool had_damping_ = false;

  // Of the spring.
  double ramp_share_ = 1.0;  // what the rules start and ease allow in this tick
  double last_spring_N_ = 0.0, last_stiffness_ = 0.0;
  double least_N_ = 0.0, most_N_ = 0.0;  // the force of the spring in the last tick
  double tank_J_ = SpringRestart::kTank_J;
  double returns_J_ = 0.0;
  std::int64_t returns_ns_ = 0;
  bool was_interrupted_ = false;

  // Of a release.
  double tripped_N_ = 0.0;
  std::int64_t tripped_ns_ = 0;
  int pushes_ = 0;  // ticks of this release in which its force did positive work
  bool was_released_ = false;
};

}  // namespace palpate::test
