#include "engine/analysis/power_fit.h"

#include <cmath>

#include "engine/analysis/distributions.h"
#include "engine/analysis/intervals.h"

namespace palpate {

bool PilotFit::is_too_low() const {
  return p_below < kSignificance;
}

// The reciprocal of F(a, b) is F(b, a).
PilotFit pilot_fit(const PilotEstimate& pilot, const PowerTests& tests) {
  PilotFit fit;
  fit.f = pilot.ms_pc / pilot.ms_e;
  fit.p_below = f_upper_tail(1.0 / fit.f, pilot.df_e, pilot.df_pc);
  const double noise = pilot.variances.w + pilot.variances.e / pilot.m;
  for (const PowerTest& test : tests.tests) {
    if (test.family.empty()) continue;
    const Eigen::VectorXd weights = tests.weights.col(static_cast<Eigen::Index>(test.first_score));
    const Eigen::VectorXd differences = pilot.cells * weights;
    const double squares = (differences.array() - differences.mean()).matrix().squaredNorm();
    fit.pairs.push_back({test.name,
                         std::sqrt(squares / static_cast<double>(differences.size() - 1)),
                         std::sqrt(noise * weights.squaredNorm())});
  }
  return fit;
}

}  // namespace palpate
