#include "haptics/spring_restart.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double SpringRestart::factor(const Tick& tick) noexcept {
  if (!(tick.spring_N > 0.0)) {
    last_spring_N_ = withheld_N_ = returning_N_ = returning_J_ = 0.0;
    was_interrupted_ = tick.is_interrupted;
    tank_J_ = std::min(kTank_J, tank_J_ + kTank_J / kRefill_s * tick.step_s);
    return 1.0;
  }
  if (tick.nodes_moved) tank_J_ = std::min(kTank_J, tank_J_ + kNodePower_W * tick.step_s);
  if (tick.is_interrupted) {
    if (!was_interrupted_) interrupt(tick.stiffness_N_per_m);
    returned_s_ = 0.0;
  }
  if (was_interrupted_ && !tick.is_interrupted && tick.spring_N > kFallen * interrupted_N_) {
    returning_J_ *= kFallenShare;
  }
  const double unexplained_N = tick.spring_N - last_spring_N_ - explained_N(tick);
  if (tick.is_interrupted) {
    withheld_N_ = tick.spring_N;
  } else {
    if (unexplained_N > kRounding * tick.spring_N) {
      const double now_N = std::max(0.0, tick.spring_N - unexplained_N - withheld_N_);
      withheld_N_ += unexplained_N - take_N(now_N, unexplained_N, tank_J_, tick.stiffness_N_per_m);
    }
    withheld_N_ = std::max(withheld_N_, (1.0 - tick.share) * tick.spring_N);
    withheld_N_ = std::min(withheld_N_, tick.spring_N);
    if (returning_N_ > 0.0) give_back(tick);
  }
  was_interrupted_ = tick.is_interrupted;
  last_spring_N_ = tick.spring_N;
  if (withheld_N_ == 0.0) return 1.0;
  return std::max(0.0, (tick.spring_N - withheld_N_) / tick.spring_N);
}

// How far the force of the spring may grow by the way of the hand.
double SpringRestart::explained_N(const Tick& tick) const noexcept {
  if (was_interrupted_) return 0.0;
  const double way_N = tick.stiffness_N_per_m * tick.way_m;
  if (!tick.is_gap) return way_N;
  const double now_N = last_spring_N_ - withheld_N_;
  const double work_J = std::max(0.0, tick.work_J);
  return std::min(way_N, growth_N(now_N, way_N, work_J, tick.stiffness_N_per_m));
}

// How far a force may grow, at most by `most_N`, so that the energy that the spring stores grows by
// at most energy_J: u at the force f takes (f u + u^2 / 2) / K.
double SpringRestart::growth_N(double force_N, double most_N, double energy_J,
                               double stiffness_N_per_m) noexcept {
  const double root_N = std::sqrt(force_N * force_N + 2.0 * energy_J * stiffness_N_per_m) - force_N;
  return std::min(most_N, root_N);
}

// Grows a force as far as a store pays for it.
double SpringRestart::take_N(double force_N, double most_N, double& store_J,
                             double stiffness_N_per_m) noexcept {
  const double growth = growth_N(force_N, most_N, store_J, stiffness_N_per_m);
  store_J = std::max(0.0, store_J - (force_N + 0.5 * growth) * growth / stiffness_N_per_m);
  return growth;
}

// What the spring had stored comes back.
void SpringRestart::interrupt(double stiffness_N_per_m) noexcept {
  const double now_N = last_spring_N_ - withheld_N_;
  if (!(now_N > 0.0)) return;
  // What an interruption before this one has not given back yet still counts.
  returning_N_ = std::max(returning_N_, now_N);
  returning_J_ += 0.5 * now_N * now_N / stiffness_N_per_m;
  interrupted_N_ = last_spring_N_;
}

void SpringRestart::give_back(const Tick& tick) noexcept {
  returned_s_ += tick.step_s;
  const double share = std::min(1.0, returned_s_ / kReturn_s);
  const double now_N = tick.spring_N - withheld_N_;
  const double wanted_N = std::min(tick.spring_N, share * returning_N_) - now_N;
  if (wanted_N > 0.0 && returning_J_ > tick.owed_J) {
    double left_J = returning_J_ - tick.owed_J;
    withheld_N_ -= take_N(now_N, wanted_N, left_J, tick.stiffness_N_per_m);
    returning_J_ = left_J + tick.owed_J;
    withheld_N_ = withheld_N_ > kRounding * tick.spring_N ? withheld_N_ : 0.0;
  }
  if (share == 1.0 || returning_J_ == 0.0) returning_N_ = returning_J_ = 0.0;
}

}  // namespace palpate
