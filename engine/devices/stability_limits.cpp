#include "engine/devices/stability_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

// Start of the search as a fraction of the first-order limit, and its factor. A loop that is
// unstable at the start has too much damping for its period.
constexpr double kFirstPart = 1e-4;
constexpr double kStride = 1.1;

// Halvings that reduce one step of the search to the precision of double.
constexpr int kHalvings = 52;

// Smallest time constant m / b, in periods. The exponential of the plant's matrix loses as many
// digits as this number has: here half of a double's digits. No device is that light for its
// damping.
constexpr double kLeastPart = 0x1p-26;

struct Plant {
  double mass_kg, damping_Ns_per_m, stiffness_N_per_m;
};

Plant plant_of(const DeviceMechanics& device) {
  Plant plant{device.mass_kg, device.damping_Ns_per_m, 0.0};
  if (device.hand) {
    plant.mass_kg += device.hand->mass_kg;
    plant.damping_Ns_per_m += device.hand->damping_Ns_per_m;
    plant.stiffness_N_per_m = device.hand->stiffness_N_per_m;
  }
  return plant;
}

// One period of the state (x, v T, f T^2 / m): the plant under a held force, by the matrix
// exponential. All components are lengths, so the entries have similar magnitudes.
Mat3 plant_step(const Plant& plant, double period_s) {
  const double per_N = period_s * period_s / plant.mass_kg;
  Mat3 rate;
  rate << 0.0, 1.0, 0.0,                                                                          //
      -per_N * plant.stiffness_N_per_m, -plant.damping_Ns_per_m * period_s / plant.mass_kg, 1.0,  //
      0.0, 0.0, 0.0;
  return rate.exp();
}

// The discrete plant, computed once; the search closes the loop for many stiffnesses.
class SampledLoop {
 public:
  SampledLoop(const DeviceMechanics& device, const ServoTiming& timing)
      : step_(plant_step(plant_of(device), timing.period_s)),
        m_per_N_(timing.period_s * timing.period_s / plant_of(device).mass_kg),
        period_s_(timing.period_s),
        delay_ticks_(timing.delay_ticks) {}

  // State: x, v T, x of the previous tick, and the delayed forces as f T^2 / m, the latest first.
  // The force of a tick is -K x - B (x - x_previous) / T.
  double spectral_radius(const CouplingSettings& coupling) const {
    const double of_previous = m_per_N_ * coupling.damping_Ns_per_m / period_s_;
    const double of_now = -m_per_N_ * coupling.stiffness_N_per_m - of_previous;
    Eigen::MatrixXd tick = Eigen::MatrixXd::Zero(3 + delay_ticks_, 3 + delay_ticks_);
    tick.topLeftCorner<2, 2>() = step_.topLeftCorner<2, 2>();
    tick(2, 0) = 1.0;
    const auto add_force = [&](Eigen::Index row, double gain) {
      tick(row, 0) += gain * of_now;
      tick(row, 2) += gain * of_previous;
    };
    if (delay_ticks_ == 0) {
      for (const int row : {0, 1}) add_force(row, step_(row, 2));
    } else {
      add_force(3, 1.0);
      for (int d = 1; d < delay_ticks_; ++d) tick(3 + d, 2 + d) = 1.0;
      tick.block<2, 1>(0, 2 + delay_ticks_) = step_.block<2, 1>(0, 2);
    }
    // The eigenvalues of a matrix with overflowed entries are meaningless.
    if (!tick.allFinite()) return std::numeric_limits<double>::infinity();
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(tick, /* computeEigenvectors = */ false);
    if (solver.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    return solver.eigenvalues().cwiseAbs().maxCoeff();
  }
  bool is_stable(const CouplingSettings& coupling) const { return spectral_radius(coupling) < 1.0; }

 private:
  Mat3 step_;
  double m_per_N_;
  double period_s_;
  int delay_ticks_;
};

// The smallest unstable stiffness, approached from below.
double stable_limit(const SampledLoop& loop, double damping_Ns_per_m, double first_order_N_per_m) {
  double stable = 0.0;
  double unstable = kFirstPart * first_order_N_per_m;
  if (!loop.is_stable({unstable, damping_Ns_per_m})) return 0.0;
  while (loop.is_stable({unstable, damping_Ns_per_m})) {
    stable = unstable;
    unstable *= kStride;
  }
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (stable + unstable);
    (loop.is_stable({middle, damping_Ns_per_m}) ? stable : unstable) = middle;
  }
  return stable;
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
  if (timing.delay_ticks >= 0 && timing.delay_ticks <= ServoTiming::kMostDelayTicks) {
    return std::nullopt;
  }
  return Error{ErrorCode::kInvalidArgument, "", "delay",
               "is " + std::to_string(timing.delay_ticks) + " ticks; expected 0 to " +
                   std::to_string(ServoTiming::kMostDelayTicks),
               "state the delay in whole ticks"};
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

double spectral_radius(const DeviceMechanics& device, const CouplingSettings& coupling,
                       const ServoTiming& timing) {
  return SampledLoop(device, timing).spectral_radius(coupling);
}

Result<StabilityLimits> stability_limits(const DeviceMechanics& device,
                                         double coupling_damping_Ns_per_m,
                                         const ServoTiming& timing) {
  if (const auto error = check_all(device, coupling_damping_Ns_per_m, timing)) return *error;
  const Plant plant = plant_of(device);
  if (!(plant.mass_kg >= kLeastPart * plant.damping_Ns_per_m * timing.period_s)) {
    return Error{ErrorCode::kInvalidArgument, "", "mass",
                 "is too small for the damping, which stops it within 2^-26 of a period",
                 "state the mass and the damping of the device at its tip, in SI units"};
  }
  // Mean age of the held force.
  const double held_s = (0.5 + timing.delay_ticks) * timing.period_s;
  StabilityLimits limits;
  find_passive(device, coupling_damping_Ns_per_m, held_s, limits);
  limits.stable_first_order_N_per_m = (plant.damping_Ns_per_m + coupling_damping_Ns_per_m) / held_s;
  if (limits.stable_first_order_N_per_m > 0.0) {
    limits.stable_N_per_m = stable_limit(SampledLoop(device, timing), coupling_damping_Ns_per_m,
                                         limits.stable_first_order_N_per_m);
  }
  return limits;
}

}  // namespace palpate
