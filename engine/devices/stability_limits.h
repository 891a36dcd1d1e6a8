#pragma once

// How stiff a virtual wall may be for a device, a coupling and a servo.

#include <cstdint>
#include <optional>

#include "geometry/base/result.h"
#include "haptics/effects/virtual_coupling.h"
#include "palpate/device.h"

namespace palpate {

// A hand that holds a device, as a spring and a damper to where it wants to be: that of one fitted
// trial (Scientific Reports 8, 18004).
struct HandImpedance {
  double mass_kg = 0.55;           // >= 0; moves with the device
  double damping_Ns_per_m = 6.45;  // >= 0
  double stiffness_N_per_m = 135;  // >= 0
};

// One axis of a device.
struct DeviceMechanics {
  double mass_kg = 0.0;             // > 0
  double damping_Ns_per_m = 0.0;    // >= 0, viscous
  double encoder_quantum_m = 0.0;   // >= 0: what positions are rounded to; 0: to nothing
  double coulomb_friction_N = 0.0;  // >= 0
  std::optional<HandImpedance> hand = std::nullopt;  // none: nobody holds it

  static DeviceMechanics of(const DeviceDescription& device) {
    return {device.mass_kg, device.damping_Ns_per_m, device.encoder_quantum_m,
            device.coulomb_friction_N};
  }
};

// A force is made from the position read at the beginning of a period and held for the next one.
struct ServoTiming {
  double period_s = 1e-3;  // > 0
  int delay_ticks = 0;     // 0 to kMostDelayTicks: whole periods before the force is there

  static constexpr int kMostDelayTicks = 64;
};

// What keeps a wall from being stiffer and still passive.
enum class PassivityBound : std::uint8_t {
  kSampling,  // the energy that the wait for the next reading gives away
  kEncoder,   // the energy that rounded readings give away
  kDamper     // nothing is left: the coupling's damper asks for more than the device's damping
};

// "sampling", "encoder" or "damper".
const char* name_of(PassivityBound bound);

// Passive: whatever the hand does, it never gets more energy out of the wall than it put in. This
// bound is of the device alone, as the hand may be any. Stable: this device, held so or not at all,
// comes to rest where it is pressed. Passive is the promise; stable is wider, and all that most
// devices keep at a stiffness that is felt as hard.
struct StabilityLimits {
  // 2 (b - B) / ((1 + 2 d) T) for a delay of d periods, and no less than 0. With d = 0 this is b >
  // K T / 2 + |B| (Colgate & Schenkel 1997); otherwise their criterion with the wall and the delay
  // put in, whose two terms are each bounded where they are largest: enough, if not necessary.
  double passive_sampling_N_per_m = 0.0;
  // 2 f_c / D, of an encoder that counts in steps of D on a device with Coulomb friction f_c
  // (Abbott & Okamura 2005, for B = 0; what a damper makes of rounded readings is not in it).
  // Infinite without steps.
  double passive_encoder_N_per_m = 0.0;
  double passive_N_per_m = 0.0;  // the smaller one; 0: no wall with this B is
  PassivityBound passivity_bound = PassivityBound::kSampling;

  // Below it the loop of plant, reading, coupling and held force has a spectral radius < 1, found
  // by bisection. Without friction and rounding, both of which only limit how small motions end. 0:
  // no wall with this B is stable.
  double stable_N_per_m = 0.0;
  // The same to first order in T: (b + B) / (T / 2 + d T), b with the hand's.
  double stable_first_order_N_per_m = 0.0;

  // At the limit itself a tick gives away K |dx|^2 / 2, and the device takes b |dx|^2 / T: as much.
  bool is_passive(double stiffness_N_per_m) const {
    return passivity_bound != PassivityBound::kDamper && stiffness_N_per_m <= passive_N_per_m;
  }
  bool is_stable(double stiffness_N_per_m) const { return stiffness_N_per_m < stable_N_per_m; }
};

// Of a wall with this damping, for the backward difference that VirtualCoupling takes. An Error
// names the number that is out of range. Not for the haptic thread. Thread-safe.
Result<StabilityLimits> stability_limits(const DeviceMechanics& device,
                                         double coupling_damping_Ns_per_m,
                                         const ServoTiming& timing);

// Largest magnitude of an eigenvalue of one tick in contact: below 1, a motion dies out. Requires
// numbers in their ranges.
double spectral_radius(const DeviceMechanics& device, const CouplingSettings& coupling,
                       const ServoTiming& timing);

}  // namespace palpate
