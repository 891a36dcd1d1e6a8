#pragma once

// The strategy `a4-passive[:mJ]`: A4, whose turns add to the spring no more than a budget.
//
// The technique is ours. A4 (Lecuyer et al. 2005) turns the wall towards the motor while the hand
// presses. The motor then gives back more than the hand has put in: on one wall at depth d,
// K d^2 sin^2(a) / 2 for a turn by the contact angle a. Here a turn may add what is left of the
// budget of a contact; the rest moves the start of the spring inwards.
//
// The stretch of the spring is phi = F/K, F the force of spring and friction without the damper, K
// the stiffness of the contact. Without effects, phi is the lag, proxy minus device point. A start
// s, 0 <= s <= |phi|, leaves the depth e = |phi| - s. Spring, damper and friction give the part
// e/|phi| of their force to the motors. Other forces, such as texture's vibration, magnets and
// gravity, are given whole: they do not depend on the lag that a turn changes. With P the
// projection on the actuated axes, of 1, 2 or 3 motors,
//
//     U = K/2 e^2 |P phi|^2 / |phi|^2,
//
// the energy that the spring gives back while the hand lets go along the motors, if the proxy
// keeps its place. On one wall and one motor, U = K/2 e^2 cos^2(a).
//
// A turn, A4's elementary rotation about the proxy, ends a tick. With the hand where it is, the
// turned planes of the contact give a new stretch: the proxy goes to the point of these planes
// that is nearest to the device point; where friction holds the proxy, it stays. Let U' be the U
// of this stretch with the old start.
//   U' <= U: the turn takes U - U' from the spring and gives it back to the budget: in a contact,
//     the turns have then added that much less.
//   U' > U: the budget pays U' - U. What it cannot pay, a greater start takes away, so that the
//     spring has U plus what was left. With a budget of 0, the motors' force |P F| e/|phi| then
//     stays what it was.
// A turn can also let the proxy fall over an edge, which its planes do not show. In the next tick
// the lag then differs from the expected one by more than the step of the hand, as on fixed planes
// it never does. The most that this can have added to U counts as the turn's: U of the new lag and
// a step. What a fall takes gives nothing back, since the hand may have got it. (Not in a scene
// with moving bodies, which change the lag, too.)
//
// Pressing further meets the full K. A hand that retreats to the start takes it along (s falls to
// |phi|), so that the spring never pulls, and a contact that has ended leaves no start.
//
// A contact that begins at most kRest_s after the last one has ended inherits what that left of its
// budget, and never more than the budget; a later one has the whole budget. A tick with a bad
// sample ends no contact.
//
// 10 mJ, if no budget is given: a hand of 400 N/m that aims 10 mm deep into 1000 N/m gets more than
// nine tenths of A4's gain in penetration in a press of its own, and a third with 0 mJ. On a way
// round one of the paper's objects, hands are rarely off the walls for kRest_s, and one budget has
// to last for half a minute. It is spent in the first seconds, since A4's turns only ever raise U
// there; the gain is then half, which is that of 0 mJ.
//
// What is not promised: the projection itself is not passive. A mask of motors gives work along the
// wall, on curved surfaces, in corners, and with friction that begins to slide; so does this
// strategy. The energy of a press, turns and release on one wall is exact to K dx^2/2 of the
// largest step dx. A damper dissipates less where a start takes a part of it. A stiffness that
// changes, moving bodies and motors that turn with the device change U without a turn.
//
// The record's full force is the whole force, so that the missing force shows the price.

#include "haptics/strategies/haptic_settings.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// The spring of a contact as the motors have it.
struct MotorSpring {
  double stiffness_N_per_m = 0.0;
  double stretch_m = 0.0;        // |phi|
  double motor_stretch_m = 0.0;  // |P phi|

  // U with a start, J.
  double energy_J(double start_m) const noexcept;
  // The least start, but at least start_m, whose U is at most energy_J.
  double start_m(double start_m, double energy_J) const noexcept;
};

// The start of the spring and what is left of the budget. Does not allocate; safe on the haptic
// thread. One thread owns an object.
class TurnBudget {
 public:
  static constexpr double kRest_s = 1.0;

  explicit TurnBudget(double budget_J) : budget_J_(budget_J), left_J_(budget_J) {}

  // A tick in contact, before its force. time_s: of ticks, which does not fall. fall_step_m: above
  // 0 if the turn of the last tick let the proxy fall over an edge; the most by which the hand has
  // changed the stretch since.
  void touch(const MotorSpring& spring, double time_s, double fall_step_m = 0.0) noexcept;
  // After touch(): a turn gives the spring another stretch, with the hand where it is.
  void turn(const MotorSpring& turned) noexcept;
  // A tick without contact.
  void end_contact() noexcept;

  double start_m() const noexcept { return start_m_; }
  double left_J() const noexcept { return left_J_; }

 private:
  void fall(const MotorSpring& spring, double step_m) noexcept;
  void begin_contact(double time_s) noexcept;

  double budget_J_;
  double left_J_;
  double start_m_ = 0.0;
  double energy_J_ = 0.0;  // U of the last touch() or turn()
  bool in_contact_ = false;
  bool had_contact_ = false;
  double last_contact_s_ = 0.0;
};

std::unique_ptr<StrategyStep> make_a4_passive_step(const ActuationModel& actuation,
                                                   const HapticSettings& settings);

inline constexpr StrategyType kA4PassiveStrategy{
    .name = "a4-passive",
    .has_a4 = true,
    .parameter = StrategyParameter{.symbol = "mJ",
                                   .least = 0.0,
                                   .most = 1000.0,
                                   .example = 10.0,
                                   .meaning = "mJ is the energy that turns may add in a contact",
                                   .value_of_name_alone = 10.0},
    .make_step = make_a4_passive_step};

}  // namespace palpate
