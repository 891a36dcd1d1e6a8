#include "engine/devices/sampled_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Angles per radian and per order of the loop at which the search for critical frequencies looks: a
// sum of sines up to order n has at most n zeros per half turn, so zeros that are closer than a
// tenth of their mean distance are found together.
constexpr int kAnglesPerOrder = 12;
// The slowest oscillation lies at small angles; there the search takes steps of this factor.
constexpr double kAngleFactor = 1.05;
// The search starts at this part of the slowest critical frequency that the first order gives.
constexpr double kLowestPart = 0.1;
// Halvings that reduce a step of the search to the precision of double.
constexpr int kAngleHalvings = 60;

// Rounding of a quotient of two decimal numbers: half an epsilon each, and that of the division.
constexpr double kQuotientRounding = 2.0 * std::numeric_limits<double>::epsilon();

// The plant over a part of a period: the change of (x, v T), and the effect of a held force. The
// change is R p(R) with p(R) = (e^R - 1) / R, a block of the exponential of a larger matrix; the
// difference e^R - 1 would lose digits.
struct PlantStep {
  Eigen::Matrix2d less_1;
  Eigen::Vector2d of_force;

  PlantStep(const LoopPlant& plant, double period_s, double part) {
    const double per_N = period_s * period_s / plant.mass_kg;
    Eigen::Matrix2d rate;
    rate << 0.0, 1.0, -per_N * plant.stiffness_N_per_m,
        -plant.damping_Ns_per_m * period_s / plant.mass_kg;
    Eigen::Matrix4d larger = Eigen::Matrix4d::Zero();
    larger.topLeftCorner<2, 2>() = part * rate;
    larger.topRightCorner<2, 2>().setIdentity();
    const Eigen::Matrix4d power = larger.exp();
    const Eigen::Matrix2d mean = power.topRightCorner<2, 2>();
    less_1 = part * rate * mean;
    of_force = part * mean.col(1);
  }
  Eigen::Matrix2d matrix() const { return Eigen::Matrix2d::Identity() + less_1; }
};

int longest_window(std::span<const LoopDamper> dampers) {
  int ticks = 1;
  for (const LoopDamper& damper : dampers) ticks = std::max(ticks, damper.velocity_ticks);
  return ticks;
}

}  // namespace

TickDelay TickDelay::of(double delay_s, double period_s) {
  const double ticks = delay_s / period_s;
  const double nearest = std::nearbyint(ticks);
  if (std::abs(ticks - nearest) <= kQuotientRounding * ticks) {
    return {static_cast<int>(nearest), 0.0};
  }
  const double whole = std::floor(ticks);
  return {static_cast<int>(whole), ticks - whole};
}

SampledLoop::SampledLoop(const LoopPlant& plant, double period_s, const TickDelay& delay)
    : delay_(delay),
      m_per_N_(period_s * period_s / plant.mass_kg),
      m_per_Nsm_(period_s / plant.mass_kg),
      stiffness_N_per_m_(plant.stiffness_N_per_m),
      damping_Ns_per_m_(plant.damping_Ns_per_m) {
  const PlantStep first(plant, period_s, delay.part);
  const PlantStep rest(plant, period_s, 1.0 - delay.part);
  step_less_1_ = rest.less_1 + rest.matrix() * first.less_1;
  of_older_ = rest.matrix() * first.of_force;
  of_newer_ = rest.of_force;
}

// State: x, v T, x of the previous ticks (the latest first), and the forces of the previous ticks
// as f T^2 / m (the latest first).
double SampledLoop::spectral_radius(double stiffness_N_per_m,
                                    std::span<const LoopDamper> dampers) const {
  const int window = longest_window(dampers);
  const int forces = delay_.whole + (delay_.part > 0.0 ? 1 : 0);
  const int first_force = 2 + window;
  const int size = first_force + forces;
  Eigen::RowVectorXd force = Eigen::RowVectorXd::Zero(size);
  force(0) = -m_per_N_ * stiffness_N_per_m;
  for (const LoopDamper& damper : dampers) {
    const double gain = m_per_Nsm_ * damper.damping_Ns_per_m / damper.velocity_ticks;
    force(0) -= gain;
    force(1 + damper.velocity_ticks) += gain;
  }
  Eigen::MatrixXd tick = Eigen::MatrixXd::Zero(size, size);
  tick.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity() + step_less_1_;
  tick(2, 0) = 1.0;
  for (int i = 1; i < window; ++i) tick(2 + i, 1 + i) = 1.0;
  if (forces > 0) tick.row(first_force) = force;
  for (int i = 1; i < forces; ++i) tick(first_force + i, first_force + i - 1) = 1.0;
  // The force of the tick `age` ticks ago acts.
  const auto act = [&](const Eigen::Vector2d& effect, int age) {
    if (age == 0) {
      tick.topRows<2>() += effect * force;
    } else {
      tick.block<2, 1>(0, first_force + age - 1) += effect;
    }
  };
  act(of_newer_, delay_.whole);
  if (delay_.part > 0.0) act(of_older_, delay_.whole + 1);
  // The eigenvalues of a matrix with overflowed entries are meaningless.
  if (!tick.allFinite()) return kInfinity;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(tick, /* computeEigenvectors = */ false);
  if (solver.info() != Eigen::Success) return kInfinity;
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

// With z = e^(j angle) an eigenvalue, the loop requires that 1 = -P (K + D), with the plant P = N /
// det and the dampers D. So K = -det / N - D. This K is real where `imaginary` is zero, the
// imaginary part of that K times |N|^2, which has no poles.
struct SampledLoop::Crossing {
  double imaginary;
  double stiffness_N_per_m;  // the real part of K
};

SampledLoop::Crossing SampledLoop::crossing(double angle,
                                            std::span<const LoopDamper> dampers) const {
  using Complex = std::complex<double>;
  // z^n - 1 for a whole n, without loss of digits at small angles.
  const auto power_less_1 = [angle](double n) {
    const double half = std::sin(0.5 * n * angle);
    return Complex{-2.0 * half * half, std::sin(n * angle)};
  };
  const Complex grown = power_less_1(1.0);
  const Eigen::Matrix2d& e = step_less_1_;
  const Complex determinant = (grown - e(0, 0)) * (grown - e(1, 1)) - e(0, 1) * e(1, 0);
  const Complex back = std::polar(1.0, -angle);
  const Complex of_x = of_newer_(0) + of_older_(0) * back;
  const Complex of_v = of_newer_(1) + of_older_(1) * back;
  const Complex numerator =
      std::polar(1.0, -angle * delay_.whole) * ((grown - e(1, 1)) * of_x + e(0, 1) * of_v);
  Complex damper = 0.0;
  for (const LoopDamper& d : dampers) {
    damper -= m_per_Nsm_ * d.damping_Ns_per_m / d.velocity_ticks *
              power_less_1(-static_cast<double>(d.velocity_ticks));
  }
  const double square = std::norm(numerator);
  const Complex product = determinant * std::conj(numerator);
  return {product.imag() + damper.imag() * square,
          -(product.real() / square + damper.real()) / m_per_N_};
}

// Without much damping, the loop oscillates at the angle sqrt((K + k) / m) T.
double SampledLoop::lowest_angle(std::span<const LoopDamper> dampers) const {
  double damping = m_per_Nsm_ * damping_Ns_per_m_;
  for (const LoopDamper& damper : dampers) damping += m_per_Nsm_ * damper.damping_Ns_per_m;
  const double stiffness = damping / (0.5 + delay_.ticks()) + m_per_N_ * stiffness_N_per_m_;
  return kLowestPart * std::min(1.0, std::sqrt(stiffness));
}

double SampledLoop::smallest_critical_N_per_m(std::span<const LoopDamper> dampers) const {
  const int order = 6 + delay_.whole + longest_window(dampers);
  const double stride = 1.0 / (kAnglesPerOrder * order);
  double smallest = kInfinity;
  const auto consider = [&](double stiffness_N_per_m) {
    if (stiffness_N_per_m > 0.0) smallest = std::min(smallest, stiffness_N_per_m);
  };
  double low = lowest_angle(dampers);
  double of_low = crossing(low, dampers).imaginary;
  while (low < std::numbers::pi - stride) {
    const double high =
        std::min({kAngleFactor * low, low + stride, std::numbers::pi - 0.5 * stride});
    const double of_high = crossing(high, dampers).imaginary;
    if ((of_low < 0.0) != (of_high < 0.0)) {
      double below = low, above = high;
      for (int halving = 0; halving < kAngleHalvings; ++halving) {
        const double middle = 0.5 * (below + above);
        const bool is_as_low = (crossing(middle, dampers).imaginary < 0.0) == (of_low < 0.0);
        (is_as_low ? below : above) = middle;
      }
      consider(crossing(below, dampers).stiffness_N_per_m);
    }
    low = high;
    of_low = of_high;
  }
  consider(crossing(std::numbers::pi, dampers).stiffness_N_per_m);
  return smallest;
}

}  // namespace palpate
