#pragma once

// Multivariate analysis of variance by Wilks' lambda = |E| / |E + H| and Rao's approximation of its
// distribution by F (Rao, 1951; exact if min(p, q) <= 2).

#include <optional>

#include <Eigen/Core>

namespace palpate {

struct WilksTest {
  double lambda = 1.0;
  double f = 0.0;
  double df1 = 0.0, df2 = 0.0;  // df2 need not be an integer
  double p = 1.0;
};

// The first response that is constant within the cells of the design, or a linear combination of
// the responses before it, to within rounding; the error matrix is then singular. No value if the
// error matrix is regular. rounding_ss: FactorialFit::rounding_ss. rows: the number of rows of the
// design.
std::optional<Eigen::Index> singular_response(const Eigen::MatrixXd& error_sscp,
                                              const Eigen::VectorXd& rounding_ss,
                                              Eigen::Index rows);

// Wilks' lambda by Cholesky factors. Requires a regular error matrix.
double wilks_lambda(const Eigen::MatrixXd& error_sscp, const Eigen::MatrixXd& effect_sscp);

// Rao's F of a lambda in (0, 1], for p responses, q degrees of freedom of the effect and v of the
// error: with r = v - (p - q + 1) / 2, u = (p q - 2) / 4 and
// t = sqrt((p^2 q^2 - 4) / (p^2 + q^2 - 5)), which is 1 if the denominator is not positive,
// F(p q, r t - 2 u) = (1 - lambda^(1/t)) / lambda^(1/t) (r t - 2 u) / (p q).
WilksTest rao_test(double lambda, int responses, int effect_df, int error_df);

}  // namespace palpate
