#include "engine/devices/coupling_dampers.h"

#include <algorithm>

namespace palpate {
namespace {

// With s_k = k T the time from the newest sample back to sample k, and r_k the displacement since,
// the slope through m samples is the sum of (m s_k - sum(s)) r_k / (m sum(s s) - sum(s)^2), and r_k
// is the difference over k ticks times s_k. The period cancels.
std::vector<LoopDamper> line_dampers(double damping_Ns_per_m, int window) {
  const double m = window + 1.0;
  const double sum = 0.5 * window * m;                           // of k
  const double squares = window * m * (2.0 * window + 1) / 6.0;  // of k k
  const double spread = m * squares - sum * sum;
  std::vector<LoopDamper> dampers;
  for (int k = 1; k <= window; ++k) {
    dampers.push_back({damping_Ns_per_m * k * (m * k - sum) / spread, k});
  }
  return dampers;
}

}  // namespace

std::vector<std::vector<LoopDamper>> coupling_dampers(double damping_Ns_per_m,
                                                      const VelocitySettings& velocity) {
  // Without damping, all windows are alike.
  const int most = damping_Ns_per_m == 0.0 ? 1 : VelocityEstimator::kMostTicks;
  const int window = std::clamp(velocity.window_ticks, 1, most);
  std::vector<std::vector<LoopDamper>> entries;
  switch (velocity.method) {
    case VelocityMethod::kLineFit:
      entries.push_back(line_dampers(damping_Ns_per_m, window));
      break;
    case VelocityMethod::kAdaptive:
      for (int k = 1; k <= window; ++k) entries.push_back({{damping_Ns_per_m, k}});
      break;
    case VelocityMethod::kDifference:
      entries.push_back({{damping_Ns_per_m, window}});
      break;
  }
  return entries;
}

}  // namespace palpate
