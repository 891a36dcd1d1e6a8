#include "engine/simulation/held_tip.h"

#include <algorithm>
#include <cmath>

#include "engine/simulation/mass_damper.h"

namespace palpate {
namespace {

// The place and velocity of the tip relative to the hand.
struct Relative {
  Vec3 m;
  Vec3 m_per_s;
};

// The exact solution of M u'' + B u' + k u = F, k > 0, about its rest u = F / k: with a = B / 2M
// and w^2 = |k / M - a^2|,
//   y  = e^-at ((c + a s) y0 + s y0'),   y' = e^-at ((c - a s) y0' - k / M s y0),
// where c = cos wt and s = sin wt / w, or cosh wt and sinh wt / w if the motion does not swing.
Relative swing(const Relative& start, const Vec3& force_N, double mass_kg, double damping_Ns_per_m,
               double stiffness_N_per_m, double dt_s) {
  const double a = damping_Ns_per_m / (2.0 * mass_kg);
  const double k = stiffness_N_per_m / mass_kg;
  const double square = k - a * a;
  const double angle = std::sqrt(std::abs(square)) * dt_s;
  double c = 1.0;
  double s = dt_s;
  if (angle > 0.0) {
    c = square > 0.0 ? std::cos(angle) : std::cosh(angle);
    s = dt_s * (square > 0.0 ? std::sin(angle) : std::sinh(angle)) / angle;
  }
  const double decay = std::exp(-a * dt_s);
  const Vec3 rest_m = force_N / stiffness_N_per_m;
  const Vec3 y_m = start.m - rest_m;
  return {rest_m + decay * ((c + a * s) * y_m + s * start.m_per_s),
          decay * ((c - a * s) * start.m_per_s - k * s * y_m)};
}

}  // namespace

HeldTip::HeldTip(const TipSettings& settings, const Vec3& at_m)
    : settings_(settings),
      mass_kg_(settings.mass_kg + settings.hand.mass_kg),
      position_m_(at_m),
      hand_m_(at_m) {}

void HeldTip::throw_at(const Vec3& velocity_m_per_s) {
  const double before_J = kinetic_J();
  velocity_m_per_s_ = velocity_m_per_s;
  account_.hand_J += kinetic_J() - before_J;
  account_.largest_speed_m_per_s =
      std::max(account_.largest_speed_m_per_s, velocity_m_per_s_.norm());
}

void HeldTip::stop_at(const Vec3& at_m) {
  account_.lost_J += kinetic_J();
  position_m_ = at_m;
  velocity_m_per_s_.setZero();
}

// With u = x - x_i and w = u', whose equation is M w' = F - B w - k u, B = b + c and the force
// F = motors + push - b x_i', the integrals over the step follow from the states at its ends:
//   B int w.w = F.du - M d(w.w) / 2 - k d(u.u) / 2,   k int u = F dt - M dw - B du.
void HeldTip::advance(const Vec3& motors_N, double dt_s) {
  if (dt_s == 0.0) return;
  const double b = settings_.damping_Ns_per_m;
  const double c = settings_.hand.damping_Ns_per_m;
  const double k = settings_.hand.stiffness_N_per_m;
  const Vec3 force_N = motors_N + push_N_ - b * hand_m_per_s_;
  const Relative before{position_m_ - hand_m_, velocity_m_per_s_ - hand_m_per_s_};
  Relative after;
  if (k > 0.0) {
    after = swing(before, force_N, mass_kg_, b + c, k, dt_s);
  } else {
    MassDamper body(mass_kg_, b + c);
    body.put(before.m, before.m_per_s);
    body.advance(force_N, dt_s);
    after = {body.position_m(), body.velocity_m_per_s()};
  }
  const Vec3 way_m = after.m - before.m;
  const Vec3 whole_way_m = way_m + dt_s * hand_m_per_s_;
  const double spring_J = 0.5 * k * (after.m.squaredNorm() - before.m.squaredNorm());
  const double squares =
      (force_N.dot(way_m) - spring_J -
       0.5 * mass_kg_ * (after.m_per_s.squaredNorm() - before.m_per_s.squaredNorm())) /
      (b + c);
  const Vec3 spring_Ns =
      dt_s * force_N - mass_kg_ * (after.m_per_s - before.m_per_s) - (b + c) * way_m;
  account_.motors_J += motors_N.dot(whole_way_m);
  account_.hand_J += push_N_.dot(whole_way_m) - spring_J - hand_m_per_s_.dot(spring_Ns) -
                     c * (squares + hand_m_per_s_.dot(way_m));
  account_.lost_J +=
      b * (squares + 2.0 * hand_m_per_s_.dot(way_m) + dt_s * hand_m_per_s_.squaredNorm());
  hand_m_ += dt_s * hand_m_per_s_;
  position_m_ = hand_m_ + after.m;
  velocity_m_per_s_ = hand_m_per_s_ + after.m_per_s;
  account_.most_given_J = std::max(account_.most_given_J, account_.motors_J);
  account_.most_returned_J =
      std::max(account_.most_returned_J, account_.motors_J - account_.lost_J);
  account_.largest_speed_m_per_s =
      std::max(account_.largest_speed_m_per_s, velocity_m_per_s_.norm());
}

}  // namespace palpate
