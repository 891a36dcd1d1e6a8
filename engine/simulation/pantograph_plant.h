#pragma once

// A pantograph that a hand holds: what stands behind a simulated board.

#include <cstdint>
#include <optional>

#include "engine/devices/five_bar.h"
#include "engine/devices/stability_limits.h"  // HandImpedance
#include "engine/simulation/held_tip.h"

namespace palpate {

struct PantographSettings {
  FiveBarLinks links;
  double mass_kg = 0.1;           // of the device, at its tip
  double damping_Ns_per_m = 0.5;  // of the device
  HandImpedance hand;
  bool hand_probes = false;  // as ProbingHand; false: the hand stays where set_hand() puts it
};

// What the probes of a plant have found (probing_hand.h).
struct ProbeResult {
  std::uint64_t judged = 0;  // probes that were held to their end
  // The largest half of the way between the extremes of the tip at the end of a hold.
  double largest_amplitude_m = 0.0;
};

// A point mass at the tip, in the plane of the linkage, in a hand (HeldTip). The links have no
// mass. One thread owns an object.
class PantographPlant {
 public:
  // tip_m: the place of tip and hand at the beginning; within reach.
  PantographPlant(const PantographSettings& settings, const Vec2& tip_m);

  void set_hand(const Vec2& hand_m) { tip_.set_hand({hand_m.x(), hand_m.y(), 0.0}); }
  // Begins the probes, and the account, if PantographSettings::hand_probes is set; once.
  void begin_probes();
  // Moves on by dt_s, while the motors have constant torques. A tip that leaves the reach of the
  // links stops there.
  void advance(const Vec2& torques_Nm, double dt_s);

  const Vec2& joints_rad() const { return joints_rad_; }
  Vec2 tip_m() const { return tip_.position_m().head<2>(); }
  const HeldTip& tip() const { return tip_; }
  ProbeResult probes() const { return probes_; }
  const FiveBar& bar() const { return bar_; }

 private:
  void probe();

  PantographSettings settings_;
  FiveBar bar_;
  HeldTip tip_;
  Vec2 rest_m_;
  Vec2 joints_rad_;
  std::optional<double> probing_s_;  // the time since begin_probes()
  std::uint64_t probe_ = 0;
  bool was_judged_ = false;
  Vec2 low_m_, high_m_;
  ProbeResult probes_;
};

}  // namespace palpate
