#pragma once

// The largest stiffness at which a virtual wall is passive, and the largest at which it is stable,
// for a given device, coupling and servo.

#include <cstdint>
#include <optional>
#include <span>

#include "engine/devices/sampled_loop.h"
#include "geometry/base/result.h"
#include "haptics/effects/virtual_coupling.h"
#include "palpate/device.h"

namespace palpate {

// A hand that holds a device. Model: a spring and a damper connect the hand's mass to the position
// that the person intends. The defaults were fitted to one trial (Scientific Reports 8, 18004).
struct HandImpedance {
  double mass_kg = 0.55;           // >= 0; moves with the device
  double damping_Ns_per_m = 6.45;  // >= 0
  double stiffness_N_per_m = 135;  // >= 0
};

// The mechanical properties of a device along one axis.
struct DeviceMechanics {
  double mass_kg = 0.0;                              // > 0
  double damping_Ns_per_m = 0.0;                     // >= 0, viscous
  double encoder_quantum_m = 0.0;                    // >= 0: step of the positions; 0: no rounding
  double coulomb_friction_N = 0.0;                   // >= 0
  std::optional<HandImpedance> hand = std::nullopt;  // no value: nobody holds the device

  static DeviceMechanics of(const DeviceDescription& device) {
    return {device.mass_kg, device.damping_Ns_per_m, device.encoder_quantum_m,
            device.coulomb_friction_N};
  }
};

// The timing of a servo. The position at a sample determines a force. This force begins to act
// after the delay and is held for one period. The delay need not be a whole number of periods.
struct ServoTiming {
  double period_s = 1e-3;  // > 0, from sample to sample
  double delay_s = 0.0;    // from a sample to its force; 0 to kMostDelayTicks periods
  // The damper acts on the change of the position over this number of ticks, divided by their time;
  // 1 to kMostVelocityTicks.
  int velocity_ticks = 1;

  static constexpr int kMostDelayTicks = 256;  // 8 ms at 32 kHz
  static constexpr int kMostVelocityTicks = 64;
};

// The cause of the limit on the stiffness of a passive wall.
enum class PassivityBound : std::uint8_t {
  kSampling,  // the force held until the next sample generates energy
  kEncoder,   // rounded positions generate energy
  kDamper     // the coupling's damping is not below the device's, so no wall is passive
};

// "sampling", "encoder" or "damper".
const char* name_of(PassivityBound bound);

// A wall is passive if no motion of any hand extracts more energy from it than the hand put in. The
// limit of passive walls therefore does not depend on the hand. A wall is stable if the device,
// released or held by the given hand, comes to rest against it. Passivity is the stronger property.
// At a stiffness that feels hard, most devices are stable but not passive.
//
// Symbols: K stiffness and B damping of the wall, b damping of the device, T period, D delay.
struct StabilityLimits {
  // The limit due to sampling: (b - B) / held_time_s(), or 0 if this is negative. Without a delay
  // it follows from the criterion b > K T / 2 + |B| (Colgate & Schenkel 1997). With B = 0 it is
  // exact for any delay. With both a damper and a delay, each of the two is replaced by its worst
  // case; then the limit is sufficient for passivity, but not necessary.
  double passive_sampling_N_per_m = 0.0;
  // The limit due to the encoder: 2 f_c / D for steps of D and a Coulomb friction of f_c (Abbott &
  // Okamura 2005). The formula holds for B = 0; it does not include the force of a damper whose
  // velocity comes from rounded positions. Infinite if D = 0.
  double passive_encoder_N_per_m = 0.0;
  double passive_N_per_m = 0.0;  // smaller of these two limits; 0: no wall with this B is passive
  // How much rounding can have moved this limit and a stiffness that is compared with it (kRounding
  // in stability_limits.cpp).
  double passive_rounding_N_per_m = 0.0;
  PassivityBound passivity_bound = PassivityBound::kSampling;

  // The stiffness below which the sampled loop (device and hand, coupling, held force) has a
  // spectral radius < 1 (sampled_loop.h). The model leaves out friction and rounding, which
  // affect only the smallest motions. 0: no wall with this B is stable.
  double stable_N_per_m = 0.0;
  // An approximation of stable_N_per_m to first order in T and D: (b + B) / (T / 2 + D). Here b
  // includes the damping of the hand.
  double stable_first_order_N_per_m = 0.0;

  // A wall at exactly the limit is still passive. Consider a tick in which the device moves by dx,
  // with B = 0 and D = 0: the wall generates at most K |dx|^2 / 2, and the device dissipates at
  // least as much, namely b |dx|^2 / T. Rounding does not turn a wall at the limit into one beyond
  // it. This comparison decides wherever a wall is called passive.
  bool is_passive(double stiffness_N_per_m) const {
    return passivity_bound != PassivityBound::kDamper &&
           stiffness_N_per_m <= passive_N_per_m + passive_rounding_N_per_m;
  }
  // Whether a wall of some stiffness above 0 is passive.
  bool allows_passive_walls() const { return passive_N_per_m > 0.0; }
  bool is_stable(double stiffness_N_per_m) const { return stiffness_N_per_m < stable_N_per_m; }
};

// The time by which the held force of a passive wall is late in the worst motion: T / 2 + D for a
// delay of whole periods. In general it is (h + sqrt(h^2 + p (1 - p))) T / 2 with h = 1 / 2 + D / T
// and p the part of D / T that is not whole; up to 7 % more. Reason: a slow motion that alternates
// between two speeds, one in the part p of each period after a sample and one in the rest,
// generates the most energy for what the device dissipates.
double held_time_s(const ServoTiming& timing);

// Computes the limits of a wall with this damping. An Error names the number that is out of range.
// Not for the haptic thread. Thread-safe.
Result<StabilityLimits> stability_limits(const DeviceMechanics& device,
                                         double coupling_damping_Ns_per_m,
                                         const ServoTiming& timing);

// The largest magnitude of an eigenvalue of the matrix that maps the state from one tick in contact
// to the next. Motions decay if it is below 1. Infinite if the eigenvalues cannot be computed.
// Every number must be in its range. Not for the haptic thread. Thread-safe.
double spectral_radius(const DeviceMechanics& device, const CouplingSettings& coupling,
                       const ServoTiming& timing);

// stable_N_per_m for a wall with more dampers than that of the coupling. Every number must be in
// the range that stability_limits() checks. Not for the haptic thread. Thread-safe.
double stable_stiffness_N_per_m(const DeviceMechanics& device, std::span<const LoopDamper> dampers,
                                const ServoTiming& timing);

}  // namespace palpate
