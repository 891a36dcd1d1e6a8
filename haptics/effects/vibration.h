#pragma once

// Vibration: a sinusoidal force.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptics/effects/effect.h"

namespace palpate {

// A sinusoidal force F = A sin(2 pi f t) N along the contact normal N, while the proxy is in
// contact or only while it slides. This is open-loop vibration feedback (Okamura, Dennerlein and
// Howe 1998, "Vibration feedback models for virtual environments"). The amplitude rises over the
// first period. It falls over one period when sliding ends, and at once when the contact ends. The
// force may attract the hand with a strength of up to its amplitude. In a tick that is half a
// period long or longer, the force is zero, because it would alias to another frequency. With
// measured times, phase and strength go on in such a tick, so that a gap between two samples does
// not shift the phase; without, the vibration begins anew after it.
struct VibrationEffect {
  static constexpr std::string_view kName = "vibration";
  static constexpr EffectStage kStage = EffectStage::kForceAdd;
  static constexpr std::uint32_t kNeeds = kNeedsContact;

  struct Parameters {
    double frequency_Hz = 0.0;
    double amplitude_N = 0.0;
    double when = 0.0;  // 0: in contact, 1: while sliding
  };
  struct State {
    double phase = 0.0;       // in periods, [0, 1)
    double strength = 0.0;    // factor of the amplitude, [0, 1]
    double last_tick = -2.0;  // the last tick in which the effect ran
  };
  static constexpr ParameterKey kKeys[] = {
      {"vibrationFrequency", "Hz", 0.0, 5000.0, offsetof(Parameters, frequency_Hz),
       ParameterKey::Role::kRequired, "frequency of the vibration", false, true},
      {"vibrationAmplitude", "N", 0.0, 100.0, offsetof(Parameters, amplitude_N),
       ParameterKey::Role::kDeclares, "amplitude of the vibration force"},
      {"vibrationWhen",
       "",
       0.0,
       1.0,
       offsetof(Parameters, when),
       ParameterKey::Role::kOptional,
       "condition under which the material vibrates",
       false,
       false,
       ParameterKey::Kind::kChoice,
       {"contact", "sliding"}}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State& s, EffectTick& tick) noexcept {
    const double periods = p.frequency_Hz * tick.dt_s;
    const bool aliases = periods >= 0.5;
    if (aliases && !tick.has_measured_times) return false;
    if (tick.ticks != s.last_tick + 1.0) s = {};
    s.last_tick = tick.ticks;
    const bool is_wanted = p.when == 0.0 || tick.slid;
    s.strength = std::clamp(s.strength + (is_wanted ? periods : -periods), 0.0, 1.0);
    if (s.strength == 0.0) {
      s.phase = 0.0;
      return false;
    }
    s.phase += periods;
    s.phase -= std::floor(s.phase);
    if (aliases) return false;
    tick.force_N += tick.share * p.amplitude_N * s.strength *
                    std::sin(2.0 * std::numbers::pi * s.phase) * tick.normal;
    return true;
  }
};

}  // namespace palpate
