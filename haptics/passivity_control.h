#pragma once

// The passivity observer and the passivity controller of a device that moves motors.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"
#include "haptics/device_mechanics.h"
#include "haptics/force_history.h"
#include "haptics/stiff_span.h"
#include "haptics/swing_watch.h"

namespace palpate {

// What the controller may do, and when.
struct PassivityLimits {
  // The energy account may be this far below zero: a hand that moved for long before must not pay
  // for what comes.
  static constexpr double kMostCredit_J = 0.2e-3;
  // The account forgets what is older than this.
  static constexpr double kForget_s = 1.0;
  // Leak and motion are averaged over this time, and the account is paid back in kRepay_s.
  static constexpr double kAverage_s = 30e-3;
  static constexpr double kRepay_s = 5e-3;
  // The damping exceeds the leak by this share.
  static constexpr double kMargin = 0.5;
  // While the account exceeds kSoften_J, the force loses its stiffness with kSoftening_s, down to
  // kLeastStiffness. If it then stays above for kUnstable_s, the loop is unstable. A fingertip of
  // 10 g moves at 1 m/s with 5 mJ.
  static constexpr double kSoften_J = 5e-3;
  static constexpr double kSoftening_s = 50e-3;
  static constexpr double kLeastStiffness = 1.0 / 16.0;
  static constexpr double kUnstable_s = 0.2;
  // After this time without a force, the next contact has its full stiffness.
  static constexpr double kRest_s = 0.1;
  // The damping of a swing of angular frequency w: 2 zeta m w with this zeta. A swing is damped if
  // the leak takes more than kSwingLeak of the device's own damping: with less, a swing that does
  // not die down is the hand's own motion.
  static constexpr double kSwingLeak = 0.4;
  static constexpr double kSwingDamping = 0.2;
  // A half-swing smaller than this cannot be felt as one. A tip at rest at the edge of two steps of
  // its encoder moves by one step; a half-swing is more.
  static constexpr double kFeltSwing_m = 20e-6;
  static constexpr double kSwingSteps = 1.25;
  // A change of the force by more than this number of steps of the encoder tells the stiffness.
  static constexpr double kSureSteps = 2.0;
};

// Observes the energy that sampling, hold and delay add to the force, and takes it out again with a
// damper (Hannaford and Ryu 2002, "Time-domain passivity control of haptic interfaces", for a port
// with a delay).
//
// Observer. f_k: the force of tick k without the controller's damping; dx_k: the way of the device
// from sample k - 1 to sample k. A force that acted without delay and hold, and changed evenly
// between two samples, would do the work w0 = (f_(k-1) + f_k) . dx / 2: what the scene gives by
// design. The motors do the work w = a . dx, where a is the mean of the forces that act between
// the two samples (ForceHistory). The leak w - w0 is what time adds. A spring K alone on a hand of
// speed v leaks about K (tau + T / 2) v^2 T in a tick. The device's own damping b takes
// b (dx.u)^2 / T, u the direction in which the force changes, or that of the force that is late.
// The account sums leak, less damping. It is the larger one of the two for the ends of the delay
// interval.
//
// Controller. While the account is positive, a damper acts along u, the direction in which the
// force has changed over the window of the velocity: so a hand that slides along a wall is not
// damped. Its damping is the leak per square of speed less b, with a margin, and what pays the
// account back; at most m / (2 t), t the age of the velocity in the force
// (largest_damping_Ns_per_m). A swing that does not die down (SwingWatch) has damping as well, and
// the contact is damped until it ends. If the account grows all the same, the force becomes softer
// until the contact ends, and at last the loop is unstable.
//
// Steps. Where the device rounds its positions (EncoderPath), what a swing of some steps seems to
// leak and to lose is mostly rounding. u is then the span of the last changes (StiffSpan), and a
// contact with K (tau + T / 2) > b has at least the damping that this leak needs by the stiffness
// of the contact: of the spring's, or less if force and way of the last kAverage_s of the contact
// show less. Where friction or texture change the force along a wall, this damps the slide, too.
// The encoder does not see a swing of one step; half a step to each side stays.
//
// Rare samples. A way over several ticks has the mean of the forces that acted in them, and the
// window of the velocity has as many samples as fit, at least one.
//
// After an interruption the hand may be fast, and the device's damping does not count: the motors
// give the hand no more than was stored.
//
// With K (tau + T / 2) <= b the account never becomes positive, and a force keeps its bits.
//
// One thread owns an object. No function allocates or throws.
class PassivityControl {
 public:
  struct Tick {
    Vec3 p_device_m = Vec3::Zero();  // EncoderPath
    bool has_way = false;            // there was a way since the last call
    double way_s = 0.0;              // its time
    Vec3 force_N = Vec3::Zero();     // of this tick, without the damping
    double stiffness_N_per_m = 0.0;  // of the contact; 0: unknown
    double given_J = 0.0;            // beyond the budgets, since the last tick
    bool is_disturbed = false;       // the force was interrupted shortly before
    double longest_hold_s = 0.0;     // between two new samples, lately
    std::int64_t now_ns = 0;
  };

  PassivityControl(const AssumedMechanics& device, double encoder_quantum_m) noexcept
      : device_(device), quantum_m_(encoder_quantum_m) {}

  void set_period(double period_s) noexcept;
  // Observes a tick, and returns the damping force, device frame, N: zero if none is needed. It is
  // in the span of the forces of the ticks.
  Vec3 damping_N(const Tick& tick) noexcept;
  // The damping of the last tick, for a tick without a new sample.
  const Vec3& held_damping_N() const noexcept { return held_N_; }
  // The last sample does not count: the next tick has no way, and no damping is held.
  void lose_way() noexcept {
    count_ = 0;
    held_N_.setZero();
  }
  // No force of the ticks before this one acts any more.
  void forget_forces() noexcept;
  // Adds the forces that were commanded in this tick: with and without damping.
  void command(const Vec3& force_N, const Vec3& damping_N) noexcept;
  // The factor of the stiffness, from kLeastStiffness to 1.
  double stiffness() const noexcept { return stiffness_; }
  bool is_unstable() const noexcept { return unstable_s_ > PassivityLimits::kUnstable_s; }
  // The account that is_unstable() has seen.
  double judged_J() const noexcept { return judged_J_; }
  double account_J() const noexcept { return std::max(ends_[0].account_J, ends_[1].account_J); }
  // The largest damping, N s/m.
  double largest_damping_Ns_per_m() const noexcept { return most_damping_; }
  // The force begins anew.
  void clear() noexcept;

 private:
  // Since the last sample: the sums of what acted, and of what was booked for it.
  struct SinceSample {
    int ticks = 0;
    std::array<Vec3, 2> acting_N = {Vec3::Zero(), Vec3::Zero()};
    Vec3 damping_N = Vec3::Zero();
    double booked_J = 0.0;
  };

  void observe(const Tick& tick, const Vec3& way_m, const SinceSample& since) noexcept;
  void soften(const Tick& tick) noexcept;
  double leak_J() const noexcept { return std::max(ends_[0].leak_J, ends_[1].leak_J); }
  void pay(double energy_J) noexcept;
  double swing_rad_per_s() const noexcept;
  std::size_t samples_of_window(double longest_hold_s) const noexcept;
  double held_damping(double longest_hold_s) const noexcept;
  double wanted_damping(double speed_m_per_s) const noexcept;
  bool has_steps() const noexcept { return quantum_m_ > 0.0; }
  void learn_span(const Tick& tick) noexcept;
  double known_damping(const Tick& tick) const noexcept;

  AssumedMechanics device_;
  double quantum_m_;
  double period_s_ = 0.0;
  std::array<DelayTicks, 2> delays_;  // the least and the most
  std::size_t window_ = 1;            // of the velocity, ticks
  double most_damping_ = 0.0;
  double forgotten_ = 0.0;  // the shares that a tick forgets and averages
  double averaged_ = 0.0;

  ForceHistory forces_;  // without damping
  ForceHistory dampings_;
  // The work of a damping force, booked in its tick and corrected when the force acts.
  std::array<double, 128> booked_J_{};
  std::size_t booked_ = 0;
  // How many ticks the two histories above still hold a damping; without one, they stand still.
  std::size_t damped_ticks_ = 0;

  SinceSample since_;

  static constexpr std::size_t kPositions = 128;
  std::array<Vec3, kPositions> positions_m_;
  std::array<Vec3, kPositions> forces_of_samples_N_;
  std::array<std::int64_t, kPositions> times_ns_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;               // of positions in a row
  std::size_t samples_with_force_ = 0;  // in a row

  // The account and the averaged leak, for each end of the delay interval.
  struct End {
    double account_J = -PassivityLimits::kMostCredit_J;
    double leak_J = 0.0;
  };
  std::array<End, 2> ends_;
  double motion_Js_per_Ns_ = 0.0;  // averaged (dx.u)^2 / T
  bool is_active_ = false;
  bool has_swung_ = false;  // in this contact
  Vec3 held_N_ = Vec3::Zero();
  Vec3 along_m_per_s_ = Vec3::Zero();  // of the damping of this tick
  std::int64_t last_force_ns_ = 0;
  double counted_damping_ = 0.0;  // of the device, N s/m, in this tick
  double stiffness_ = 1.0;
  double unstable_s_ = 0.0;
  double judged_J_ = 0.0;  // the account by which the contact was last judged
  SwingWatch swing_;
  StiffSpan span_;  // of a device with steps
};

}  // namespace palpate
