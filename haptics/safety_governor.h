#pragma once

// The safety governor: the last step between the computed force and the motors.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "geometry/base/types.h"
#include "haptics/encoder_path.h"
#include "haptics/energy_budgets.h"
#include "haptics/force_history.h"
#include "haptics/force_sources.h"
#include "haptics/gentle_release.h"
#include "haptics/motor_heat.h"
#include "haptics/motor_limits.h"
#include "haptics/passivity_control.h"
#include "haptics/spring_restart.h"
#include "haptics/strategies/speed_window.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate {

// The limits of the governor. They are constants of the program: nobody can switch a rule off. Each
// period is the nominal time step of a tick.
struct GovernorLimits {
  static constexpr double kUnknownPeak_N = 3.0;  // clamp of motors whose peak force is unknown
  static constexpr double kSlew_N_per_s = 5000.0;
  static constexpr double kLongestStepPeriods = 2.0;  // of the slew rule
  static constexpr double kTopSpeed_m_per_s = 1.5;
  static constexpr double kSpeedWindow_s = 5e-3;  // or kSpeedWindowPeriods, whichever is longer
  static constexpr double kSpeedWindowPeriods = 2.0;
  static constexpr double kMovingShare = 0.1;  // of the clamp: less force cannot drive the device
  static constexpr double kStale_s = 10e-3;    // or kStalePeriods
  static constexpr double kStalePeriods = 5.0;
  static constexpr double kStaleTrip_s = 100e-3;
  static constexpr double kLate_s = 20e-3;  // or kLatePeriods
  static constexpr double kLatePeriods = 5.0;
  static constexpr double kLateRestart_s = 50e-3;  // a longer delay is a new start
  static constexpr double kFadeShare = 0.2;        // of the workspace, beyond its border
  static constexpr int kMostBadSamples = 3;        // within kBadSamples_s
  static constexpr double kBadSamples_s = 100e-3;
  static constexpr double kEase_s = 100e-3;
  static constexpr double kStartForce_N = 0.3;
  static constexpr double kStartSpeed_m_per_s = 0.2;
  static constexpr double kCalm_s = 100e-3;
  static constexpr double kStart_s = 0.5;
};

struct GovernorSettings {
  EnergyBudgets budgets;
  // False: without the rules from *restart* on, as in versions before these rules. Only the replay
  // of a recording of that time may need it.
  bool watches_energy = true;
};

enum class TripReason : std::uint8_t {
  kNone,
  kBadSamples,
  kBadForce,
  kSpeed,
  kStale,
  kDevice,
  kUnstable
};
inline constexpr std::array<std::string_view, 7> kTripReasonNames = {
    "none", "bad_samples", "non_finite_force", "speed", "stale", "device", "unstable"};

// Why the governor cut the force. The unit of value and limit is that of the reason: kBadSamples:
// 1, kSpeed: m/s, kStale: s, kUnstable: J, otherwise both are 0.
struct GovernorTrip {
  TripReason reason = TripReason::kNone;
  std::uint64_t tick = 0;
  double time_s = 0.0;
  double value = 0.0, limit = 0.0;
  std::array<double, 3> device_m = {};  // device frame
  std::array<double, 3> wanted_N = {};  // the force of the loop, device frame
};

enum class GovernorState : std::uint8_t {
  kWaits,   // for a calm hand: zero force
  kStarts,  // the force grows to its full size
  kRuns,
  kTripped  // zero force until rearm()
};

struct GovernorStatus {
  GovernorState state = GovernorState::kRuns;
  GovernorTrip trip;        // the last one
  std::uint64_t trips = 0;  // since the beginning
  // The work of the commanded forces on the hand: positive, if the motors gave energy. The first is
  // that of forces which act after the least delay of the device, the second after the longest. A
  // device that moves no motors has no delay.
  double given_J = 0.0;
  double given_late_J = 0.0;
  // What the steps of the encoders leave uncertain of both, up and down: half a step for each
  // change of the force. 0: the device states no step.
  double encoder_J = 0.0;
  // The part of given_J that missing motors and A4 give by design: the work of the force that the
  // motors can push, less the work of the full force, which A4 and the missing motors do not
  // change (docs/inside/haptics.md has a formula).
  double given_by_design_J = 0.0;
  // Of a device that moves motors: what each source has given (EnergySource), and the account of
  // the passivity observer.
  std::array<double, kEnergySourceCount> given_by_source_J = {};
  double account_J = 0.0;
};

// The times of a tick.
struct TickTime {
  double dt_s = 0.0;         // nominal time since the last tick
  std::int64_t late_ns = 0;  // start minus due time
  std::int64_t now_ns = 0;   // start of the tick, monotonic clock; 0: simulated time
};

// Limits the force of every tick. Each rule that acts sets its bit in TickRecord::rules. Rules
// marked M apply only to a device that moves motors.
//
// - bad sample (M): a tick without a usable sample is followed by *ease*; the third one within
//   100 ms trips, and so does a force that is not finite. Without motors, only the tick itself has
//   zero force.
// - motors: what the motors cannot push is dropped. If a motor would exceed its peak, the whole
//   force is scaled, so that its direction stays.
// - clamp: the force is scaled to the device's peak force, or to 3 N if a device that moves motors
//   states none, or to GovernorSettings::max_force_N.
// - slew (M): the force grows by at most 5,000 N/s, counted along its new direction; so a reversal
//   grows from zero. A fall is never delayed.
// - speed (M): a device faster than 1.5 m/s over 5 ms trips while more than 10 % of the clamp is
//   commanded.
// - stale (M): the force is zero while the newest sample is older than 10 ms, then *ease*; 100 ms
//   trip. A sample that is older than the one before it is ignored.
// - late (M): a tick that is more than 20 ms late has zero force, then *ease*, or after more than
//   50 ms *start*.
// - workspace (M): the force falls linearly from full on the border of the workspace to zero on a
//   box of 1.2 times its size.
// - ease (M): the force grows linearly from zero to full in 100 ms.
// - start (M), after start, rearm and a pause: zero force until for 100 ms the wanted force is
//   below 0.3 N or there is no contact, and the speed is below 0.2 m/s; then the force grows
//   linearly to full in 0.5 s.
// - restart (M): the spring of a contact gives back what the hand has put in, and no more
//   (SpringRestart). It acts after interruptions and starts, and after jumps of nodes, stiffness
//   and places.
// - damping (M): the passivity controller damps what time adds to the force (PassivityControl).
//   What a source gives beyond its budget (EnergyBudgets) counts as well.
// - soft (M): where damping does not suffice, the contact loses its stiffness until it ends; where
//   that does not suffice either, the governor trips: unstable.
// - heat (M): the whole force is scaled, so that no motor exceeds its continuous force, root mean
//   square over 10 s (MotorHeat).
// - release (M): after a trip whose reason leaves samples and force trustworthy (speed, unstable),
//   the part of the force that resists the motion falls within 30 ms (GentleRelease). After any
//   other trip the force is zero at once.
//
// Factors are not multiplied: the smallest one counts, but *soft* scales the spring of *restart*,
// and *heat* scales what the others leave, with the damping where there is one. The slew rule is
// the last one, also of *release*. A trip latches zero force until rearm().
//
// Thread-safety: any thread may call rearm(); one thread calls all other functions. No function
// allocates, locks or throws.
class SafetyGovernor {
 public:
  // clamp_N: see clamp_of().
  SafetyGovernor(const DeviceDescription& device, double clamp_N,
                 const GovernorSettings& settings = {}) noexcept;

  // The largest force of a device, N; infinite if no rule limits it. max_force_N: a user's limit; a
  // negative one counts as 0, and NaN as none.
  static double clamp_of(const DeviceDescription& device,
                         const std::optional<double>& max_force_N) noexcept;

  // Begins a tick. Returns the sample to use: a sample that is out of order is replaced by the one
  // before it.
  const DeviceSample& begin_tick(const DeviceSample& sample, const TickTime& time) noexcept;
  // Sets motors that turn with the device, at the pose of this tick's sample.
  void set_motors(std::span<const MotorDescription> motors) noexcept {
    std::construct_at(&motors_, motors);  // in place: a copy would wait for what was just stored
  }
  // Whether govern() needs the sources of the force.
  bool needs_sources() const noexcept { return watches_energy_; }
  // Limits the record's commanded force and sets the record's rules. Ends a tick. sources: what the
  // force comes from; without it, the stiffness of the contact is unknown.
  void govern(TickRecord& record, const ForceSources& sources = {}) noexcept;

  // Replaces begin_tick() and govern() in the ticks of a paused session, whose force is zero: the
  // rule *start* (M) begins in the next tick, and the rules do not count the time of the pause. A
  // trip stays. Two calls in a row are as one.
  void pause() noexcept;

  // The force begins again, after ticks that had none by design: the rule *start* (M) begins in the
  // next tick. A trip stays. Call it before begin_tick() or between it and govern().
  void restart() noexcept {
    if (moves_motors_ && !is_tripped()) begin_start();
  }

  // Ends a trip: the rule *start* begins in the next tick. Does nothing if there is no trip.
  void rearm() noexcept { rearm_.store(true, std::memory_order_release); }

  const GovernorStatus& status() const noexcept { return status_; }
  double clamp_N() const noexcept { return clamp_N_; }
  // Of the tick that begin_tick() began last: the time since the tick before it, measured where
  // the clock is known; and the age of the newest good sample.
  std::int64_t step_ns() const noexcept { return step_ns_; }
  std::int64_t sample_age_ns() const noexcept { return sample_age_ns_; }

 private:
  bool is_tripped() const { return status_.state == GovernorState::kTripped; }
  void find_times(const TickTime& time) noexcept;
  void set_period(std::int64_t period_ns) noexcept;
  bool has_bad_sample(TickRecord& record) noexcept;
  void watch_interruptions(TickRecord& record) noexcept;
  void watch_speed(TickRecord& record) noexcept;
  void watch_start(const TickRecord& record) noexcept;
  double find_factor(TickRecord& record, const ForceSources& sources) noexcept;
  bool is_glitch() const noexcept;
  double restart_factor(const ForceSources& sources) noexcept;
  double ease_share() const noexcept;
  double start_share() const noexcept;
  void drive(Vec3& force_N, TickRecord& record, const ForceSources& sources,
             double factor) noexcept;
  void control(Vec3& force_N, TickRecord& record, const ForceSources& sources,
               double factor) noexcept;
  double beyond_budgets_J(const TickRecord& record, const ForceSources& sources, const Vec3& even_N,
                          double factor) noexcept;
  Vec3 limited(const Vec3& force_N) const noexcept;
  Vec3 cooled(const Vec3& force_N, TickRecord& record) const noexcept;
  Vec3 released(TickRecord& record) noexcept;
  double workspace_factor(const TickRecord& record) const noexcept;
  void limit_slew(Vec3& force_N, TickRecord& record) const noexcept;
  void find_way(const TickRecord& record) noexcept;
  void add_work(const TickRecord& record) noexcept;
  void trip(TripReason reason, double value, double limit, TickRecord& record) noexcept;
  void begin_start() noexcept;

  bool moves_motors_;
  bool watches_energy_;  // a device that moves motors
  bool limits_motors_;
  double clamp_N_;
  std::array<double, 3> workspace_low_m_, workspace_high_m_;
  int sensed_axes_;
  MotorLimits motors_;

  // Times are whole nanoseconds, so that their sums have no rounding.
  // What follows from the nominal time step of a tick, by set_period().
  double dt_s_ = 0.0;
  std::int64_t period_ns_ = 0;
  std::int64_t longest_step_ns_ = 0;  // of the slew rule and the ramps
  std::int64_t longest_age_ns_ = 0;
  std::int64_t longest_late_ns_ = 0;
  // The times of this tick.
  std::int64_t step_ns_ = 0;       // measured time since the last tick
  std::int64_t ramp_step_ns_ = 0;  // step_ns_, at most kLongestStepPeriods periods
  std::int64_t late_ns_ = 0;
  std::int64_t now_ns_ = 0;  // sum of step_ns_
  std::int64_t last_now_ns_ = 0;
  std::int64_t paused_at_ns_ = 0;  // last_now_ns_ of the tick before a pause; 0: there was none

  DeviceSample sample_;      // the newest one
  bool has_sample_ = false;  // sample_ is set
  bool is_new_ = false;      // this tick's sample is newer than the one before
  bool is_out_of_order_ = false;
  std::int64_t sample_age_ns_ = 0;

  GovernorStatus status_;
  std::atomic<bool> rearm_{false};
  bool is_interrupted_ = false;  // zero force in this tick
  bool is_eased_ = false;
  std::int64_t ease_ns_ = 0;   // since the end of the last interruption
  std::int64_t start_ns_ = 0;  // since the force began to grow
  std::int64_t calm_ns_ = 0;   // how long the hand has been calm
  std::array<std::int64_t, GovernorLimits::kMostBadSamples>
      bad_ns_{};  // times of the last bad samples
  std::uint64_t bad_samples_ = 0;
  SpeedWindow speed_;
  Vec3 last_force_N_ = Vec3::Zero();

  bool has_work_ = false;  // the fields below are of the last tick with a good sample
  Vec3 work_device_m_ = Vec3::Zero();
  Vec3 work_masked_N_ = Vec3::Zero();  // what the motors could push, less the full force

  Vec3 pushed_N_ = Vec3::Zero();  // the part of this tick's force that the motors can push

  // Of a device that moves motors.
  DelayTicks least_delay_, most_delay_;
  ForceHistory commanded_;
  // Since the last good sample: its way, the sums of the forces that acted, and their number.
  bool has_way_ = false;
  bool is_gap_ = false;
  Vec3 way_m_ = Vec3::Zero();         // between the steps of the encoders (EncoderPath)
  Vec3 sensed_way_m_ = Vec3::Zero();  // as the device reports it
  EncoderPath path_;
  Vec3 place_m_ = Vec3::Zero();  // of that sample
  double half_step_m_ = 0.0;     // of the encoders
  Vec3 acted_N_ = Vec3::Zero(), acted_late_N_ = Vec3::Zero();
  int acted_ticks_ = 0;
  std::int64_t acted_ns_ = 0;
  std::int64_t way_ns_ = 0;
  double way_work_J_ = 0.0;  // of the motors on that way
  double nodes_J_ = 0.0;     // of nodes since the last way
  AssumedMechanics mechanics_;
  PassivityControl control_;
  GivenByDesign design_;
  // Of the last tick: the force without damping, what the motors cannot push, and the effects.
  Vec3 last_even_N_ = Vec3::Zero();
  Vec3 last_missing_N_ = Vec3::Zero();
  GivingForces last_effects_N_ = no_giving_forces();
  bool had_effects_ = false;
  std::int64_t device_period_ns_ = 0;  // as the device states it
  // The longest time between two new samples, lately.
  std::int64_t longest_hold_ns_ = 0;
  std::int64_t longest_hold_since_ns_ = 0;
  std::int64_t interrupted_ns_ = -1'000'000'000;  // the time of the last interruption
  SpringRestart restart_;
  MotorHeat heat_;
  double heat_share_ = 1.0;  // what the rule *heat* leaves of this tick's force without damping
  GentleRelease release_;
};

}  // namespace palpate
