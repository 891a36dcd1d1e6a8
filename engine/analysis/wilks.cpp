#include "engine/analysis/wilks.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "engine/analysis/distributions.h"

namespace palpate {
namespace {

// The product of the squares of the diagonal of the Cholesky factor is the determinant. The
// logarithm neither overflows nor underflows.
double log_determinant(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

std::optional<Eigen::Index> singular_response(const Eigen::MatrixXd& error_sscp,
                                              const Eigen::VectorXd& rounding_ss,
                                              Eigen::Index rows) {
  const Eigen::Index responses = error_sscp.rows();
  for (Eigen::Index i = 0; i < responses; ++i) {
    if (!(error_sscp(i, i) > rounding_ss(i))) return i;
  }
  // Of correlations, the pivot of a response is the share of its variance that the responses before
  // it do not explain. Sums of `rows` products round that often.
  const Eigen::VectorXd scale = error_sscp.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlations = scale.asDiagonal() * error_sscp * scale.asDiagonal();
  const double rounding =
      static_cast<double>(rows * responses) * std::numeric_limits<double>::epsilon();
  for (Eigen::Index i = 1; i < responses; ++i) {
    const Eigen::VectorXd with_before = correlations.col(i).head(i);
    const double explained =
        with_before.dot(correlations.topLeftCorner(i, i).llt().solve(with_before));
    if (!(1.0 - explained > rounding)) return i;
  }
  return std::nullopt;
}

double wilks_lambda(const Eigen::MatrixXd& error_sscp, const Eigen::MatrixXd& effect_sscp) {
  return std::exp(log_determinant(error_sscp) - log_determinant(error_sscp + effect_sscp));
}

WilksTest rao_test(double lambda, int responses, int effect_df, int error_df) {
  const double p = responses, q = effect_df, v = error_df;
  const double r = v - 0.5 * (p - q + 1.0);
  const double u = 0.25 * (p * q - 2.0);
  const double denominator = p * p + q * q - 5.0;
  const double t = denominator > 0.0 ? std::sqrt((p * p * q * q - 4.0) / denominator) : 1.0;
  const double root = std::pow(lambda, 1.0 / t);
  WilksTest test;
  test.lambda = lambda;
  test.df1 = p * q;
  test.df2 = r * t - 2.0 * u;
  test.f = (1.0 - root) / root * test.df2 / test.df1;
  test.p = f_upper_tail(test.f, test.df1, test.df2);
  return test;
}

}  // namespace palpate
