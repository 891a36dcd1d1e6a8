#pragma once

// The crispness of a tap.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "haptics/effects/effect.h"

namespace palpate {

// A force pulse on impact, beside the spring, as event-based haptics has it (Kuchenbecker, Fiene
// and Niemeyer 2006, "Improving contact realism through event-based haptic feedback"), with the
// impulse that Newton's restitution asks for (Constantinescu, Salcudean and Croft 2005, "Haptic
// rendering of rigid contacts using impulsive and penalty forces": J = m (1 + e) v). Of that the
// spring gives the plastic part m v, so the pulse has J = e m v, as half a sine of the duration D:
// in a tick from t0 to t1, F = J (cos(pi t0 / D) - cos(pi t1 / D)) / (2 (t1 - t0)), which adds up
// to J whatever the ticks. It ends when the hand turns round: it only ever brakes. A material has
// one pulse: who rests on it and taps it elsewhere feels none. Speeds are the hand's alone,
// whatever the body does.
struct RestitutionEffect {
  static constexpr std::string_view kName = "restitution";
  static constexpr EffectStage kStage = EffectStage::kForceAdd;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsVelocity;

  struct Parameters {
    double restitution = 0.0;
    double mass_kg = 0.05;
    double duration_s = 0.005;
  };
  struct State {
    double pulse_s = 0.0;     // since it began
    double impulse_Ns = 0.0;  // of the whole pulse; 0: there is none
    double next_tick = -std::numeric_limits<double>::infinity();  // after the last touch
  };
  static constexpr ParameterKey kKeys[] = {
      {"restitution", "", 0.0, 1.0, offsetof(Parameters, restitution),
       ParameterKey::Role::kCallsFor, "ratio of the speed after an impact to the speed before it"},
      {"impactMass", "kg", 0.0, 10.0, offsetof(Parameters, mass_kg), ParameterKey::Role::kOptional,
       "mass that hits the surface; at most the mass of the moving parts of the device", false,
       true},
      {"impactDuration", "s", 0.0, 1.0, offsetof(Parameters, duration_s),
       ParameterKey::Role::kOptional, "duration of the force pulse", false, true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State& s, EffectTick& tick) noexcept {
    const double approach_m_per_s = -tick.velocity_m_per_s.dot(tick.normal);
    // Chatter is no tap: the surface must have been left for longer than a pulse.
    const bool is_impact = (tick.ticks - s.next_tick) * tick.dt_s > p.duration_s;
    s.next_tick = tick.ticks + 1.0;
    if (is_impact) {
      // A sample that comes early has gone its way in more time than its dt says.
      const double speed_m_per_s = approach_m_per_s * tick.dt_s / tick.longest_dt_s;
      s.pulse_s = 0.0;
      s.impulse_Ns = p.restitution * p.mass_kg * std::max(0.0, speed_m_per_s);
    }
    if (approach_m_per_s <= 0.0) s.impulse_Ns = 0.0;
    if (s.impulse_Ns == 0.0) return false;
    const double begin = s.pulse_s / p.duration_s;
    s.pulse_s += tick.dt_s;
    const double end = std::min(1.0, s.pulse_s / p.duration_s);
    const double part =
        0.5 * (std::cos(std::numbers::pi * begin) - std::cos(std::numbers::pi * end));
    tick.force_N += tick.share * s.impulse_Ns * part / tick.dt_s * tick.normal;
    if (end == 1.0) s.impulse_Ns = 0.0;
    return true;
  }
};

}  // namespace palpate
