#include "haptics/motor_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// A force lies in the span if what remains of it outside is rounding. A projection on up to three
// unit vectors rounds each of their dot products and the sum of their multiples, up to 3 + 3 + 1
// roundings of numbers up to the force's length, and the force itself may be the result of such a
// projection.
constexpr double kSpanRounding = 16 * kEpsilon;

// The directions are unit vectors with rounding. The sine of the angle of a motor to the span of
// the motors before it has an absolute error of a few epsilon; below this sine, its first half of
// the digits is lost, and with it the share of the motor in a force.
const double kLeastSine = std::sqrt(kEpsilon);

}  // namespace

MotorLimits::MotorLimits(std::span<const MotorDescription> motors) noexcept {
  int given = -1;
  for (const MotorDescription& motor : motors.first(std::min<std::size_t>(motors.size(), 3))) {
    ++given;
    const Vec3 direction = Vec3(motor.direction_device.data()).normalized();
    Vec3 rest = direction;
    Vec3 parts = Vec3::Zero();
    for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the first one's rounding
      for (int i = 0; i < count_; ++i) {
        const double along = rest.dot(basis_[static_cast<std::size_t>(i)]);
        rest -= along * basis_[static_cast<std::size_t>(i)];
        parts[i] += along;
      }
    }
    const double sine = rest.norm();
    if (!(sine > kLeastSine)) continue;
    parts[count_] = sine;
    to_basis_.col(count_) = parts;
    basis_[static_cast<std::size_t>(count_)] = rest / sine;
    peak_N_[static_cast<std::size_t>(count_)] = motor.peak_force_N;
    continuous_N_[static_cast<std::size_t>(count_)] = motor.continuous_force_N;
    given_[static_cast<std::size_t>(count_)] = given;
    ++count_;
  }
  find_rows();
}

// Solves for the motors from the last to the first, and bounds the share of each in a force.
void MotorLimits::find_rows() noexcept {
  for (int i = count_ - 1; i >= 0; --i) {
    const auto n = static_cast<std::size_t>(i);
    Vec3 row = basis_[n];
    for (int j = i + 1; j < count_; ++j)
      row -= to_basis_(i, j) * rows_[static_cast<std::size_t>(j)];
    rows_[n] = row * (1.0 / to_basis_(i, i));
    const double peak_N = peak_N_[n];
    if (peak_N > 0.0) {
      harmless_N2_ = std::min(harmless_N2_, 0.25 * peak_N * peak_N / rows_[n].squaredNorm());
    }
  }
}

Vec3 MotorLimits::part(const Vec3& force_N) const noexcept {
  Vec3 part = Vec3::Zero();
  for (int i = 0; i < count_; ++i) {
    const Vec3& axis = basis_[static_cast<std::size_t>(i)];
    part += axis.dot(force_N) * axis;
  }
  const Vec3 rest_N = force_N - part;
  // Squares decide the clear cases without roots. Where they could underflow, they do not count.
  const double limit2 = kSpanRounding * kSpanRounding * force_N.squaredNorm();
  if (limit2 > std::numeric_limits<double>::min()) {
    const double rest2 = rest_N.squaredNorm();
    if (rest2 < 0.25 * limit2) return force_N;
    if (rest2 > 4.0 * limit2) return part;
  }
  return rest_N.norm() <= kSpanRounding * force_N.norm() ? force_N : part;
}

double MotorLimits::scale(const Vec3& force_N) const noexcept {
  if (force_N.squaredNorm() < harmless_N2_) return 1.0;
  double scale = 1.0;
  Vec3 motor_N = Vec3::Zero();
  for (int i = count_ - 1; i >= 0; --i) {
    const auto n = static_cast<std::size_t>(i);
    double along_N = basis_[n].dot(force_N);
    for (int j = i + 1; j < count_; ++j) along_N -= to_basis_(i, j) * motor_N[j];
    motor_N[i] = along_N / to_basis_(i, i);
    const double peak_N = peak_N_[n];
    if (peak_N > 0.0 && std::abs(motor_N[i]) > peak_N) {
      scale = std::min(scale, peak_N / std::abs(motor_N[i]));
    }
  }
  return scale;
}

Vec3 MotorLimits::loads(const Vec3& force_N) const noexcept {
  Vec3 loads = Vec3::Zero();
  for (int i = 0; i < count_; ++i) {
    const auto n = static_cast<std::size_t>(i);
    if (continuous_N_[n] > 0.0) loads[given_[n]] = rows_[n].dot(force_N) / continuous_N_[n];
  }
  return loads;
}

}  // namespace palpate
