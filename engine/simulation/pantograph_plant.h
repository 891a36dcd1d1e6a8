#pragma once

// A pantograph that a hand holds: what stands behind a simulated board.

#include "engine/devices/five_bar.h"
#include "engine/devices/stability_limits.h"  // HandImpedance
#include "engine/simulation/mass_damper.h"

namespace palpate {

struct PantographSettings {
  FiveBarLinks links;
  double mass_kg = 0.1;           // of the device, at its tip
  double damping_Ns_per_m = 0.5;  // of the device
  HandImpedance hand;
};

// A point mass at the tip, in the plane of the linkage, that a spring pulls to the place where the
// hand wants to be. The links have no mass. One thread owns an object.
class PantographPlant {
 public:
  // tip_m: the place of tip and hand at the beginning; within reach.
  PantographPlant(const PantographSettings& settings, const Vec2& tip_m);

  void set_hand(const Vec2& hand_m) { hand_m_ = hand_m; }
  // Moves on by dt_s, while the motors have constant torques. A tip that leaves the reach of the
  // links stops there.
  void advance(const Vec2& torques_Nm, double dt_s);

  const Vec2& joints_rad() const { return joints_rad_; }
  Vec2 tip_m() const { return body_.position_m().head<2>(); }
  const FiveBar& bar() const { return bar_; }

 private:
  PantographSettings settings_;
  FiveBar bar_;
  MassDamper body_;
  Vec2 hand_m_;
  Vec2 joints_rad_;
};

}  // namespace palpate
