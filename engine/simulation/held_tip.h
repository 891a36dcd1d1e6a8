#pragma once

// The tip of a device in a hand, without any step-size error: what the motors act on.

#include "engine/devices/stability_limits.h"  // HandImpedance
#include "geometry/base/types.h"

namespace palpate {

// A hand that holds nothing: the tip is bare.
inline constexpr HandImpedance kNoHand{0.0, 0.0, 0.0};

struct TipSettings {
  double mass_kg = 0.1;           // > 0, of the device at its tip
  double damping_Ns_per_m = 0.5;  // > 0, of the device, viscous
  HandImpedance hand = kNoHand;
};

// The works on the tip since the account was opened, as exact integrals. The hand's mass moves with
// the tip and counts as part of it, so that
//   motors_J + hand_J - lost_J = the change of HeldTip::kinetic_J().
struct PortAccount {
  double motors_J = 0.0;  // work of the motors on the tip: positive, if they gave energy
  double hand_J = 0.0;  // work of the hand's spring, damper and push on the tip, and of its throws
  double lost_J = 0.0;  // what the device's damping has taken
  // The largest values at the end of a step, never below 0: of motors_J, and of motors_J - lost_J,
  // which is what hand and motion have got beyond the work that the hand has put in.
  double most_given_J = 0.0;
  double most_returned_J = 0.0;
  double largest_speed_m_per_s = 0.0;  // at the ends of steps
};

// A mass m with a viscous damping b, and a hand of mass m_h, damping c and stiffness k between the
// tip and the place x_i where the hand wants to be, which moves steadily:
//   (m + m_h) x'' = -b x' - c (x' - x_i') - k (x - x_i) + push + motors.
// A step is the exact solution for forces that are constant over it, of any length. Device frame,
// SI. Safe on the haptic thread. One thread owns an object.
class HeldTip {
 public:
  HeldTip(const TipSettings& settings, const Vec3& at_m);

  // The hand wants to be at this place now, and moves on steadily.
  void set_hand(const Vec3& at_m, const Vec3& velocity_m_per_s = Vec3::Zero()) {
    hand_m_ = at_m;
    hand_m_per_s_ = velocity_m_per_s;
  }
  // A constant force of the hand beside its spring and damper, until the next call.
  void push(const Vec3& force_N) { push_N_ = force_N; }
  // The hand gives the tip this velocity at once; the change of the kinetic energy is its work.
  void throw_at(const Vec3& velocity_m_per_s);

  // Something stops the tip here; its kinetic energy is lost.
  void stop_at(const Vec3& at_m);

  // Moves on by dt_s >= 0 while the motors exert a force on the hand.
  void advance(const Vec3& motors_N, double dt_s);

  const Vec3& position_m() const { return position_m_; }
  const Vec3& velocity_m_per_s() const { return velocity_m_per_s_; }
  const Vec3& hand_m() const { return hand_m_; }
  double mass_kg() const { return mass_kg_; }  // with the hand's
  double kinetic_J() const { return 0.5 * mass_kg_ * velocity_m_per_s_.squaredNorm(); }

  void open_account() { account_ = {}; }
  const PortAccount& account() const { return account_; }

 private:
  TipSettings settings_;
  double mass_kg_;
  Vec3 position_m_;
  Vec3 velocity_m_per_s_ = Vec3::Zero();
  Vec3 hand_m_;
  Vec3 hand_m_per_s_ = Vec3::Zero();
  Vec3 push_N_ = Vec3::Zero();
  PortAccount account_;
};

}  // namespace palpate
