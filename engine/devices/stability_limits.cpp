#include "engine/devices/stability_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace palpate {
namespace {

// A wall this soft, as a part of the first-order limit, is unstable only if its damping is too much
// for its period.
constexpr double kFirstPart = 1e-4;

// Smallest time constant m / b, in periods. The exponential of the plant's matrix loses as many
// digits as this number has: here half of a double's digits. No device is that light for its
// damping.
constexpr double kLeastPart = 0x1p-26;

LoopPlant plant_of(const DeviceMechanics& device) {
  LoopPlant plant{device.mass_kg, device.damping_Ns_per_m, 0.0};
  if (device.hand) {
    plant.mass_kg += device.hand->mass_kg;
    plant.damping_Ns_per_m += device.hand->damping_Ns_per_m;
    plant.stiffness_N_per_m = device.hand->stiffness_N_per_m;
  }
  return plant;
}

SampledLoop loop_of(const DeviceMechanics& device, const ServoTiming& timing) {
  return {plant_of(device), timing.period_s, TickDelay::of(timing.delay_s, timing.period_s)};
}

double first_order_N_per_m(const DeviceMechanics& device, std::span<const LoopDamper> dampers,
                           const ServoTiming& timing) {
  double damping = plant_of(device).damping_Ns_per_m;
  for (const LoopDamper& damper : dampers) damping += damper.damping_Ns_per_m;
  const TickDelay delay = TickDelay::of(timing.delay_s, timing.period_s);
  return damping / ((0.5 + delay.ticks()) * timing.period_s);
}

// Half an epsilon each, relative to b + B or to the quotient: the conversions of b, B and the rate
// from decimal digits, their difference, the period, the held time and the quotient; the conversion
// of the stiffness, and the quotient and the product of its relief; eleven in all.
constexpr double kRounding = 6.0 * std::numeric_limits<double>::epsilon();

void find_passive(const DeviceMechanics& device, double damping, double held_s,
                  StabilityLimits& limits) {
  const double left_rounding = kRounding * (device.damping_Ns_per_m + damping);
  const double difference = device.damping_Ns_per_m - damping;
  const double left = difference > left_rounding ? difference : std::min(difference, 0.0);
  limits.passive_sampling_N_per_m = std::max(0.0, left / held_s);
  limits.passive_encoder_N_per_m = std::numeric_limits<double>::infinity();
  if (device.encoder_quantum_m > 0.0) {
    limits.passive_encoder_N_per_m = 2.0 * device.coulomb_friction_N / device.encoder_quantum_m;
  }
  limits.passive_N_per_m =
      std::min(limits.passive_sampling_N_per_m, limits.passive_encoder_N_per_m);
  const bool is_by_encoder = limits.passive_encoder_N_per_m < limits.passive_sampling_N_per_m;
  limits.passive_rounding_N_per_m =
      is_by_encoder ? kRounding * limits.passive_encoder_N_per_m : left_rounding / held_s;
  if (left <= 0.0) {
    limits.passivity_bound = PassivityBound::kDamper;
  } else if (is_by_encoder) {
    limits.passivity_bound = PassivityBound::kEncoder;
  }
}

struct Checked {
  const char* name;
  double value;
  bool may_be_zero;
};

std::optional<Error> check(const Checked& number) {
  const bool is_good = std::isfinite(number.value) &&
                       (number.value > 0.0 || (number.may_be_zero && number.value == 0.0));
  if (is_good) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument, "", number.name,
               "is " + std::to_string(number.value) + "; expected a finite number " +
                   (number.may_be_zero ? "of at least 0" : "above 0"),
               "state the value in SI units"};
}

std::optional<Error> check_timing(const ServoTiming& timing) {
  const double ticks = timing.delay_s / timing.period_s;
  constexpr double kMostTicks = ServoTiming::kMostDelayTicks * (1.0 + kRounding);
  if (!(ticks >= 0.0 && ticks <= kMostTicks)) {
    return Error{ErrorCode::kInvalidArgument, "", "delay",
                 "is " + std::to_string(timing.delay_s) + " s, " + std::to_string(ticks) +
                     " periods; expected 0 to " + std::to_string(ServoTiming::kMostDelayTicks) +
                     " periods",
                 "state the delay in seconds, or choose a lower rate"};
  }
  if (timing.velocity_ticks >= 1 && timing.velocity_ticks <= ServoTiming::kMostVelocityTicks) {
    return std::nullopt;
  }
  return Error{ErrorCode::kInvalidArgument, "", "window of the velocity",
               "is " + std::to_string(timing.velocity_ticks) + " ticks; expected 1 to " +
                   std::to_string(ServoTiming::kMostVelocityTicks),
               "state the window in whole ticks"};
}

std::optional<Error> check_all(const DeviceMechanics& device, double coupling_damping_Ns_per_m,
                               const ServoTiming& timing) {
  const HandImpedance hand = device.hand.value_or(HandImpedance{0.0, 0.0, 0.0});
  for (const Checked& number : {Checked{"mass", device.mass_kg, false},
                                {"damping", device.damping_Ns_per_m, true},
                                {"encoder quantum", device.encoder_quantum_m, true},
                                {"Coulomb friction", device.coulomb_friction_N, true},
                                {"mass of the hand", hand.mass_kg, true},
                                {"damping of the hand", hand.damping_Ns_per_m, true},
                                {"stiffness of the hand", hand.stiffness_N_per_m, true},
                                {"damping of the coupling", coupling_damping_Ns_per_m, true},
                                {"period", timing.period_s, false}}) {
    if (std::optional<Error> error = check(number)) return error;
  }
  return check_timing(timing);
}

}  // namespace

const char* name_of(PassivityBound bound) {
  switch (bound) {
    case PassivityBound::kEncoder:
      return "encoder";
    case PassivityBound::kDamper:
      return "damper";
    case PassivityBound::kSampling:
      break;
  }
  return "sampling";
}

double held_time_s(const ServoTiming& timing) {
  const TickDelay delay = TickDelay::of(timing.delay_s, timing.period_s);
  const double mean = 0.5 + delay.ticks();
  if (delay.part == 0.0) return mean * timing.period_s;
  const double spread = delay.part * (1.0 - delay.part);
  return 0.5 * (mean + std::sqrt(mean * mean + spread)) * timing.period_s;
}

double spectral_radius(const DeviceMechanics& device, const CouplingSettings& coupling,
                       const ServoTiming& timing) {
  const LoopDamper damper{coupling.damping_Ns_per_m, timing.velocity_ticks};
  return loop_of(device, timing).spectral_radius(coupling.stiffness_N_per_m, {&damper, 1});
}

double stable_stiffness_N_per_m(const DeviceMechanics& device, std::span<const LoopDamper> dampers,
                                const ServoTiming& timing) {
  const double first_order = first_order_N_per_m(device, dampers, timing);
  if (!(first_order > 0.0)) return 0.0;
  const SampledLoop loop = loop_of(device, timing);
  if (!(loop.spectral_radius(kFirstPart * first_order, dampers) < 1.0)) return 0.0;
  return loop.smallest_critical_N_per_m(dampers);
}

Result<StabilityLimits> stability_limits(const DeviceMechanics& device,
                                         double coupling_damping_Ns_per_m,
                                         const ServoTiming& timing) {
  if (const auto error = check_all(device, coupling_damping_Ns_per_m, timing)) return *error;
  const LoopPlant plant = plant_of(device);
  if (!(plant.mass_kg >= kLeastPart * plant.damping_Ns_per_m * timing.period_s)) {
    return Error{ErrorCode::kInvalidArgument, "", "mass",
                 "is too small for the damping, which stops it within 2^-26 of a period",
                 "state the mass and the damping of the device at its tip, in SI units"};
  }
  StabilityLimits limits;
  find_passive(device, coupling_damping_Ns_per_m, held_time_s(timing), limits);
  const LoopDamper damper{coupling_damping_Ns_per_m, timing.velocity_ticks};
  limits.stable_first_order_N_per_m = first_order_N_per_m(device, {&damper, 1}, timing);
  limits.stable_N_per_m = stable_stiffness_N_per_m(device, {&damper, 1}, timing);
  return limits;
}

}  // namespace palpate
