// How often the tests reject on 10,000 data sets without any effect, at the 5 % level. The
// tolerances are three standard deviations of the binomial distribution or more.

#include <iostream>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/factorial_model.h"
#include "engine/analysis/intervals.h"
#include "engine/analysis/repeated_measures.h"
#include "engine/analysis/wilks.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

constexpr int kDataSets = 10'000;
constexpr int kParticipants = 10;
constexpr int kHaptic = 3, kRotation = 2, kObject = 4, kTrial = 3;
constexpr int kConditions = kHaptic * kRotation * kObject;
constexpr int kRows = kParticipants * kConditions * kTrial;
// The places of terms in all_terms(4) and all_terms(3), with the factors in the order above.
constexpr std::size_t kHapticTerm = 0;
constexpr std::size_t kObjectHapticRepeated = 4;  // after three main effects and haptic x rotation

class Rate {
 public:
  void count(double p) { rejected_ += p < kSignificance; }
  void expect(const char* of, double expected_percent, double tolerance_percent) const {
    const double percent = 100.0 * rejected_ / kDataSets;
    std::cout << of << ": " << percent << " % (expected " << expected_percent << ")\n";
    EXPECT_NEAR(percent, expected_percent, tolerance_percent) << of;
  }

 private:
  int rejected_ = 0;
};

// Rows in the order participant, haptic, rotation, object, trial.
FactorialDesign papers_design() {
  std::vector<Factor> factors = {{"haptic", kHaptic, {}},
                                 {"rotation", kRotation, {}},
                                 {"object", kObject, {}},
                                 {"trial", kTrial, {}}};
  for (int row = 0; row < kRows; ++row) {
    int rest = row;
    for (auto f = factors.rbegin(); f != factors.rend(); ++f) {
      f->level_of_row.push_back(rest % f->levels);
      rest /= f->levels;
    }
  }
  return *FactorialDesign::create(factors, all_terms(4));
}

// Means over the trials of each condition, one row a participant.
Eigen::MatrixXd cell_means(const Eigen::VectorXd& y) {
  Eigen::MatrixXd table(kParticipants, kConditions);
  for (int row = 0; row < kParticipants; ++row) {
    for (int cell = 0; cell < kConditions; ++cell) {
      table(row, cell) = y.segment((row * kConditions + cell) * kTrial, kTrial).mean();
    }
  }
  return table;
}

RepeatedMeasures repeated(const Eigen::VectorXd& y) {
  return repeated_measures({kHaptic, kRotation, kObject}, cell_means(y));
}

TEST(NullData, IndependentRowsAreRejectedAtTheNominalRate) {
  Random random(18101);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  const FactorialDesign design = papers_design();
  Rate manova, fixed, uncorrected, gg_haptic, gg_object_haptic;
  for (int set = 0; set < kDataSets; ++set) {
    Eigen::MatrixXd y(kRows, 3);
    for (double& value : y.reshaped()) value = random.normal();
    const FactorialFit fit = design.fit(y);
    const TermFit& haptic = fit.terms[kHapticTerm];
    manova.count(rao_test(wilks_lambda(fit.error_sscp, haptic.sscp), 3, haptic.df, fit.error_df).p);
    fixed.count(test_fixed_effect(fit, kHapticTerm, 0).p);
    const RepeatedMeasures primary = repeated(y.col(0));
    uncorrected.count(primary.effects[kHapticTerm].p);
    gg_haptic.count(primary.effects[kHapticTerm].p_gg);
    gg_object_haptic.count(primary.effects[kObjectHapticRepeated].p_gg);
    ASSERT_EQ(primary.effects[kObjectHapticRepeated].df1, 6.0);
  }
  manova.expect("MANOVA", 5.0, 0.65);
  fixed.expect("fixed effects", 5.0, 0.65);
  uncorrected.expect("repeated measures, uncorrected", 5.0, 0.65);
  gg_haptic.expect("Greenhouse-Geisser, Haptic", 4.0, 0.65);
  gg_object_haptic.expect("Greenhouse-Geisser, Object x Haptic", 2.0, 0.5);
}

// Rows of one participant are not independent: intercepts of one residual standard deviation, and
// scatter of the effect of haptic between participants.
void run_dependent(double scatter, double fixed_percent, double fixed_tolerance) {
  Random random(18102);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  const FactorialDesign design = papers_design();
  Rate fixed, uncorrected, gg;
  for (int set = 0; set < kDataSets; ++set) {
    Eigen::VectorXd y(kRows);
    for (int participant = 0; participant < kParticipants; ++participant) {
      const double intercept = random.normal();
      for (int haptic = 0; haptic < kHaptic; ++haptic) {
        const double shift = intercept + scatter * random.normal();
        constexpr int kRowsOfLevel = kConditions / kHaptic * kTrial;
        for (int row = 0; row < kRowsOfLevel; ++row) {
          y((participant * kHaptic + haptic) * kRowsOfLevel + row) = shift + random.normal();
        }
      }
    }
    fixed.count(test_fixed_effect(design.fit(y), kHapticTerm, 0).p);
    const RepeatedEffect effect = repeated(y).effects[kHapticTerm];
    uncorrected.count(effect.p);
    gg.count(effect.p_gg);
  }
  fixed.expect("fixed effects", fixed_percent, fixed_tolerance);
  uncorrected.expect("repeated measures, uncorrected", 5.0, 0.65);
  gg.expect("Greenhouse-Geisser, Haptic", 4.0, 0.65);
}

TEST(NullData, InterceptsMakeThePapersAnalysisRejectTooRarely) {
  run_dependent(0.0, 0.4, 0.2);
}

TEST(NullData, ScatterMakesThePapersAnalysisRejectTooOften) {
  run_dependent(0.4, 27.5, 1.5);
}

}  // namespace
}  // namespace palpate::test
