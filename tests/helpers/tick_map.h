#pragma once

// A wall on a device, simulated for one tick: an oracle for the stability of loops with a delay.

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "engine/devices/stability_limits.h"
#include "engine/simulation/mass_damper.h"

namespace palpate::test {

// The state before a tick: x, v, the positions of the ticks before (the latest first), and the
// forces of the ticks before (the latest first). tick() samples x, computes the force and lets each
// force begin at its time. It shares nothing with the discrete loop that it judges: the plant is
// MassDamper, or with a hand the classical Runge-Kutta method.
class TickMap {
 public:
  TickMap(const DeviceMechanics& device, double stiffness_N_per_m, std::vector<LoopDamper> dampers,
          const ServoTiming& timing)
      : device_(device),
        stiffness_N_per_m_(stiffness_N_per_m),
        dampers_(std::move(dampers)),
        period_s_(timing.period_s),
        delay_s_(timing.delay_s),
        forces_(static_cast<int>(std::floor(timing.delay_s / timing.period_s)) + 1) {
    for (const LoopDamper& damper : dampers_) window_ = std::max(window_, damper.velocity_ticks);
  }

  // Whether every motion decays: the powers 2, 4, 8, ... of the map fall to nothing.
  bool decays() const {
    Eigen::MatrixXd power = matrix();
    for (int squaring = 0; squaring < 60; ++squaring) {
      power = power * power;
      const double size = power.norm();
      if (!(size < 1e100)) return false;
      if (size < 1e-100) return true;
    }
    return false;
  }

  Eigen::MatrixXd matrix() const {
    const int size = 2 + window_ + forces_;
    Eigen::MatrixXd map(size, size);
    for (int i = 0; i < size; ++i) map.col(i) = tick(Eigen::VectorXd::Unit(size, i));
    return map;
  }

 private:
  Eigen::VectorXd tick(const Eigen::VectorXd& before) const {
    double force_N = -stiffness_N_per_m_ * before(0);
    for (const LoopDamper& damper : dampers_) {
      force_N -= damper.damping_Ns_per_m * (before(0) - before(1 + damper.velocity_ticks)) /
                 (damper.velocity_ticks * period_s_);
    }
    const int first_force = 2 + window_;
    const auto force_of = [&](int age) {
      return age == 0 ? force_N : before(first_force + age - 1);
    };
    double x = before(0), v = before(1), time_s = 0.0, acting_N = force_of(forces_);
    for (int age = forces_ - 1; age >= 0; --age) {
      const double begin_s = delay_s_ - age * period_s_;
      if (begin_s >= period_s_) break;
      if (begin_s > time_s) advance(x, v, acting_N, begin_s - time_s);
      time_s = std::max(time_s, begin_s);
      acting_N = force_of(age);
    }
    advance(x, v, acting_N, period_s_ - time_s);
    Eigen::VectorXd after(before.size());
    after << x, v, before(0), before.segment(2, window_ - 1), force_N,
        before.segment(first_force, forces_ - 1);
    return after;
  }

  void advance(double& x, double& v, double force_N, double dt_s) const {
    if (!device_.hand) {
      MassDamper plant(device_.mass_kg, device_.damping_Ns_per_m);
      plant.put({x, 0.0, 0.0}, {v, 0.0, 0.0});
      plant.advance({force_N, 0.0, 0.0}, dt_s);
      x = plant.position_m().x();
      v = plant.velocity_m_per_s().x();
      return;
    }
    constexpr int kCuts = 32;
    for (int i = 0; i < kCuts; ++i) runge_kutta(x, v, force_N, dt_s / kCuts);
  }

  void runge_kutta(double& x, double& v, double force_N, double dt_s) const {
    const HandImpedance& hand = *device_.hand;
    const auto pull = [&](double at, double speed) {
      return (force_N - (device_.damping_Ns_per_m + hand.damping_Ns_per_m) * speed -
              hand.stiffness_N_per_m * at) /
             (device_.mass_kg + hand.mass_kg);
    };
    const double v1 = v, a1 = pull(x, v1);
    const double v2 = v + 0.5 * dt_s * a1, a2 = pull(x + 0.5 * dt_s * v1, v2);
    const double v3 = v + 0.5 * dt_s * a2, a3 = pull(x + 0.5 * dt_s * v2, v3);
    const double v4 = v + dt_s * a3, a4 = pull(x + dt_s * v3, v4);
    x += dt_s / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    v += dt_s / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }

  DeviceMechanics device_;
  double stiffness_N_per_m_;
  std::vector<LoopDamper> dampers_;
  double period_s_, delay_s_;
  int window_ = 1;
  int forces_;  // that have not yet acted, or act now
};

}  // namespace palpate::test
