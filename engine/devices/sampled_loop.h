#pragma once

// The closed loop of a device, a wall and a servo, as a discrete system.

#include <complex>
#include <span>

#include <Eigen/Core>

namespace palpate {

// The moving part: m x'' + b x' + k x = f. k belongs to a hand that holds the device.
struct LoopPlant {
  double mass_kg = 0.0;            // > 0
  double damping_Ns_per_m = 0.0;   // >= 0
  double stiffness_N_per_m = 0.0;  // >= 0
};

// A damper of the servo: the force -B (x_n - x_(n-w)) / (w T) of tick n, for a window of w ticks.
struct LoopDamper {
  double damping_Ns_per_m = 0.0;  // the sum of all dampers of a loop is >= 0
  int velocity_ticks = 1;         // w >= 1
};

// The delay in ticks: whole ticks, and the part of a tick that remains, in [0, 1). A quotient that
// only the rounding of its two numbers separates from a whole number counts as whole.
struct TickDelay {
  int whole = 0;
  double part = 0.0;

  static TickDelay of(double delay_s, double period_s);
  double ticks() const { return whole + part; }
};

// In tick n, the position x_n determines the force -K x_n plus those of the dampers. It acts from
// the delay after the sample on, until the force of the next tick replaces it. Within a tick, the
// force therefore changes once: at the part of the delay that is not whole. Between changes, the
// plant follows the matrix exponential, so the model has no error of a step size. All lengths are
// relative; the time is in periods, and a force stands as f T^2 / m, a length. Not for the haptic
// thread. A const object is safe on any thread.
class SampledLoop {
 public:
  SampledLoop(const LoopPlant& plant, double period_s, const TickDelay& delay);

  // The largest magnitude of an eigenvalue of the matrix that maps the state of one tick to that of
  // the next. Infinite if the eigenvalues cannot be computed.
  double spectral_radius(double stiffness_N_per_m, std::span<const LoopDamper> dampers) const;
  // The smallest stiffness above 0 at which an eigenvalue has the magnitude 1; infinite if there is
  // none. If the loop is stable at a smaller stiffness, it is stable below this one.
  double smallest_critical_N_per_m(std::span<const LoopDamper> dampers) const;

 private:
  struct Crossing;
  Crossing crossing(double angle, std::span<const LoopDamper> dampers) const;
  double lowest_angle(std::span<const LoopDamper> dampers) const;

  TickDelay delay_;
  double m_per_N_;                               // T^2 / m
  double m_per_Nsm_;                             // T / m: a damping in the same units
  double stiffness_N_per_m_, damping_Ns_per_m_;  // of the plant
  // x, v T after a tick, less those before it, and the effect of the force that acted at its
  // beginning and of the one that acts at its end.
  Eigen::Matrix2d step_less_1_;
  Eigen::Vector2d of_older_, of_newer_;
};

}  // namespace palpate
