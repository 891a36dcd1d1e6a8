#pragma once

// How much energy a force may give to the hand by design.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "geometry/base/types.h"
#include "haptics/force_sources.h"

namespace palpate {

// A source may give tank_J at once, and power_W for ever: the tank fills with this power, and with
// the work that the hand does against the source.
struct EnergyBudget {
  double tank_J = 0.0;   // 0 to kMost_J
  double power_W = 0.0;  // 0 to kMost_W

  // The largest default: no setting lets a source give more than a body's weight does by default.
  // A tip of 0.1 kg (kBareTip) that gets 0.11 J at once is as fast as the rule *speed* allows
  // (GovernorLimits::kTopSpeed_m_per_s), and 1 W at 10 N moves a hand at 0.1 m/s, half of what the
  // rule *start* calls calm. So these rules bound what a larger budget could do.
  static constexpr double kMost_J = 1.0;
  static constexpr double kMost_W = 1.0;

  constexpr bool is_in_range() const {
    return tank_J >= 0.0 && tank_J <= kMost_J && power_W >= 0.0 && power_W <= kMost_W;
  }
  bool operator==(const EnergyBudget&) const = default;
};

// By EnergySource. A press on the paper's objects gives up to 103 mJ by missing motors and A4
// (docs/inside/haptics.md); a budget of two presses, and one a second.
struct EnergyBudgets {
  std::array<EnergyBudget, kEnergySourceCount> of = {{
      {0.25, 0.25},  // motors
      {0.05, 0.5},   // nodes
      {0.02, 0.5},   // vibration
      {0.05, 0.1},   // restitution
      {0.05, 0.1},   // magnet
      {1.0, 1.0},    // gravity: a body that is lowered by 0.1 m at 10 N
      {0.02, 0.02},  // other
  }};

  bool operator==(const EnergyBudgets&) const = default;
};

// Sums what each source gives, and what exceeds the budgets.
//
// One thread owns an object. No function allocates or throws.
class GivenByDesign {
 public:
  explicit GivenByDesign(const EnergyBudgets& budgets) noexcept : budgets_(budgets) { clear(); }

  struct Work {
    double even_J = 0.0;    // of the commanded force, without delay and hold (PassivityControl)
    double motors_J = 0.0;  // what the motors cannot push, with the opposite sign
    std::array<double, kGivingEffects.size()> effects_J = {};
    double nodes_J = 0.0;
    bool in_contact = false;
    // What the spring of the contact can have stored at most.
    double most_stored_J = std::numeric_limits<double>::infinity();
    double step_s = 0.0;
  };

  // Adds the work between two samples. Returns what exceeds the budgets, J, >= 0.
  double add(const Work& work) noexcept;
  void clear() noexcept;
  // The sums since the beginning, J, by EnergySource.
  const std::array<double, kEnergySourceCount>& given_J() const noexcept { return given_J_; }

 private:
  double take(EnergySource source, double work_J, double step_s) noexcept;
  double take_rest(double work_J, const Work& work) noexcept;

  EnergyBudgets budgets_;
  std::array<double, kEnergySourceCount> left_J_{};
  std::array<double, kEnergySourceCount> given_J_{};
  double stored_J_ = 0.0;  // what the hand has put into this contact
  double free_s_ = 0.0;    // since the last contact
};

}  // namespace palpate
