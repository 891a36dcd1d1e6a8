#pragma once

// Analysis of variance with repeated measures: every participant has a value in every cell of a
// factorial table, and each effect is tested against its own interaction with participants.

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "engine/analysis/factorial_model.h"

namespace palpate {

// An effect on n participants, with k degrees of freedom. F(k, k (n - 1)) is the mean square of the
// effect divided by the mean square of its interaction with participants.
struct RepeatedEffect {
  FactorSet term;
  double ss = 0.0;        // of the effect
  double error_ss = 0.0;  // of its interaction with participants
  double f = 0.0;         // NaN if the interaction is 0 to within rounding
  double df1 = 0.0, df2 = 0.0;
  double p = 0.0;  // assumes sphericity
  // Greenhouse and Geisser (1959): epsilon = (tr S)^2 / (k tr S^2), S the covariance of k
  // orthonormal contrasts, from 1 / k to 1. p_gg: the p of F(epsilon df1, epsilon df2).
  double epsilon = 1.0;
  double p_gg = 0.0;
  // Olejnik and Algina (2003), all factors manipulated: SS / (SS + all sums of squares of the table
  // that involve participants).
  double generalized_eta2 = 0.0;
};

struct RepeatedMeasures {
  int participants = 0;
  double participants_ss = 0.0;         // between participants
  std::vector<RepeatedEffect> effects;  // in the order of all_terms()
};

// levels: the number of levels of each factor, at least 2. table: one row per participant (at least
// 2), one column per cell; the last factor varies fastest; finite.
RepeatedMeasures repeated_measures(const std::vector<int>& levels, const Eigen::MatrixXd& table);

// k x (k - 1): orthonormal columns, each of which has the sum 0 (Helmert contrasts).
Eigen::MatrixXd helmert_contrasts(int levels);

}  // namespace palpate
