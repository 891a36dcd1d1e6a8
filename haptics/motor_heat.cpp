#include "haptics/motor_heat.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using HeatLimits = MotorHeatLimits;

constexpr double kFadeWidth = 1.0 - HeatLimits::kFadeFrom * HeatLimits::kFadeFrom;

// Up to this exponent x, the series of 1 - exp(-x) may end after five terms: the sixth is less than
// a quarter of an epsilon of the first, x^5 / 720 < 5.5e-17. It covers ticks of up to 20 ms.
constexpr double kSeriesEnd = 2e-3;

// After this many time constants, exp(-x) is less than a quarter of an epsilon.
constexpr std::int64_t kForgetAfter = 38;

}  // namespace

double warming_share(std::int64_t step_ns) noexcept {
  if (step_ns >= kForgetAfter * HeatLimits::kTimeConstant_ns) return 1.0;
  double x = static_cast<double>(step_ns) / static_cast<double>(HeatLimits::kTimeConstant_ns);
  int halvings = 0;  // at most 15
  for (; x > kSeriesEnd; x *= 0.5) ++halvings;
  double share = x * (1.0 - x * (1.0 / 2 - x * (1.0 / 6 - x * (1.0 / 24 - x * (1.0 / 120)))));
  for (; halvings > 0; --halvings) share *= 2.0 - share;  // 1 - exp(-2x)
  return share;
}

double MotorHeat::factor(const Vec3& loads) const noexcept {
  double factor2 = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double load2 = loads[i] * loads[i];
    if (!(load2 > 1.0)) continue;
    const double x = std::max(0.0, (1.0 - mean_square_[i]) / kFadeWidth);
    factor2 = std::min(factor2, (1.0 - x) / load2 + x);
  }
  return factor2 < 1.0 ? std::sqrt(factor2) : 1.0;
}

void MotorHeat::add(const Vec3& loads, std::int64_t step_ns) noexcept {
  const double share = warming_share(step_ns);
  for (int i = 0; i < 3; ++i) {
    const double load2 = std::isfinite(loads[i]) ? loads[i] * loads[i] : 1.0;
    mean_square_[i] += share * (load2 - mean_square_[i]);
  }
}

}  // namespace palpate
