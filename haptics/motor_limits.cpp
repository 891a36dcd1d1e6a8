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

// The determinant of three unit vectors is at most the sine of the angle of one to the span of the
// others. Beyond this, the shares by cofactors keep all but their last two digits.
constexpr double kClearlyIndependent = 1.0 / 16.0;

}  // namespace

MotorLimits::Basis::Basis(const std::array<Vec3, 3>& directions, int given) noexcept {
  for (std::size_t motor = 0; motor < static_cast<std::size_t>(given); ++motor) {
    Vec3 rest = directions[motor];
    of_motors.col(count).setZero();
    for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the first one's rounding
      for (int i = 0; i < count; ++i) {
        const double along = rest.dot(axes[static_cast<std::size_t>(i)]);
        rest -= along * axes[static_cast<std::size_t>(i)];
        of_motors(i, count) += along;
      }
    }
    const double sine = rest.norm();
    if (!(sine > kLeastSine)) continue;
    of_motors(count, count) = sine;
    axes[static_cast<std::size_t>(count)] = rest / sine;
    motors[static_cast<std::size_t>(count)] = motor;
    ++count;
  }
}

MotorLimits::MotorLimits(std::span<const MotorDescription> motors) noexcept {
  const std::size_t count = std::min<std::size_t>(motors.size(), 3);
  for (std::size_t n = 0; n < count; ++n) {
    directions_[n] = Vec3(motors[n].direction_device.data()).normalized();
    peak_N_[n] = motors[n].peak_force_N;
    continuous_N_[n] = motors[n].continuous_force_N;
  }
  if (count == 3) {
    rows_[0] = directions_[1].cross(directions_[2]);
    const double determinant = directions_[0].dot(rows_[0]);
    spans_all_ = std::abs(determinant) > kClearlyIndependent;
    if (spans_all_) {
      rows_[1] = directions_[2].cross(directions_[0]);
      rows_[2] = directions_[0].cross(directions_[1]);
      for (Vec3& row : rows_) row *= 1.0 / determinant;
    }
  }
  if (!spans_all_) {
    basis_ = Basis(directions_, static_cast<int>(count));
    find_rows();
  }
  for (std::size_t n = 0; n < count; ++n) row2_[n] = rows_[n].squaredNorm();
}

// Solves for the motors from the last to the first.
void MotorLimits::find_rows() noexcept {
  rows_.fill(Vec3::Zero());
  for (int i = basis_.count - 1; i >= 0; --i) {
    Vec3 row = basis_.axes[static_cast<std::size_t>(i)];
    for (int j = i + 1; j < basis_.count; ++j) {
      row -= basis_.of_motors(i, j) * rows_[basis_.motors[static_cast<std::size_t>(j)]];
    }
    rows_[basis_.motors[static_cast<std::size_t>(i)]] = row * (1.0 / basis_.of_motors(i, i));
  }
}

// Whether each motor's share of a force is certainly less than half of its limit. The half is far
// more than rounding. A limit of 0 is none.
bool MotorLimits::are_below_half(const std::array<double, 3>& limits_N,
                                 const Vec3& force_N) const noexcept {
  const double force2 = force_N.squaredNorm();
  for (std::size_t n = 0; n < 3; ++n) {
    if (limits_N[n] > 0.0 && !(force2 * row2_[n] < 0.25 * limits_N[n] * limits_N[n])) return false;
  }
  return true;
}

Vec3 MotorLimits::part(const Vec3& force_N) const noexcept {
  if (spans_all_) return force_N;
  Vec3 part = Vec3::Zero();
  for (int i = 0; i < basis_.count; ++i) {
    const Vec3& axis = basis_.axes[static_cast<std::size_t>(i)];
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
  if (are_below_half(peak_N_, force_N)) return 1.0;
  return scale(force_N, spans_all_ ? Basis(directions_, 3) : basis_);
}

double MotorLimits::scale(const Vec3& force_N, const Basis& basis) const noexcept {
  double scale = 1.0;
  Vec3 motor_N = Vec3::Zero();
  for (int i = basis.count - 1; i >= 0; --i) {
    const auto n = static_cast<std::size_t>(i);
    double along_N = basis.axes[n].dot(force_N);
    for (int j = i + 1; j < basis.count; ++j) along_N -= basis.of_motors(i, j) * motor_N[j];
    motor_N[i] = along_N / basis.of_motors(i, i);
    const double peak_N = peak_N_[basis.motors[n]];
    if (peak_N > 0.0 && std::abs(motor_N[i]) > peak_N) {
      scale = std::min(scale, peak_N / std::abs(motor_N[i]));
    }
  }
  return scale;
}

Vec3 MotorLimits::loads(const Vec3& force_N) const noexcept {
  Vec3 loads = Vec3::Zero();
  for (std::size_t n = 0; n < 3; ++n) {
    const bool is_known = continuous_N_[n] > 0.0;
    if (is_known) loads[static_cast<int>(n)] = rows_[n].dot(force_N) / continuous_N_[n];
  }
  return loads;
}

}  // namespace palpate
