#pragma once

// Fixed effects of a factorial experiment, for any number of responses at once. Sums of squares are
// of type III: with sum-to-zero contrasts, the full model is compared with the model without the
// term. On balanced data they are the usual sums of squares.

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "geometry/base/result.h"

namespace palpate {

// A factor, and the level that it has in each row, from 0.
struct Factor {
  std::string name;
  int levels = 0;  // at least 2
  std::vector<int> level_of_row;
};

// A term of a model: the indices of its factors in the list of factors, ascending.
using FactorSet = std::vector<std::size_t>;

// All terms of a full model: main effects, then interactions of two factors, and so on.
std::vector<FactorSet> all_terms(std::size_t factors);

// A term of a fitted model. sscp: its sums of squares and cross products (H), one row and one
// column per response.
struct TermFit {
  int df = 0;
  Eigen::MatrixXd sscp;
};

struct FactorialFit {
  std::vector<TermFit> terms;  // in the order of the terms of the design
  Eigen::MatrixXd error_sscp;  // E
  int error_df = 0;
  // The model leaves no error if a diagonal element of error_sscp is at most this rounding bound.
  Eigen::VectorXd rounding_ss;
};

// F of one response in a term: mean square of the term divided by the mean square of the error.
struct FixedEffectTest {
  double f = 0.0;  // NaN if the model leaves no error
  double df1 = 0.0, df2 = 0.0;
  double p = 0.0;
  double partial_eta2 = 0.0;  // F df1 / (F df1 + df2)
};

// The design of an experiment, factorised once for any number of data sets. Immutable; any number
// of threads may use one design.
class FactorialDesign {
 public:
  // An error if the rows do not determine all terms (for example because a cell is empty), or leave
  // no degree of freedom for the error.
  static Result<FactorialDesign> create(const std::vector<Factor>& factors,
                                        const std::vector<FactorSet>& terms);

  // responses: one row per row of the design, one column per response; finite.
  FactorialFit fit(const Eigen::MatrixXd& responses) const;

 private:
  Eigen::MatrixXd model_basis_;              // orthonormal, of all terms and the mean
  std::vector<Eigen::MatrixXd> term_bases_;  // orthonormal: what a term adds to all others
};

FixedEffectTest test_fixed_effect(const FactorialFit& fit, std::size_t term, Eigen::Index response);

}  // namespace palpate
