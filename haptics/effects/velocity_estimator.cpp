#include "haptics/effects/velocity_estimator.h"

#include <algorithm>
#include <limits>

namespace palpate {

// The exact sum of two doubles, as the rounded sum and its rounding error (Knuth 1969). A second
// such sum keeps low_s below the last digit of high_s.
VelocityEstimator::Time VelocityEstimator::Time::plus(double dt_s) const noexcept {
  const auto two_sum = [](double a, double b) {
    const double sum = a + b;
    const double from_b = sum - a;
    return Time{sum, (a - (sum - from_b)) + (b - from_b)};
  };
  const Time sum = two_sum(high_s, dt_s);
  return two_sum(sum.high_s, low_s + sum.low_s);
}

VelocityEstimator::VelocityEstimator(const VelocitySettings& settings)
    : method_(settings.method),
      window_(static_cast<std::size_t>(std::clamp(settings.window_ticks, 1, kMostTicks))),
      half_quantum_m_(0.5 * settings.encoder_quantum_m) {}

Vec3 VelocityEstimator::add(const Vec3& position_m, double dt_s) noexcept {
  if (count_ == 0) {
    samples_[newest_ % kCapacity] = {position_m, Time{}};
    count_ = 1;
    return Vec3::Zero();
  }
  const Sample last{position_m, back(0).time.plus(dt_s)};
  ++newest_;
  samples_[newest_ % kCapacity] = last;
  count_ = std::min(count_ + 1, window_ + 1);
  switch (method_) {
    case VelocityMethod::kLineFit:
      return line_fit(last, count_ - 1);
    case VelocityMethod::kAdaptive:
      return adaptive(last, count_ - 1);
    default:
      return difference(last, count_ - 1);
  }
}

Vec3 VelocityEstimator::difference(const Sample& last, std::size_t window) const noexcept {
  const Sample& first = back(window);
  const double span_s = first.time.seconds_to(last.time);
  if (!(span_s > 0.0)) return Vec3::Zero();  // dt vanished in the sum of the times
  return (last.position_m - first.position_m) / span_s;
}

// With s and r the time and the displacement from a sample to the newest one, and m = w + 1
// samples, the slope is
// (m sum(s r) - sum(s) sum(r)) / (m sum(s s) - sum(s)^2).
Vec3 VelocityEstimator::line_fit(const Sample& last, std::size_t window) const noexcept {
  double s_sum = 0.0;
  double ss_sum = 0.0;
  Vec3 r_sum = Vec3::Zero();
  Vec3 sr_sum = Vec3::Zero();
  for (std::size_t k = 1; k <= window; ++k) {
    const Sample& sample = back(k);
    const double s = sample.time.seconds_to(last.time);
    const Vec3 r = last.position_m - sample.position_m;
    s_sum += s;
    ss_sum += s * s;
    r_sum += r;
    sr_sum += s * r;
  }
  const auto m = static_cast<double>(window + 1);
  const double spread_s2 = m * ss_sum - s_sum * s_sum;
  if (!(spread_s2 > 0.0)) return Vec3::Zero();  // the squares of the times vanish
  return (m * sr_sum - s_sum * r_sum) / spread_s2;
}

// Each sample, from the newest back, narrows the range of slopes of lines that pass it closely
// enough. One pass therefore finds every valid window.
Vec3 VelocityEstimator::adaptive(const Sample& last, std::size_t window) const noexcept {
  const Vec3 near_m = Vec3::Constant(half_quantum_m_);
  Vec3 least = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 most = -least;
  Vec3 velocity_m_per_s = Vec3::Zero();
  for (std::size_t k = 1; k <= window; ++k) {
    const Sample& sample = back(k);
    const double s = sample.time.seconds_to(last.time);
    const Vec3 r = last.position_m - sample.position_m;
    if (!(s > 0.0)) continue;  // as in difference()
    const double per_s = 1.0 / s;
    const Vec3 slope = per_s * r;
    if ((slope.array() >= least.array()).all() && (slope.array() <= most.array()).all()) {
      velocity_m_per_s = slope;
    }
    least = least.cwiseMax(Vec3(slope - per_s * near_m));
    most = most.cwiseMin(Vec3(slope + per_s * near_m));
    if ((least.array() > most.array()).any()) break;
  }
  return velocity_m_per_s;
}

}  // namespace palpate
