// What holds in every tick of the safety governor, whatever device, hand, scene and schedule it
// meets: GovernorJudge judges random ones.

#include <algorithm>
#include <cmath>
#include <deque>
#include <iostream>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/nanoseconds.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"
#include "tests/haptics/governor_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::GovernorJudge;
using test::JudgeCounts;
using test::JudgedTick;
using test::Random;

bool chance(Random& random, double share) {
  return random.uniform(0.0, 1.0) < share;
}
// Uniform in the logarithm.
double scale_between(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

// One to three motors whose directions are far from linear dependence (GovernorJudge).
void put_motors(Random& random, DeviceDescription& device) {
  device.motor_count = 1 + static_cast<int>(random.index(3));
  Mat3 directions = Mat3::Zero();
  do {
    directions.setZero();
    for (int i = 0; i < device.motor_count; ++i) directions.col(i) = random.unit_vector();
  } while (singular_values(directions)[device.motor_count - 1] < 0.2);
  const bool knows_heat = chance(random, 0.5);
  const bool knows_peaks = knows_heat || chance(random, 0.5);
  for (int i = 0; i < device.motor_count; ++i) {
    MotorDescription& motor = device.motors[static_cast<std::size_t>(i)];
    std::copy_n(directions.col(i).data(), 3, motor.direction_device.begin());
    if (knows_peaks) motor.peak_force_N = scale_between(random, 0.3, 10.0);
    if (knows_heat && chance(random, 0.8)) {
      motor.continuous_force_N = scale_between(random, 0.1, 1.0) * motor.peak_force_N;
    }
  }
}

DeviceDescription random_device(Random& random, double period_s) {
  DeviceDescription device;
  device.name = "random";
  put_motors(random, device);
  device.moves_motors = !chance(random, 0.05);
  if (chance(random, 0.6)) device.peak_force_N = random.uniform(1.0, 12.0);
  const Vec3 middle_m = random.in_box(0.05);
  for (std::size_t k = 0; k < 3; ++k) {
    const double half_m = random.uniform(0.03, 0.3);
    device.workspace_low_m[k] = middle_m[static_cast<int>(k)] - half_m;
    device.workspace_high_m[k] = middle_m[static_cast<int>(k)] + half_m;
  }
  if (chance(random, 0.5)) device.mass_kg = random.uniform(0.05, 0.5);
  if (chance(random, 0.5)) device.damping_Ns_per_m = random.uniform(0.1, 3.0);
  if (chance(random, 0.8)) {
    double least_s = random.uniform(0.0, 5e-3);
    if (chance(random, 0.5)) least_s = period_s * std::floor(least_s / period_s);
    const double most_s = chance(random, 0.5) ? least_s : random.uniform(least_s, 5e-3);
    device.delay = {least_s, std::max(most_s, 1e-12)};
  }
  if (chance(random, 0.3)) device.encoder_quantum_m = scale_between(random, 1e-6, 1e-4);
  const std::array<double, 3> rates_Hz = {1.0 / period_s, 1000.0, 0.0};
  device.rate_Hz = rates_Hz[random.index(3)];
  return device;
}

// A hand at a wall that may jump, move and change its stiffness, a device with its faults, and the
// ticks of a program that may pause.
class RandomWorld {
 public:
  RandomWorld(Random& random, double period_s)
      : random_(random),
        period_s_(period_s),
        device_(random_device(random, period_s)),
        settings_{.budgets = {}, .watches_energy = !chance(random, 0.15)},
        governor_(device_, clamp_N(), settings_),
        judge_(device_, governor_.clamp_N(), settings_.watches_energy) {
    faults_ = scale_between(random, 1e-6, 1e-2);
    is_measured_ = chance(random, 0.5);
    stiffness_N_per_m_ = scale_between(random, 50.0, 20'000.0);
    out_ = random.unit_vector();
    has_mass_ = chance(random, 0.6);
    mass_kg_ = scale_between(random, 0.02, 0.5);
    damping_Ns_per_m_ = random.uniform(0.0, 2.0);
    grip_N_per_m_ = chance(random, 0.3) ? 0.0 : random.uniform(20.0, 500.0);
    delay_ticks_ = static_cast<std::size_t>(random.uniform(0.0, 8e-3) / period_s);
    turn_per_s_ = chance(random, 0.3) ? random.uniform(-3.0, 3.0) : 0.0;
    node_m_per_s_ = chance(random, 0.3) ? random.uniform(-0.05, 0.05) : 0.0;
    vibration_N_ = chance(random, 0.3) ? random.uniform(0.0, 2.0) : 0.0;
    vibration_Hz_ = random.uniform(20.0, 400.0);
    along_vibration_ = random.unit_vector();
    magnet_N_ = chance(random, 0.2) ? Vec3(random.in_box(1.0)) : Vec3(Vec3::Zero());
    a4_rad_ = chance(random, 0.3) ? random.uniform(-1.0, 1.0) : 0.0;
    a4_axis_ = random.unit_vector();
    knows_spring_ = !chance(random, 0.15);
    hand_speed_ = scale_between(random, 0.02, 3.0);
    on_the_way_.assign(delay_ticks_ + 1, Vec3::Zero());
    p_m_ = goal_m_ = 5e-3 * out_;
  }

  void tick() {
    if (happens(0.1)) pause();
    move_hand();
    move_wall();
    JudgedTick tick;
    sample(tick);
    want(tick);
    tick.rearms =
        governor_.status().state == GovernorState::kTripped && chance(random_, 20.0 * period_s_);
    if (tick.rearms) governor_.rearm();
    tick.restarts = happens(0.1);
    if (tick.restarts) governor_.restart();
    tick.used = governor_.begin_tick(tick.sample, tick.time);
    std::copy_n(tick.used.position_m.begin(), 3, tick.wanted.device_m);
    tick.motors = turned();
    if (turn_per_s_ != 0.0) governor_.set_motors(tick.motors);
    tick.record = tick.wanted;
    governor_.govern(tick.record, tick.sources);
    tick.status = governor_.status();
    judge_.judge(tick);
    on_the_way_.push_back(vec3(tick.record.force_device_N));
    on_the_way_.pop_front();
    ++ticks_;
  }
  const JudgeCounts& counts() const { return judge_.counts(); }

 private:
  double clamp_N() {
    std::optional<double> most_N;
    if (chance(random_, 0.5)) most_N = random_.uniform(0.5, 12.0);
    return SafetyGovernor::clamp_of(device_, most_N);
  }
  bool happens(double share = 1.0) { return chance(random_, share * faults_); }
  double time_s() const { return static_cast<double>(ticks_) * period_s_; }

  void pause() {
    for (std::uint64_t n = random_.index(3); n < 3; ++n) {
      governor_.pause();
      judge_.pause();
    }
    now_ns_ += std::llround(1e9 * random_.uniform(period_s_, 2.0));
    on_the_way_.assign(delay_ticks_ + 1, Vec3::Zero());
  }

  // A tip with a grip, or a hand that moves as it likes. While the governor waits, it mostly rests
  // outside.
  void move_hand() {
    const bool rests = governor_.status().state == GovernorState::kWaits && !happens(10.0);
    if (chance(random_, 3.0 * period_s_) || (rests && goal_m_.dot(out_) < wall_m_)) {
      const double height_m = rests ? 5e-3 : random_.uniform(-15e-3, 5e-3);
      goal_m_ = random_.in_box(0.02);
      goal_m_ += (wall_m_ + height_m - goal_m_.dot(out_)) * out_;
      if (!rests && happens(20.0)) goal_m_ = random_.in_box(0.3);
    }
    if (rests) {
      // Within some ms it stands still there.
      p_m_ += std::min(1.0, 100.0 * period_s_) * (goal_m_ - p_m_);
      v_m_per_s_.setZero();
    } else if (has_mass_) {
      const Vec3 grip_N = grip_N_per_m_ * (goal_m_ - p_m_) - damping_Ns_per_m_ * v_m_per_s_;
      v_m_per_s_ += period_s_ / mass_kg_ * (on_the_way_.front() + grip_N);
      p_m_ += period_s_ * v_m_per_s_;
    } else {
      const Vec3 way_m = goal_m_ - p_m_;
      const double most_m = hand_speed_ * period_s_;
      p_m_ += way_m.norm() > most_m ? Vec3(most_m / way_m.norm() * way_m) : way_m;
      p_m_ += random_.in_box(1e-6);
    }
    if (happens(0.3)) p_m_ += random_.in_box(0.05);
    if (p_m_.norm() > 0.3) {
      p_m_ *= 0.3 / p_m_.norm();
      v_m_per_s_.setZero();
    }
  }

  void move_wall() {
    nodes_moved_ = node_m_per_s_ != 0.0;
    node_way_m_ = node_m_per_s_ * period_s_;
    if (chance(random_, period_s_)) node_m_per_s_ = -node_m_per_s_;
    if (happens()) {  // a jump
      nodes_moved_ = chance(random_, 0.5);
      node_way_m_ += random_.uniform(-0.01, 0.01);
    }
    wall_m_ = std::clamp(wall_m_ + node_way_m_, -0.03, 0.03);
    if (happens()) stiffness_N_per_m_ = scale_between(random_, 50.0, 20'000.0);
  }

  void sample(JudgedTick& tick) {
    DeviceSample& sample = tick.sample;
    const bool is_missing = missing_ > 0 || happens(2.0);
    if (missing_ > 0) {
      --missing_;
    } else if (is_missing) {
      const double longest_s = chance(random_, 0.1) ? 0.2 : 0.03;
      missing_ = static_cast<int>(random_.uniform(0.0, longest_s / period_s_));
    }
    if (!is_missing) {
      ++sequence_;
      const double step_m = device_.encoder_quantum_m;
      sampled_m_ = p_m_;
      for (int k = 0; step_m > 0.0 && k < 3; ++k) {
        sampled_m_[k] = step_m * std::round(p_m_[k] / step_m);
      }
    }
    std::copy_n(sampled_m_.data(), 3, sample.position_m.begin());
    sample.sequence = sequence_;
    if (happens()) sample.sequence -= std::min<std::uint64_t>(sequence_, random_.index(5));
    sample.asks_for_trip = happens(0.1);
    std::uint32_t& faults = tick.wanted.faults;
    faults = kFaultNone;
    if (happens()) {
      const std::array<std::uint32_t, 4> kinds = {kFaultNonFiniteSample, kFaultInvalidSample,
                                                  kFaultJump, kFaultFarSample};
      faults = kinds[random_.index(4)];
      sample.is_valid = faults != kFaultInvalidSample;
    }
    double late_s = happens() ? scale_between(random_, 1e-5, 1.0) : 0.0;
    if (chance(random_, 0.2)) late_s += random_.uniform(0.0, 0.2 * period_s_);
    now_ns_ += std::llround((period_s_ + late_s) * 1e9);
    tick.time = {period_s_, std::llround(late_s * 1e9), is_measured_ ? now_ns_ : 0};
  }

  // The force of the scene.
  void want(JudgedTick& tick) {
    TickRecord& record = tick.wanted;
    record.tick = ticks_;
    record.time_s = time_s();
    const double depth_m = std::max(0.0, wall_m_ - sampled_m_.dot(out_));
    Vec3 full_N = stiffness_N_per_m_ * depth_m * out_;
    record.contact = depth_m > 0.0;
    ForceSources& sources = tick.sources;
    if (knows_spring_) {
      sources.stiffness_N_per_m = stiffness_N_per_m_;
      sources.lag_m = depth_m;
    }
    sources.nodes_moved = nodes_moved_;
    if (nodes_moved_) sources.nodes_J = stiffness_N_per_m_ * depth_m * node_way_m_;
    sources.has_effects = vibration_N_ > 0.0 || !magnet_N_.isZero(0.0);
    if (sources.has_effects && record.contact) {
      const double phase = 2.0 * std::numbers::pi * vibration_Hz_ * time_s();
      sources.effects_N[0] = vibration_N_ * std::sin(phase) * along_vibration_;
      sources.effects_N[2] = magnet_N_;
      for (const Vec3& effect_N : sources.effects_N) full_N += effect_N;
    }
    if (happens(3.0)) full_N = random_.in_box(20.0);
    Vec3 wanted_N = full_N;
    if (a4_rad_ != 0.0) wanted_N = Eigen::AngleAxisd(a4_rad_, a4_axis_) * full_N;
    if (happens(0.1)) wanted_N[static_cast<int>(random_.index(3))] = kBad[random_.index(2)];
    if (happens(0.05)) full_N[static_cast<int>(random_.index(3))] = kBad[random_.index(2)];
    const bool is_bad = (record.faults & kFaultsWithoutForce) != 0;
    if (is_bad) wanted_N = full_N = Vec3::Zero();
    put(full_N, record.full_force_device_N);
    put(wanted_N, record.force_device_N);
  }

  std::span<const MotorDescription> turned() {
    const Eigen::AngleAxisd turn(turn_per_s_ * time_s(), a4_axis_);
    motors_ = device_.motors;
    for (MotorDescription& motor : motors_) {
      const Vec3 direction = turn * Vec3(motor.direction_device.data());
      if (turn_per_s_ != 0.0) std::copy_n(direction.data(), 3, motor.direction_device.begin());
    }
    return std::span(motors_).first(static_cast<std::size_t>(device_.motor_count));
  }

  static constexpr std::array<double, 2> kBad = {std::numeric_limits<double>::quiet_NaN(),
                                                 std::numeric_limits<double>::infinity()};

  Random& random_;
  double period_s_;
  DeviceDescription device_;
  GovernorSettings settings_;
  SafetyGovernor governor_;
  GovernorJudge judge_;
  std::uint64_t ticks_ = 0;

  double faults_ = 0.0;  // how often each fault happens, per tick
  bool is_measured_ = false;
  std::int64_t now_ns_ = 1'000'000'000;
  std::uint64_t sequence_ = 0;
  int missing_ = 0;  // samples
  Vec3 sampled_m_ = Vec3::Zero();

  // The hand.
  bool has_mass_ = false;
  double mass_kg_ = 0.1, damping_Ns_per_m_ = 0.5, grip_N_per_m_ = 0.0, hand_speed_ = 0.1;
  Vec3 p_m_ = Vec3::Zero(), v_m_per_s_ = Vec3::Zero(), goal_m_ = Vec3::Zero();
  std::size_t delay_ticks_ = 0;
  std::deque<Vec3> on_the_way_;

  // The scene.
  Vec3 out_ = Vec3::UnitX();
  double stiffness_N_per_m_ = 1000.0;
  double wall_m_ = 0.0, node_m_per_s_ = 0.0, node_way_m_ = 0.0;
  bool nodes_moved_ = false;
  double vibration_N_ = 0.0, vibration_Hz_ = 100.0;
  Vec3 along_vibration_ = Vec3::UnitX(), magnet_N_ = Vec3::Zero();
  bool knows_spring_ = true;
  double a4_rad_ = 0.0;
  Vec3 a4_axis_ = Vec3::UnitX();
  double turn_per_s_ = 0.0;
  std::array<MotorDescription, 3> motors_{};
};

TEST(GovernorProperties, HoldInEveryTickOfRandomDevicesHandsAndSchedules) {
  Random random(49);
  const auto ticks = test::from_environment(
      "PALPATE_GOVERNOR_TICKS", test::in_soak_or_else<std::uint64_t>(20'000'000, 400'000));
  std::cout << "seed " << random.seed() << "\n";
  JudgeCounts sum;
  std::uint64_t schedules = 0;
  while (sum.ticks < ticks) {
    const double period_s = 1.0 / scale_between(random, 250.0, 10'000.0);
    RandomWorld world(random, period_s);
    const int count = std::clamp(static_cast<int>(3.0 / period_s), 2000, 15'000);
    for (int n = 0; n < count; ++n) {
      world.tick();
      if (HasFatalFailure()) FAIL() << "schedule " << schedules << ", tick " << n;
    }
    const JudgeCounts& counts = world.counts();
    sum.ticks += counts.ticks;
    sum.exact += counts.exact;
    sum.damped += counts.damped;
    sum.spring += counts.spring;
    sum.released += counts.released;
    for (int n = 0; n < kGovernorRuleCount; ++n) sum.rules[n] += counts.rules[n];
    for (std::size_t n = 0; n < kTripReasonNames.size(); ++n) sum.trips[n] += counts.trips[n];
    ++schedules;
  }
  std::cout << sum.ticks << " ticks in " << schedules << " schedules; predicted " << sum.exact
            << ", damping separated " << sum.damped << ", springs weighed " << sum.spring
            << ", released " << sum.released << "\n";
  for (int n = 0; n < kGovernorRuleCount; ++n) {
    std::cout << kGovernorRuleNames[static_cast<std::size_t>(n)] << ' ' << sum.rules[n] << ", ";
    EXPECT_GT(sum.rules[n], 0u) << kGovernorRuleNames[static_cast<std::size_t>(n)];
  }
  std::cout << "\ntrips: ";
  for (std::size_t n = 1; n < kTripReasonNames.size(); ++n) {
    std::cout << kTripReasonNames[n] << ' ' << sum.trips[n] << ", ";
    // A loop that nothing holds is rare: some in a million ticks.
    const bool is_rare = kTripReasonNames[n] == "unstable" && sum.ticks < 5'000'000;
    if (!is_rare) {
      EXPECT_GT(sum.trips[n], 0u) << kTripReasonNames[n];
    }
  }
  std::cout << "\n";
}

}  // namespace
}  // namespace palpate
