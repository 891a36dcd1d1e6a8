#pragma once

// The spring of a contact after an interruption, a jump of a node, or a change of its stiffness.

#include "geometry/base/types.h"

namespace palpate {

// A spring that is K e deep has stored K e^2 / 2, and a hand that lets go gets it. If the hand has
// not put it in, because no force acted while it fell in, because a node jumped onto it, or because
// K has grown, then the motors give it. So the spring starts again from what the hand has put in:
// its start moves inwards by r / K, and the force of depth e is K e - r.
//
// - In a tick, the force K e may grow by K |dx|, dx the way of the hand. What it grows beyond is
//   paid from a tank of kTank_J; the rest is withheld: r grows by it. Moving nodes fill the tank
//   with kNodePower_W, so that a node that moves steadily pushes with this power.
// - After a gap without samples the hand has fallen in against the force f that acted, not against
//   the spring: the force may grow so that the stored energy grows by the work of f.
// - An interruption takes the whole force away. Afterwards it returns, within kReturn_s, as far as
//   it was before, and as far as the energy that was stored pays for it, less what the motors have
//   given too much since. What the spring has gained meanwhile stays withheld.
// - While the rules *start* and *ease* let the force grow, what they hold back stays withheld.
// - r never exceeds K e: the start follows a hand that retreats, and a new contact has the full
//   force.
//
// One thread owns an object. No function allocates or throws.
class SpringRestart {
 public:
  static constexpr double kTank_J = 1e-3;
  static constexpr double kRefill_s = 1.0;  // without contact, from empty to full
  static constexpr double kNodePower_W = 0.5;
  static constexpr double kReturn_s = 100e-3;
  // Of a hand that has fallen in by more than a quarter of the depth, this share of the energy
  // comes back: it is fast, and the delay adds to what it gets.
  static constexpr double kFallenShare = 0.8;
  static constexpr double kFallen = 1.25;
  // A growth below this share of the force is rounding: way and lag are differences of positions,
  // which may be a thousand times as large and round by 2^-53 of their size.
  static constexpr double kRounding = 0x1p-30;

  struct Tick {
    double stiffness_N_per_m = 0.0;
    double spring_N = 0.0;        // K e; 0: no contact
    double way_m = 0.0;           // of the hand, since the last good sample
    double work_J = 0.0;          // of the hand against the motors on this way
    bool is_gap = false;          // there were ticks without a sample on this way
    bool is_interrupted = false;  // the force of this tick is zero
    bool nodes_moved = false;
    double share = 1.0;   // of the force, what the rules *start* and *ease* allow
    double owed_J = 0.0;  // what the motors have given too much (PassivityControl)
    double step_s = 0.0;
  };

  // Returns the factor of the force, (K e - r) / (K e): 1, to the bit, if nothing is withheld.
  double factor(const Tick& tick) noexcept;
  double withheld_N() const noexcept { return withheld_N_; }
  void clear() noexcept { *this = {}; }

 private:
  double explained_N(const Tick& tick) const noexcept;
  static double growth_N(double force_N, double most_N, double energy_J,
                         double stiffness_N_per_m) noexcept;
  static double take_N(double force_N, double most_N, double& store_J,
                       double stiffness_N_per_m) noexcept;
  void interrupt(double stiffness_N_per_m) noexcept;
  void give_back(const Tick& tick) noexcept;

  double last_spring_N_ = 0.0;
  double withheld_N_ = 0.0;  // r
  bool was_interrupted_ = false;
  // The force before the interruption, and what is left of its energy; 0: nothing returns.
  double returning_N_ = 0.0;
  double returning_J_ = 0.0;
  double interrupted_N_ = 0.0;  // the whole force of the spring then
  double returned_s_ = 0.0;
  double tank_J_ = kTank_J;
};

}  // namespace palpate
