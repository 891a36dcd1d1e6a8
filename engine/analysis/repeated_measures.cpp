#include "engine/analysis/repeated_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/analysis/distributions.h"

namespace palpate {
namespace {

Eigen::MatrixXd kronecker(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd product(a.rows() * b.rows(), a.cols() * b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.cols(); ++j) {
      product.block(i * b.rows(), j * b.cols(), b.rows(), b.cols()) = a(i, j) * b;
    }
  }
  return product;
}

// Orthonormal contrasts of a term: contrasts of its factors, means over the other factors.
Eigen::MatrixXd term_contrasts(const std::vector<int>& levels, const FactorSet& term) {
  Eigen::MatrixXd contrasts = Eigen::MatrixXd::Ones(1, 1);
  for (std::size_t f = 0; f < levels.size(); ++f) {
    const bool is_in_term = std::find(term.begin(), term.end(), f) != term.end();
    const Eigen::MatrixXd of_factor =
        is_in_term ? helmert_contrasts(levels[f])
                   : Eigen::MatrixXd::Constant(levels[f], 1, 1.0 / std::sqrt(levels[f]));
    contrasts = kronecker(contrasts, of_factor);
  }
  return contrasts;
}

RepeatedEffect effect_of(const FactorSet& term, const Eigen::MatrixXd& scores, double rounding_ss) {
  const auto n = static_cast<double>(scores.rows()), k = static_cast<double>(scores.cols());
  const Eigen::RowVectorXd mean = scores.colwise().mean();
  const Eigen::MatrixXd scatter = scores.rowwise() - mean;
  RepeatedEffect effect;
  effect.term = term;
  effect.ss = n * mean.squaredNorm();
  effect.error_ss = scatter.squaredNorm();
  effect.df1 = k;
  effect.df2 = k * (n - 1.0);
  if (!(effect.error_ss > rounding_ss)) {
    effect.f = effect.p = effect.epsilon = effect.p_gg = std::numeric_limits<double>::quiet_NaN();
    return effect;
  }
  effect.f = effect.ss / effect.df1 / (effect.error_ss / effect.df2);
  effect.p = f_upper_tail(effect.f, effect.df1, effect.df2);
  // A factor n - 1 of the covariance cancels.
  const Eigen::MatrixXd s = scatter.transpose() * scatter;
  effect.epsilon = s.trace() * s.trace() / (k * s.squaredNorm());
  effect.p_gg = f_upper_tail(effect.f, effect.epsilon * effect.df1, effect.epsilon * effect.df2);
  return effect;
}

}  // namespace

Eigen::MatrixXd helmert_contrasts(int levels) {
  Eigen::MatrixXd contrasts = Eigen::MatrixXd::Zero(levels, levels - 1);
  for (int c = 0; c < levels - 1; ++c) {
    const double length = std::sqrt((c + 1.0) * (c + 2.0));
    contrasts.col(c).head(c + 1).setConstant(1.0 / length);
    contrasts(c + 1, c) = -(c + 1.0) / length;
  }
  return contrasts;
}

RepeatedMeasures repeated_measures(const std::vector<int>& levels, const Eigen::MatrixXd& table) {
  const Eigen::MatrixXd centred = table.array() - table.mean();
  // A score is a sum of `cells` terms, and their mean one of `participants` scores.
  const double roundings = static_cast<double>(table.rows() + table.cols()) *
                           std::numeric_limits<double>::epsilon() * table.cwiseAbs().maxCoeff();
  const double rounding_ss = static_cast<double>(table.size()) * roundings * roundings;
  RepeatedMeasures result;
  result.participants = static_cast<int>(table.rows());
  result.participants_ss =
      (centred * term_contrasts(levels, {})).squaredNorm();  // the mean of all is 0
  double with_participants = result.participants_ss;
  for (const FactorSet& term : all_terms(levels.size())) {
    result.effects.push_back(effect_of(term, centred * term_contrasts(levels, term), rounding_ss));
    with_participants += result.effects.back().error_ss;
  }
  for (RepeatedEffect& effect : result.effects) {
    effect.generalized_eta2 = effect.ss / (effect.ss + with_participants);
  }
  return result;
}

}  // namespace palpate
