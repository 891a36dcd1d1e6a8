#pragma once

// Restitution: a force pulse on impact.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "haptics/effects/effect.h"

namespace palpate {

// A force pulse on impact, in addition to the spring, as in event-based haptics (Kuchenbecker,
// Fiene and Niemeyer 2006, "Improving contact realism through event-based haptic feedback").
// Newton's law of restitution gives the impulse J = m (1 + e) v (Constantinescu, Salcudean and
// Croft 2005, "Haptic rendering of rigid contacts using impulsive and penalty forces"). The spring
// already gives the plastic part m v, so the pulse has J = e m v. Its shape is half a sine of the
// duration D: in a tick from t0 to t1, F = J (cos(pi t0 / D) - cos(pi t1 / D)) / (2 (t1 - t0)),
// whose time integral is J for any ticks.
//
// The pulse ends when the hand reverses its motion, so that the pulse can only brake the hand. Each
// material has one pulse: a tap on a material gives no pulse while the proxy already rests on that
// material elsewhere. Only the hand's speed counts, not that of a moving body.
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
    double pulse_s = 0.0;                                         // time since the pulse began
    double impulse_Ns = 0.0;                                      // of the whole pulse; 0: no pulse
    double next_tick = -std::numeric_limits<double>::infinity();  // the tick after the last contact
    double contact_s = 0.0;                                       // the time of the last contact
  };
  static constexpr ParameterKey kKeys[] = {
      {"restitution", "", 0.0, 1.0, offsetof(Parameters, restitution),
       ParameterKey::Role::kDeclares, "ratio of the speed after an impact to the speed before it"},
      {"impactMass", "kg", 0.0, 10.0, offsetof(Parameters, mass_kg), ParameterKey::Role::kOptional,
       "mass that hits the surface; at most the mass of the moving parts of the device", false,
       true},
      {"impactDuration", "s", 0.0, 1.0, offsetof(Parameters, duration_s),
       ParameterKey::Role::kOptional, "duration of the force pulse", false, true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State& s, EffectTick& tick) noexcept {
    const double approach_m_per_s = -tick.velocity_m_per_s.dot(tick.normal);
    // Chatter is not an impact: the proxy must have left the surface for longer than a pulse.
    const bool is_impact = free_s(s, tick) > p.duration_s;
    s.next_tick = tick.ticks + 1.0;
    s.contact_s = tick.time_s;
    if (is_impact) {
      // If a sample arrives early, its displacement took longer than its dt.
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

 private:
  // The length of the ticks without contact before this one. Ticks of one length are counted, which
  // is exact; measured times of other ticks are subtracted.
  static double free_s(const State& s, const EffectTick& tick) noexcept {
    const double ticks = tick.ticks - s.next_tick;
    if (!tick.has_measured_times || std::isinf(ticks) || ticks <= tick.steady_ticks) {
      return ticks * tick.dt_s;
    }
    return tick.time_s - tick.dt_s - s.contact_s;
  }
};

}  // namespace palpate
