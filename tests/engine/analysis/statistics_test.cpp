// The statistics on public data sets, against results of R and pingouin, and against the
// definitions on random data.

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "engine/analysis/comparisons.h"
#include "engine/analysis/distributions.h"
#include "engine/analysis/factorial_model.h"
#include "engine/analysis/intervals.h"
#include "engine/analysis/repeated_measures.h"
#include "engine/analysis/wilks.h"
#include "tests/engine/analysis/data_set.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

constexpr double kRelative = 1e-9;

void expect_equal(double found, double expected, double half_unit = 0.0) {
  EXPECT_NEAR(found, expected, kRelative * std::abs(expected) + half_unit);
}

// Fits the terms, each a list of factor names.
FactorialFit fit_terms(const DataSet& data, const std::vector<std::string>& factors,
                       const std::vector<FactorSet>& terms,
                       const std::vector<std::string>& responses) {
  std::vector<Factor> columns;
  for (const std::string& name : factors) columns.push_back(data.factor(name));
  const auto design = FactorialDesign::create(columns, terms);
  EXPECT_TRUE(design.ok());
  return design->fit(data.numbers(responses));
}

WilksTest wilks_of(const FactorialFit& fit, std::size_t term) {
  const double lambda = wilks_lambda(fit.error_sscp, fit.terms[term].sscp);
  return rao_test(lambda, static_cast<int>(fit.error_sscp.rows()), fit.terms[term].df,
                  fit.error_df);
}

TEST(Wilks, OfIrisEqualsR) {
  const DataSet data("iris.csv");
  const FactorialFit fit = fit_terms(
      data, {"species"}, {{0}}, {"sepal_length", "sepal_width", "petal_length", "petal_width"});
  const WilksTest test = wilks_of(fit, 0);
  expect_equal(test.lambda, 0.0234386306508782);
  expect_equal(test.f, 199.145343540085);
  EXPECT_DOUBLE_EQ(test.df1, 8.0);
  EXPECT_DOUBLE_EQ(test.df2, 288.0);
}

TEST(Wilks, OfPotteryEqualsR) {
  const DataSet data("pottery.csv");
  const FactorialFit fit = fit_terms(data, {"site"}, {{0}}, {"Al", "Fe", "Mg", "Ca", "Na"});
  const WilksTest test = wilks_of(fit, 0);
  expect_equal(test.lambda, 0.0123009058474734);
  expect_equal(test.f, 13.0885429044, 0.5e-10);
  EXPECT_DOUBLE_EQ(test.df1, 15.0);
  expect_equal(test.df2, 50.0914730996, 0.5e-10);
}

void expect_plastic_film(const Eigen::MatrixXd& responses, const DataSet& factors,
                         const double (&lambdas)[3], const double (&fs)[3], double half_unit) {
  const auto design = FactorialDesign::create({factors.factor("rate"), factors.factor("additive")},
                                              {{0}, {1}, {0, 1}});
  const FactorialFit fit = design->fit(responses);
  for (std::size_t term = 0; term < 3; ++term) {
    const WilksTest test = wilks_of(fit, term);
    expect_equal(test.lambda, lambdas[term], half_unit);
    expect_equal(test.f, fs[term], half_unit);
    EXPECT_DOUBLE_EQ(test.df1, 3.0);
    EXPECT_DOUBLE_EQ(test.df2, 14.0);
  }
}

// R prints five digits. The second results are of the same data with another twelfth opacity, to
// more digits.
TEST(Wilks, OfPlasticFilmEqualsR) {
  const DataSet data("plastic.csv");
  Eigen::MatrixXd y = data.numbers({"tear", "gloss", "opacity"});
  expect_plastic_film(y, data, {0.38186, 0.52303, 0.77711}, {7.5543, 4.2556, 1.3385}, 0.5e-4);
  ASSERT_EQ(y(11, 2), 4.1);
  y(11, 2) = 4.2;
  expect_plastic_film(y, data, {0.380969861242919, 0.524093054716922, 0.778885319368864},
                      {7.58277125853, 4.23760448264, 1.32480159011}, 0.5e-11);
}

// The paper prints lambda with three digits: lambda +- 0.0005 must give an interval that holds its
// F.
TEST(Wilks, RaoIntervalsHoldThePapersF) {
  struct Printed {
    const char* effect;
    int df;
    double lambda, low, high, f, df2;
  };
  const Printed printed[] = {{"Haptic", 2, 0.236, 227.46, 228.39, 228.207, 1292},
                             {"Rotation", 1, 0.925, 17.34, 17.58, 17.486, 646},
                             {"Object", 3, 0.110, 257.20, 258.80, 257.433, 1572.3},
                             {"Trial", 2, 0.925, 8.50, 8.62, 8.590, 1292},
                             {"Rotation x Haptic", 2, 0.911, 10.22, 10.33, 10.271, 1292},
                             {"Object x Haptic", 6, 0.868, 5.19, 5.23, 5.227, 1827.6},
                             {"Object x Rotation", 3, 0.934, 4.94, 5.01, 4.964, 1572.3}};
  for (const Printed& row : printed) {
    const WilksTest least = rao_test(row.lambda + 0.0005, 3, row.df, 648);
    const WilksTest most = rao_test(row.lambda - 0.0005, 3, row.df, 648);
    // The ends are rounded inwards to two decimals.
    EXPECT_EQ(std::ceil(100.0 * least.f), std::round(100.0 * row.low)) << row.effect;
    EXPECT_EQ(std::floor(100.0 * most.f), std::round(100.0 * row.high)) << row.effect;
    EXPECT_LT(least.f, row.f) << row.effect;
    EXPECT_GT(most.f, row.f) << row.effect;
    EXPECT_NEAR(least.df2, row.df2, 0.05) << row.effect;
  }
}

TEST(Wilks, OfOneResponseIsItsF) {
  const DataSet data("warpbreaks.csv");
  const FactorialFit fit = fit_terms(data, {"wool", "tension"}, {{0}, {1}, {0, 1}}, {"breaks"});
  for (std::size_t term = 0; term < 3; ++term) {
    expect_equal(wilks_of(fit, term).f, test_fixed_effect(fit, term, 0).f);
  }
}

TEST(Wilks, ErrorMatrixOfAConstantOrCombinedResponseIsSingular) {
  const DataSet data("iris.csv");
  Eigen::MatrixXd y = data.numbers({"sepal_length", "sepal_width", "petal_length"});
  const auto design = FactorialDesign::create({data.factor("species")}, {{0}});
  const auto singular = [&] {
    const FactorialFit fit = design->fit(y);
    return singular_response(fit.error_sscp, fit.rounding_ss, y.rows());
  };
  EXPECT_FALSE(singular());
  const Eigen::VectorXd third = y.col(2);
  y.col(2) = 0.3 * y.col(0) - 1e3 * y.col(1);
  EXPECT_EQ(singular(), 2);
  y.col(2) = third * 1e-12;  // a small unit is no reason
  EXPECT_FALSE(singular());
  y.col(1).setConstant(0.1);
  EXPECT_EQ(singular(), 1);
  for (Eigen::Index row = 0; row < y.rows(); ++row) y(row, 1) = row < 50 ? 1.1 : 2.3;
  EXPECT_EQ(singular(), 1);  // constant within the cells
}

TEST(FactorialModel, OfNpkEqualsR) {
  const DataSet data("npk.csv");
  const FactorialFit fit = fit_terms(data, {"block", "N", "P", "K"},
                                     {{0}, {1}, {2}, {3}, {1, 2}, {1, 3}, {2, 3}}, {"yield"});
  const double fs[] = {4.44666642680, 12.2587342137, 0.544129816860, 6.16568920232,
                       1.37829669341, 2.14597200734, 0.0311949051919};
  for (std::size_t term = 0; term < 7; ++term) {
    const FixedEffectTest test = test_fixed_effect(fit, term, 0);
    expect_equal(test.f, fs[term], 0.5e-12);
    EXPECT_DOUBLE_EQ(test.df1, term == 0 ? 5.0 : 1.0);
  }
  EXPECT_EQ(fit.error_df, 12);
  expect_equal(fit.error_sscp(0, 0), 185.286666667, 0.5e-9);
}

TEST(FactorialModel, OfUnbalancedWarpbreaksIsTypeThree) {
  DataSet data("warpbreaks.csv");
  data.drop_rows({0, 1, 29});
  const FactorialFit fit = fit_terms(data, {"wool", "tension"}, {{0}, {1}, {0, 1}}, {"breaks"});
  const double fs[] = {6.166046801923, 11.065533657595, 6.157905462486};
  for (std::size_t term = 0; term < 3; ++term) {
    expect_equal(test_fixed_effect(fit, term, 0).f, fs[term], 0.5e-12);
  }
  EXPECT_EQ(fit.error_df, 45);
  expect_equal(fit.error_sscp(0, 0), 5031.636904762, 0.5e-9);
}

double residual_ss(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  return (y - x * x.colPivHouseholderQr().solve(y)).squaredNorm();
}

// The definition of type III on unbalanced random data: for two factors with two levels each, whose
// codes are 1 and -1, the columns of a term are left out of a regression.
TEST(FactorialModel, TermIsTheDifferenceToTheModelWithoutIt) {
  Random random(18001);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Eigen::Index rows = 12 + static_cast<Eigen::Index>(random.index(30));
    std::vector<Factor> factors = {{"a", 2, {}}, {"b", 2, {}}};
    Eigen::MatrixXd x(rows, 4);
    Eigen::VectorXd y(rows);
    for (Eigen::Index row = 0; row < rows; ++row) {
      // The first four rows fill all cells.
      const int a = row < 4 ? static_cast<int>(row) % 2 : static_cast<int>(random.index(2));
      const int b = row < 4 ? static_cast<int>(row) / 2 : static_cast<int>(random.index(2));
      factors[0].level_of_row.push_back(a);
      factors[1].level_of_row.push_back(b);
      x.row(row) << 1.0, 1 - 2 * a, 1 - 2 * b, (1 - 2 * a) * (1 - 2 * b);
      y(row) = 5.0 + a + 2.0 * a * b + random.normal();
    }
    const auto design = FactorialDesign::create(factors, all_terms(2));
    ASSERT_TRUE(design.ok());
    const FactorialFit fit = design->fit(y);
    const double error = residual_ss(x, y);
    expect_equal(fit.error_sscp(0, 0), error);
    for (int term = 0; term < 3; ++term) {
      Eigen::MatrixXd without(rows, 3);
      for (int c = 0, to = 0; c < 4; ++c) {
        if (c != term + 1) without.col(to++) = x.col(c);
      }
      EXPECT_NEAR(fit.terms[term].sscp(0, 0), residual_ss(without, y) - error, 1e-10 * error);
    }
  }
}

TEST(FactorialModel, EmptyCellIsRefused) {
  DataSet data("warpbreaks.csv");
  data.drop_rows({0, 1, 2, 3, 4, 5, 6, 7, 8});  // wool A, tension L
  const auto design =
      FactorialDesign::create({data.factor("wool"), data.factor("tension")}, all_terms(2));
  ASSERT_FALSE(design.ok());
  EXPECT_NE(design.error().to_string().find("determines 5 parameters; expected all 6"),
            std::string::npos);
}

TEST(FactorialModel, DesignWithoutErrorIsRefused) {
  const Factor factor{"a", 3, {0, 1, 2}};
  EXPECT_FALSE(FactorialDesign::create({factor}, {{0}}).ok());
}

TEST(FactorialModel, ConstantResponseHasNoF) {
  const Factor factor{"a", 2, {0, 0, 1, 1, 1}};
  const auto design = FactorialDesign::create({factor}, {{0}});
  const FactorialFit fit = design->fit(Eigen::VectorXd::Constant(5, 0.1));
  EXPECT_TRUE(std::isnan(test_fixed_effect(fit, 0, 0).f));
}

TEST(FisherPlsd, OfPlantGrowthEqualsR) {
  const DataSet data("plant_growth.csv");
  const FactorialFit fit = fit_terms(data, {"group"}, {{0}}, {"weight"});
  expect_equal(test_fixed_effect(fit, 0, 0).f, 4.84608786238, 0.5e-11);
  std::vector<LevelMean> means(3);
  for (std::size_t row = 0; row < data.size(); ++row) {
    means[row / 10].mean += data.number(row, "weight") / 10.0;
    means[row / 10].count += 1.0;
  }
  const auto pairs = fisher_plsd(means, fit.error_sscp(0, 0) / fit.error_df, fit.error_df);
  ASSERT_EQ(pairs.size(), 3u);
  const double ps[] = {0.194387880054, 0.0876816750627, 0.00445923593821};
  const double adjusted[] = {0.194387880054, 0.175363350125, 0.0133777078146};
  std::vector<double> raw;
  for (const PlsdPair& pair : pairs) raw.push_back(pair.p);
  const auto holm = holm_adjusted(raw);
  for (std::size_t i = 0; i < 3; ++i) {
    expect_equal(pairs[i].p, ps[i], 0.5e-12);
    expect_equal(holm[i], adjusted[i], 0.5e-12);
    expect_equal(pairs[i].least_significant, 0.57201261156, 0.5e-11);
  }
}

Eigen::MatrixXd five_by_three() {
  Eigen::MatrixXd table(5, 3);
  table << 1, 3, 4, 2, 2, 3, 2, 5, 6, 3, 4, 4, 3, 5, 6;
  return table;
}

TEST(RepeatedMeasures, OfTheSmallExampleAreKnown) {
  const RepeatedEffect effect = repeated_measures({3}, five_by_three()).effects[0];
  expect_equal(effect.f, 13.5757575758, 0.5e-10);
  EXPECT_DOUBLE_EQ(effect.df1, 2.0);
  EXPECT_DOUBLE_EQ(effect.df2, 8.0);
  expect_equal(effect.epsilon, 0.575277337559, 0.5e-12);
  expect_equal(effect.p_gg, 0.0153706071352, 0.5e-13);
}

TEST(PairedT, OfTheSmallExampleByHolmAreEqual) {
  const Eigen::MatrixXd table = five_by_three();
  std::vector<double> raw;
  for (const auto& [i, j] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
    raw.push_back(paired_t(std::span(table.col(i).data(), 5), std::span(table.col(j).data(), 5)).p);
  }
  for (const double p : holm_adjusted(raw)) expect_equal(p, 0.0483902697003, 0.5e-13);
}

TEST(CousineauMorey, OfTheSmallExampleIsKnown) {
  const Eigen::VectorXd half = cousineau_morey_half_widths(five_by_three());
  expect_equal(half(0), 1.241663998204, 0.5e-12);
  expect_equal(half(1), 0.555289021040, 0.5e-12);
  expect_equal(half(2), 0.832933531559, 0.5e-12);
}

TEST(RepeatedMeasures, OfOneFactorEqualPingouin) {
  const DataSet data("rm_anova_wide.csv");
  std::vector<std::size_t> complete;
  for (std::size_t row = 0; row < data.size(); ++row) {
    if (data.is_complete(row)) complete.push_back(row);
  }
  ASSERT_EQ(complete.size(), 9u);
  Eigen::MatrixXd table(9, 4);
  const char* columns[] = {"Before", "1 week", "2 week", "3 week"};
  for (int i = 0; i < 9; ++i) {
    for (int c = 0; c < 4; ++c) table(i, c) = data.number(complete[i], columns[c]);
  }
  const RepeatedEffect effect = repeated_measures({4}, table).effects[0];
  expect_equal(effect.f, 5.20065155118, 0.5e-11);
  EXPECT_DOUBLE_EQ(effect.df1, 3.0);
  EXPECT_DOUBLE_EQ(effect.df2, 24.0);
  expect_equal(effect.epsilon, 0.694329331302, 0.5e-12);
}

TEST(RepeatedMeasures, OfTwoFactorsEqualPingouin) {
  const DataSet data("rm_anova2.csv");
  const Factor time = data.factor("Time"), metric = data.factor("Metric");
  Eigen::MatrixXd table(10, 6);
  for (std::size_t row = 0; row < data.size(); ++row) {
    table(std::stoi(data.at(row, "Subject")) - 1,
          3 * time.level_of_row[row] + metric.level_of_row[row]) = data.number(row, "Performance");
  }
  const auto effects = repeated_measures({2, 3}, table).effects;
  ASSERT_EQ(effects.size(), 3u);
  expect_equal(effects[0].f, 33.8522804629, 0.5e-10);
  EXPECT_DOUBLE_EQ(effects[0].df2, 9.0);
  EXPECT_DOUBLE_EQ(effects[0].epsilon, 1.0);
  expect_equal(effects[1].f, 26.9591896438, 0.5e-10);
  EXPECT_DOUBLE_EQ(effects[1].df1, 2.0);
  EXPECT_DOUBLE_EQ(effects[1].df2, 18.0);
  expect_equal(effects[1].epsilon, 0.9691029585, 0.5e-10);
  expect_equal(effects[2].f, 12.6322701689, 0.5e-10);
  expect_equal(effects[2].epsilon, 0.7271664202, 0.5e-10);
  expect_equal(effects[0].generalized_eta2, 0.254010981995, 0.5e-12);
  expect_equal(effects[1].generalized_eta2, 0.359334971048, 0.5e-12);
  expect_equal(effects[2].generalized_eta2, 0.0844199809419, 0.5e-13);
}

TEST(RepeatedMeasures, SumsOfSquaresAddUpToTheTotal) {
  Random random(18002);
  for (int repeat = 0; repeat < 20; ++repeat) {
    Eigen::MatrixXd table(7, 24);
    for (double& value : table.reshaped()) value = 1e3 + random.normal();
    const RepeatedMeasures result = repeated_measures({4, 2, 3}, table);
    double sum = result.participants_ss;
    for (const RepeatedEffect& effect : result.effects) sum += effect.ss + effect.error_ss;
    const double total = (table.array() - table.mean()).square().sum();
    EXPECT_NEAR(sum, total, 1e-9 * total);
  }
}

// One factor of two levels: F is the square of the paired t.
TEST(RepeatedMeasures, OfTwoLevelsAreThePairedT) {
  Random random(18003);
  Eigen::MatrixXd table(9, 2);
  for (double& value : table.reshaped()) value = random.normal();
  const RepeatedEffect effect = repeated_measures({2}, table).effects[0];
  const PairedT t = paired_t(std::span(table.col(0).data(), 9), std::span(table.col(1).data(), 9));
  expect_equal(effect.f, t.t * t.t);
  expect_equal(effect.p, t.p);
}

TEST(RepeatedMeasures, EqualDifferencesHaveNoF) {
  Eigen::MatrixXd table(3, 2);
  table << 0.1, 0.4, 1.1, 1.4, 7.1, 7.4;
  EXPECT_TRUE(std::isnan(repeated_measures({2}, table).effects[0].f));
}

TEST(Holm, LeavesOutWhatIsNotTested) {
  const double none = std::nan("");
  const auto adjusted = holm_adjusted(std::vector<double>{0.01, none, 0.04});
  EXPECT_DOUBLE_EQ(adjusted[0], 0.02);
  EXPECT_TRUE(std::isnan(adjusted[1]));
  EXPECT_DOUBLE_EQ(adjusted[2], 0.04);
  EXPECT_DOUBLE_EQ(holm_adjusted(std::vector<double>{0.9, 0.8})[0], 1.0);
}

// The ends solve (share - p)^2 = z^2 p (1 - p) / n.
TEST(Wilson, EndsSolveTheirEquation) {
  const double z = z_for_coverage(0.95);
  expect_equal(z, 1.959963984540054);
  for (const auto& [count, all] : {std::pair{1, 10}, std::pair{3, 30}, std::pair{29, 30}}) {
    const Interval interval = wilson_interval(count, all);
    const double share = static_cast<double>(count) / all;
    for (const double p : {interval.low, interval.high}) {
      EXPECT_NEAR((share - p) * (share - p), z * z * p * (1.0 - p) / all, 1e-14);
    }
    EXPECT_LT(interval.low, share);
    EXPECT_GT(interval.high, share);
  }
  EXPECT_EQ(wilson_interval(0, 30).low, 0.0);
  EXPECT_EQ(wilson_interval(30, 30).high, 1.0);
  expect_equal(wilson_interval(0, 30).high, z * z / (30.0 + z * z));
}

// Table values, and closed forms: F(2, v) has the tail (1 + 2 f / v)^(-v/2), and T with one degree
// of freedom is Cauchy's.
TEST(Distributions, AgreeWithTablesAndClosedForms) {
  EXPECT_NEAR(f_upper_tail(3.3158, 2, 30), 0.05, 1e-5);
  EXPECT_NEAR(f_upper_tail(4.1709, 1, 30), 0.05, 1e-5);
  EXPECT_NEAR(f_upper_tail(2.8663, 3, 36), 0.05, 1e-5);
  for (const double f : {0.1, 1.0, 12.0, 300.0}) {
    expect_equal(f_upper_tail(f, 2.0, 7.5), std::pow(1.0 + 2.0 * f / 7.5, -3.75));
    expect_equal(t_two_sided(-f, 1.0), 1.0 - 2.0 * std::atan(f) / std::numbers::pi, 1e-15);
  }
  expect_equal(t_two_sided(t_for_coverage(0.95, 13.0), 13.0), 0.05);
  EXPECT_TRUE(std::isnan(f_upper_tail(std::nan(""), 1, 2)));
  EXPECT_TRUE(std::isnan(f_upper_tail(1.0, 1, 0)));
  EXPECT_TRUE(std::isnan(t_two_sided(1.0, -1)));
  EXPECT_TRUE(std::isnan(t_for_coverage(1.0, 3)));
  EXPECT_EQ(f_upper_tail(0.0, 2, 5), 1.0);
}

}  // namespace
}  // namespace palpate::test
