#include "engine/analysis/factorial_model.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <Eigen/QR>

#include "engine/analysis/distributions.h"

namespace palpate {
namespace {

// Sum-to-zero coding of a factor: a column for each level but the last, which is -1 in all columns.
double sum_to_zero(int level, int column, int levels) {
  if (level == levels - 1) return -1.0;
  return level == column ? 1.0 : 0.0;
}

int term_df(const std::vector<Factor>& factors, const FactorSet& term) {
  int df = 1;
  for (const std::size_t f : term) df *= factors[f].levels - 1;
  return df;
}

// The columns of a term: products of one column of each of its factors.
void put_term_columns(const std::vector<Factor>& factors, const FactorSet& term,
                      Eigen::Ref<Eigen::MatrixXd> columns) {
  columns.setOnes();
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    auto rest = static_cast<int>(c);
    for (const std::size_t f : term) {
      const Factor& factor = factors[f];
      const int column = rest % (factor.levels - 1);
      rest /= factor.levels - 1;
      for (Eigen::Index row = 0; row < columns.rows(); ++row) {
        columns(row, c) *= sum_to_zero(factor.level_of_row[row], column, factor.levels);
      }
    }
  }
}

Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

Error design_error(std::string problem) {
  return invalid_argument("design", std::move(problem),
                          "leave out a factor, or add trials to the empty cells");
}

}  // namespace

std::vector<FactorSet> all_terms(std::size_t factors) {
  std::vector<FactorSet> terms;
  for (std::size_t bits = 1; bits < (std::size_t{1} << factors); ++bits) {
    FactorSet term;
    for (std::size_t f = 0; f < factors; ++f) {
      if ((bits >> f) & 1u) term.push_back(f);
    }
    terms.push_back(std::move(term));
  }
  std::stable_sort(terms.begin(), terms.end(),
                   [](const FactorSet& a, const FactorSet& b) { return a.size() < b.size(); });
  return terms;
}

Result<FactorialDesign> FactorialDesign::create(const std::vector<Factor>& factors,
                                                const std::vector<FactorSet>& terms) {
  const auto rows =
      factors.empty() ? Eigen::Index{0} : static_cast<Eigen::Index>(factors[0].level_of_row.size());
  std::vector<Eigen::Index> first_of_term;
  Eigen::Index columns = 1;
  for (const FactorSet& term : terms) {
    first_of_term.push_back(columns);
    columns += term_df(factors, term);
  }
  if (rows <= columns) {
    return design_error("has " + std::to_string(rows) + " rows; expected more than the " +
                        std::to_string(columns) + " parameters of the model");
  }
  Eigen::MatrixXd x(rows, columns);
  x.col(0).setOnes();
  for (std::size_t t = 0; t < terms.size(); ++t) {
    put_term_columns(factors, terms[t], x.middleCols(first_of_term[t], term_df(factors, terms[t])));
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
  if (qr.rank() < columns) {
    return design_error("determines " + std::to_string(qr.rank()) + " parameters; expected all " +
                        std::to_string(columns));
  }
  FactorialDesign design;
  design.model_basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(rows, columns);
  // Least squares gives the parameters as L y. The hypothesis that the parameters of a term are 0
  // has the sum of squares of the projection of y on the rows of L that belong to the term.
  const Eigen::MatrixXd by_column =
      qr.colsPermutation() * qr.matrixR()
                                 .topLeftCorner(columns, columns)
                                 .triangularView<Eigen::Upper>()
                                 .solve(design.model_basis_.transpose());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    design.term_bases_.push_back(orthonormal_columns(
        by_column.middleRows(first_of_term[t], term_df(factors, terms[t])).transpose()));
  }
  return design;
}

FactorialFit FactorialDesign::fit(const Eigen::MatrixXd& responses) const {
  FactorialFit fit;
  // The mean is in the model: without it, less is rounded.
  const Eigen::MatrixXd y = responses.rowwise() - responses.colwise().mean();
  for (const Eigen::MatrixXd& basis : term_bases_) {
    const Eigen::MatrixXd parts = basis.transpose() * y;
    fit.terms.push_back({static_cast<int>(basis.cols()), parts.transpose() * parts});
  }
  const Eigen::MatrixXd residuals = y - model_basis_ * (model_basis_.transpose() * y);
  fit.error_sscp = residuals.transpose() * residuals;
  const Eigen::Index rows = responses.rows(), parameters = model_basis_.cols();
  fit.error_df = static_cast<int>(rows - parameters);
  // A residual is a sum of `parameters` products with sums of `rows` terms: its rounding is less
  // than that many roundings of the largest response.
  const double roundings =
      static_cast<double>(rows + parameters) * std::numeric_limits<double>::epsilon();
  fit.rounding_ss =
      static_cast<double>(rows) *
      (roundings * responses.cwiseAbs().colwise().maxCoeff().transpose()).array().square().matrix();
  return fit;
}

FixedEffectTest test_fixed_effect(const FactorialFit& fit, std::size_t term,
                                  Eigen::Index response) {
  FixedEffectTest test;
  test.df1 = fit.terms[term].df;
  test.df2 = fit.error_df;
  const double error_ss = fit.error_sscp(response, response);
  if (!(error_ss > fit.rounding_ss(response))) {
    test.f = test.p = test.partial_eta2 = std::numeric_limits<double>::quiet_NaN();
    return test;
  }
  test.f = fit.terms[term].sscp(response, response) / test.df1 / (error_ss / test.df2);
  test.p = f_upper_tail(test.f, test.df1, test.df2);
  test.partial_eta2 = test.f * test.df1 / (test.f * test.df1 + test.df2);
  return test;
}

}  // namespace palpate
