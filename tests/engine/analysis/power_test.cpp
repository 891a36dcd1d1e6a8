// Power by simulation: against the noncentral distributions, against the primary analysis of the
// same tables and of whole trials, and the estimates of pilots.

#include <array>
#include <boost/math/distributions/non_central_f.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "engine/analysis/comparisons.h"
#include "engine/analysis/distributions.h"
#include "engine/analysis/intervals.h"
#include "engine/analysis/power_fit.h"
#include "engine/analysis/power_notes.h"
#include "engine/analysis/power_paper.h"
#include "engine/analysis/power_pilot.h"
#include "engine/analysis/power_run.h"
#include "engine/analysis/power_study.h"
#include "engine/analysis/power_sums.h"
#include "engine/analysis/primary_analysis.h"
#include "engine/analysis/repeated_measures.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

constexpr int kSets = 10'000;

const PowerDesign kSix = {{"NoH", "UaH", "H"}, {"NoR", "R"}};
const PowerDesign kThree = {{"NoH", "UaH", "H"}, {"NoR"}};
const PowerDesign kTwo = {{"UaH"}, {"NoR", "R"}};

std::size_t place_of(const PowerTests& tests, const std::string& name, PowerCorrection correction) {
  for (std::size_t t = 0; t < tests.tests.size(); ++t) {
    if (tests.tests[t].name == name && tests.tests[t].correction == correction) return t;
  }
  ADD_FAILURE() << "no test " << name;
  return 0;
}

double share_of(const PowerCounts& counts, std::size_t test, int n) {
  return static_cast<double>(counts.at(0, test, n)) / kSets;
}

// Three standard errors of a share of kSets.
double three_errors(double share) {
  return 3.0 * std::sqrt(share * (1.0 - share) / kSets);
}

double noncentral_f_power(double lambda, double df1, double df2) {
  const double limit = f_for_tail(kSignificance, df1, df2);
  return boost::math::cdf(
      boost::math::complement(boost::math::non_central_f(df1, df2, lambda), limit));
}

double noncentral_t_power(double delta, double df) {
  const double limit = t_for_coverage(1.0 - kSignificance, df);
  const boost::math::non_central_t t(df, delta);
  return boost::math::cdf(boost::math::complement(t, limit)) + boost::math::cdf(t, -limit);
}

// Differences of the sd 1 in a pair of conditions.
TEST(Power, OfPairedValuesIsThatOfNoncentralT) {
  struct Known {
    int n;
    double d_z, power;
  };
  for (const Known& known :
       {Known{10, 0.5, 0.2931756}, Known{34, 0.5, 0.8077775}, Known{10, 1.0, 0.8030969}}) {
    EXPECT_NEAR(noncentral_t_power(known.d_z * std::sqrt(known.n), known.n - 1.0), known.power,
                1e-7);
    // var(R - NoR) = 2 (w + e / m)
    const PowerModel model{kTwo, {3.0, 3.0 + known.d_z}, 4, {{7.0, 0.25, 1.0}}};
    const PowerTests tests = power_tests(kTwo);
    PowerSettings settings;
    settings.participants = known.n;
    const auto counts = simulate_power(model, tests, settings);
    ASSERT_TRUE(counts);
    for (const auto& [name, correction] : {std::pair("Rotation", PowerCorrection::kNone),
                                           std::pair("R - NoR in UaH", PowerCorrection::kHolm)}) {
      const double found = share_of(*counts, place_of(tests, name, correction), known.n);
      std::cout << name << ", n " << known.n << ", d_z " << known.d_z << ": " << found
                << " (expected " << known.power << ")\n";
      EXPECT_NEAR(found, known.power, three_errors(known.power));
    }
  }
}

// k levels with one value a cell, of the variance 1 and the correlation rho; f is the standard
// deviation of the k means.
TEST(Power, OfRepeatedMeasuresIsThatOfNoncentralFAndLowerByGreenhouseAndGeisser) {
  struct Known {
    int n;
    double f, rho, power, about_gg;
  };
  for (const Known& known :
       {Known{28, 0.25, 0.5, 0.8124546, 0.80}, Known{10, 0.5, 0.5, 0.8991220, 0.87}}) {
    const double k = 3.0;
    const double lambda = known.f * known.f * known.n * k / (1.0 - known.rho);
    EXPECT_NEAR(noncentral_f_power(lambda, k - 1.0, (k - 1.0) * (known.n - 1.0)), known.power,
                1e-7);
    const double step = known.f * std::sqrt(1.5);  // of the means -step, 0 and step
    const PowerModel model{kThree,
                           {-step, 0.0, step},
                           1,
                           {{known.rho, 0.5 * (1.0 - known.rho), 0.5 * (1.0 - known.rho)}}};
    const PowerTests tests = power_tests(kThree);
    PowerSettings settings;
    settings.participants = known.n;
    const auto counts = simulate_power(model, tests, settings);
    ASSERT_TRUE(counts);
    const double plain =
        share_of(*counts, place_of(tests, "Haptic", PowerCorrection::kNone), known.n);
    const double gg =
        share_of(*counts, place_of(tests, "Haptic", PowerCorrection::kGreenhouseGeisser), known.n);
    std::cout << "n " << known.n << ": " << plain << " (expected " << known.power
              << "), Greenhouse-Geisser " << gg << "\n";
    EXPECT_NEAR(plain, known.power, three_errors(known.power));
    EXPECT_LT(gg, plain);
    EXPECT_NEAR(gg, known.about_gg, 0.5e-2 + three_errors(known.about_gg));
  }
}

// Every effect of the six conditions, at several n of one simulation. The noise is w + e / m.
TEST(Power, OfEachEffectAndNumberOfPeopleIsThatOfNoncentralF) {
  const PowerModel model{kSix, {0.3, 0.9, 0.1, 0.2, -0.4, 0.8}, 3, {{5.0, 0.2, 0.9}}};
  const double noise = 0.2 + 0.9 / 3.0;
  const PowerTests tests = power_tests(kSix);
  const auto counts = simulate_power(model, tests, PowerSettings{});
  ASSERT_TRUE(counts);
  const Eigen::Map<const Eigen::VectorXd> means(model.means.data(), 6);
  for (const char* const name : {"Haptic", "Rotation", "Rotation x Haptic"}) {
    const std::size_t t = place_of(tests, name, PowerCorrection::kNone);
    const auto& test = tests.tests[t];
    const auto df1 = static_cast<double>(test.scores);
    const double of_means =
        (tests.weights.middleCols(test.first_score, test.scores).transpose() * means).squaredNorm();
    for (const int n : {2, 3, 6, 12, 30, 60}) {
      const double expected = noncentral_f_power(n * of_means / noise, df1, df1 * (n - 1.0));
      EXPECT_NEAR(share_of(*counts, t, n), expected, three_errors(expected)) << name << ", n " << n;
    }
  }
}

// The first n rows of simulated tables.
TEST(Power, SumsDecideAsThePrimaryAnalysisOfTheSameTable) {
  const PowerModel model{kSix, {29.0, 29.5, 27.0, 28.0, 25.0, 27.5}, 12, {{16.0, 4.0, 60.0}}};
  const PowerTests tests = power_tests(kSix);
  PowerSettings settings;
  const PowerLimits limits(tests, settings.participants);
  PowerSums sums(tests);
  std::array<bool, 16> found{};
  std::map<bool, int> seen;
  for (int set = 0; set < 60; ++set) {
    const Eigen::MatrixXd table = power_data_set(model, 0, settings, set);
    sums.clear();
    for (int n = 1; n <= settings.participants; ++n) {
      const Eigen::VectorXd row = table.row(n - 1);
      sums.add({row.data(), 6});
      if (n < 2) continue;
      sums.decide(limits, found);
      const Eigen::MatrixXd first = table.topRows(n);
      std::vector<bool> expected;
      for (const RepeatedEffect& effect : repeated_measures({3, 2}, first).effects) {
        const auto t = expected.size();
        EXPECT_NEAR(sums.f(tests.tests[t]), effect.f, 1e-9 * effect.f);
        EXPECT_NEAR(sums.epsilon(tests.tests[t]), effect.epsilon, 1e-9);
        expected.push_back(effect.p < kSignificance);
        if (effect.df1 > 1.0) expected.push_back(effect.p_gg < kSignificance);
      }
      const auto of_haptic = [&](int h) -> Eigen::VectorXd {
        return 0.5 * (first.col(2 * h) + first.col(2 * h + 1));
      };
      std::vector<double> p;
      const auto compare = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        const PairedT t = paired_t({a.data(), static_cast<std::size_t>(n)},
                                   {b.data(), static_cast<std::size_t>(n)});
        const double t2 = sums.t2(tests.tests[expected.size() + p.size()]);
        EXPECT_NEAR(t2, t.t * t.t, 1e-9 * t2);
        p.push_back(t.p);
      };
      const auto end_family = [&] {
        for (const double adjusted : holm_adjusted(p)) expected.push_back(adjusted < kSignificance);
        p.clear();
      };
      compare(of_haptic(1), of_haptic(0));
      compare(of_haptic(2), of_haptic(0));
      compare(of_haptic(2), of_haptic(1));
      end_family();
      for (int h = 0; h < 3; ++h) compare(first.col(2 * h + 1), first.col(2 * h));
      end_family();
      ASSERT_EQ(expected.size(), tests.tests.size());
      for (std::size_t t = 0; t < expected.size(); ++t) {
        EXPECT_EQ(found[t], expected[t]) << tests.tests[t].name << ", set " << set << ", n " << n;
        ++seen[expected[t]];
      }
    }
  }
  EXPECT_GT(seen[true], 1000);
  EXPECT_GT(seen[false], 1000);
}

// The decision by steps of epsilon is the one by the p value, at F on both sides of the limit.
TEST(Power, GreenhouseGeisserDecidesByThePValue) {
  Random random(23001);
  const PowerLimits limits(power_tests(kThree), 60);
  for (int repeat = 0; repeat < 20'000; ++repeat) {
    const int n = 2 + static_cast<int>(random.index(59));
    const double epsilon = n == 2 ? 0.5 : random.uniform(0.5, 1.0);
    const double df1 = 2.0 * epsilon;
    const double critical = f_for_tail(kSignificance, df1, df1 * (n - 1.0));
    const double f = critical * std::exp(random.normal() * std::pow(10.0, -random.uniform(0, 12)));
    EXPECT_EQ(limits.is_significant_gg(f, epsilon, n),
              f_upper_tail(f, df1, df1 * (n - 1.0)) < kSignificance)
        << "F " << f << ", epsilon " << epsilon << ", n " << n;
  }
}

TrialRow trial_of(const std::string& participant, const std::string& haptic,
                  const std::string& rotation, int object, int block, double time) {
  TrialRow row;
  row.participant = participant;
  row.haptic = haptic;
  row.rotation = rotation;
  row.object = "O" + std::to_string(object + 1);
  row.block = block;
  row.measures[kTotalTime] = time;
  return row;
}

struct Pilot {
  int participants, objects, blocks;
  PowerVariances variances;
  double common = 0.0;  // sd of what all participants have in common in a condition, object, block
  double step = 1.0;    // between the means of the conditions
};

// Trials of the model, around a mean of 100 s.
std::vector<TrialRow> pilot_trials(const Pilot& pilot, Random& random) {
  std::map<std::pair<std::size_t, int>, double> common;
  std::vector<TrialRow> rows;
  for (int p = 0; p < pilot.participants; ++p) {
    const double u = std::sqrt(pilot.variances.u) * random.normal();
    for (std::size_t c = 0; c < kSix.conditions(); ++c) {
      const double w = std::sqrt(pilot.variances.w) * random.normal();
      for (int item = 0; item < pilot.objects * pilot.blocks; ++item) {
        if (p == 0) common[{c, item}] = pilot.common * random.normal();
        const double y = 100.0 + pilot.step * static_cast<double>(c) + u + w + common[{c, item}] +
                         std::sqrt(pilot.variances.e) * random.normal();
        rows.push_back(trial_of(std::to_string(p + 1), kSix.haptic[c / 2], kSix.rotation[c % 2],
                                item % pilot.objects, 1 + item / pilot.objects, y));
      }
    }
  }
  return rows;
}

PilotEstimate estimate_of(std::vector<TrialRow> rows) {
  const auto table = TrialTable::create(std::move(rows), 1000.0);
  EXPECT_TRUE(table.ok());
  const auto found = estimate_pilot(*table, Outcome::kTime, kSix, "pilot.csv");
  EXPECT_TRUE(found.ok()) << found.error().to_string();
  return *found;
}

// Whole trials of data sets, by the analysis of `experiment analyse`. Objects and blocks, which
// move all participants and conditions alike, change nothing.
TEST(Power, IsTheShareOfSignificantAnalysesOfWholeTrials) {
  Random random(23002);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  constexpr int kAnalyses = 1500;
  constexpr int kPeople = 6;
  const Pilot pilot{kPeople, 2, 2, {9.0, 1.0, 6.0}, 0.0, 0.5};
  const PowerModel model{kSix, {0.0, 0.5, 1.0, 1.5, 2.0, 2.5}, 4, {pilot.variances}};
  const PowerTests tests = power_tests(kSix);
  const auto counts = simulate_power(model, tests, PowerSettings{});
  std::map<std::string, int> significant;
  for (int i = 0; i < kAnalyses; ++i) {
    std::vector<TrialRow> rows = pilot_trials(pilot, random);
    for (TrialRow& row : rows) {
      *row.measures[kTotalTime] += (row.object == "O1" ? 5.0 : -5.0) + 4.0 * row.block;
    }
    const auto table = TrialTable::create(std::move(rows), 1000.0);
    const PrimaryAnalysis analysis = analyse_repeated_measures(*table, Outcome::kTime);
    significant["Haptic"] += analysis.effect({kHapticFactor})->test->p < kSignificance;
    significant["gg"] += analysis.effect({kHapticFactor})->test->p_gg < kSignificance;
    significant["Rotation"] += analysis.effect({kRotationFactor})->test->p < kSignificance;
    significant["H - NoH"] += analysis.families[0].pairs[1].p_holm < kSignificance;
  }
  const auto expect_share = [&](const char* key, const char* name, PowerCorrection correction) {
    const double power = share_of(*counts, place_of(tests, name, correction), kPeople);
    const double found = static_cast<double>(significant[key]) / kAnalyses;
    std::cout << key << ": " << found << " of whole trials, " << power << " by power\n";
    EXPECT_GT(power, 0.1);
    EXPECT_LT(power, 0.9);
    // Both are shares of random data sets.
    const double variance = power * (1.0 - power) * (1.0 / kAnalyses + 1.0 / kSets);
    EXPECT_NEAR(found, power, 3.0 * std::sqrt(variance)) << key;
  };
  expect_share("Haptic", "Haptic", PowerCorrection::kNone);
  expect_share("gg", "Haptic", PowerCorrection::kGreenhouseGeisser);
  expect_share("Rotation", "Rotation", PowerCorrection::kNone);
  expect_share("H - NoH", "H - NoH", PowerCorrection::kHolm);
}

TEST(Power, DoesNotDependOnJobsOrTheLargestNumberOfPeople) {
  const PowerModel model{kSix, {0.0, 1.0, 0.0, 1.0, 2.0, 1.0}, 2, {{1, 1, 1}, {1, 3, 2}}};
  const PowerTests tests = power_tests(kSix);
  PowerSettings settings;
  settings.sets = 503;
  settings.participants = 20;
  const auto one = simulate_power(model, tests, settings);
  settings.jobs = 2;
  const auto two = simulate_power(model, tests, settings);
  settings.participants = 31;
  const auto more = simulate_power(model, tests, settings);
  settings.seed = 7;
  const auto other = simulate_power(model, tests, settings);
  int differences = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t t = 0; t < tests.tests.size(); ++t) {
      for (int n = 2; n <= 20; ++n) {
        EXPECT_EQ(one->at(i, t, n), two->at(i, t, n));
        EXPECT_EQ(one->at(i, t, n), more->at(i, t, n));
        differences += one->at(i, t, n) != other->at(i, t, n);
      }
    }
  }
  EXPECT_GT(differences, 100);
}

// w and e in other parts, and another u.
TEST(Power, EqualNoiseGivesEqualNumbers) {
  const PowerModel model{
      kSix, {0.0, 1.0, 0.0, 1.0, 2.0, 1.0}, 4, {{0, 0.1, 3.6}, {0, 2, 2}, {9, 0.7, 1.2}}};
  EXPECT_EQ(first_of_equal_noise(model), (std::vector<std::size_t>{0, 1, 0}));
  PowerModel last = model;
  last.variances = {model.variances[2]};
  const PowerTests tests = power_tests(kSix);
  PowerSettings settings;
  settings.sets = 500;
  const auto counts = simulate_power(model, tests, settings);
  const auto alone = simulate_power(last, tests, settings);
  int differences = 0;
  for (std::size_t t = 0; t < tests.tests.size(); ++t) {
    for (int n = 2; n <= settings.participants; ++n) {
      EXPECT_EQ(counts->at(0, t, n), counts->at(2, t, n));
      EXPECT_EQ(alone->at(0, t, n), counts->at(2, t, n));
      differences += counts->at(0, t, n) != counts->at(1, t, n);
    }
  }
  EXPECT_GT(differences, 100);
}

TEST(Power, StopsWithoutAResult) {
  const PowerModel model{kTwo, {0.0, 1.0}, 1, {{1, 1, 1}}};
  StopFlag stop;
  stop.request();
  EXPECT_FALSE(simulate_power(model, power_tests(kTwo), PowerSettings{}, {}, &stop));
}

TEST(Power, SmallestNumberIsTheFirstFromWhichThePowerStays) {
  PowerCounts counts(1, 1, 6);  // n = 2 to 6
  const auto set = [&](std::array<int, 5> values) {
    for (int n = 2; n <= 6; ++n) counts.at(0, 0, n) = values[static_cast<std::size_t>(n - 2)];
  };
  set({10, 80, 79, 80, 95});
  EXPECT_EQ(counts.smallest(0, 0, 100, 80), 5);
  EXPECT_EQ(counts.smallest(0, 0, 100, 90), 6);
  EXPECT_EQ(counts.smallest(0, 0, 100, 10), 2);
  EXPECT_EQ(counts.smallest(0, 0, 100, 96), std::nullopt);
  set({10, 80, 85, 90, 79});
  EXPECT_EQ(counts.smallest(0, 0, 100, 80), std::nullopt);
}

// The standard deviations follow from the paper's numbers as they are printed there.
TEST(PowerOfThePaper, HasTheScatterOfItsOwnModel) {
  const auto time = paper_trial_scatter(Outcome::kTime);
  EXPECT_NEAR(time[0].sd, 9.0, 0.05);
  EXPECT_NEAR(time[1].sd, 9.9, 0.05);
  const auto losses = paper_trial_scatter(Outcome::kLosses);
  EXPECT_EQ(losses[1].from, "Haptic");
  EXPECT_NEAR(losses[1].sd, 5.4, 0.05);
  EXPECT_NEAR(losses[0].sd, 2.8, 0.05);
  const auto penetration = paper_trial_scatter(Outcome::kPenetration);
  EXPECT_NEAR(penetration[0].sd, 0.0146, 0.00005);
  EXPECT_NEAR(penetration[1].sd, 0.0188, 0.00005);
  EXPECT_NEAR(paper_angle_scatter().sd, 4.29, 0.005);
}

// By trying means of the losses in steps of a hundredth within half a digit.
TEST(PowerOfThePaper, RoundingOfItsMeansAllowsARangeOfErrors) {
  const auto scatter = paper_trial_scatter(Outcome::kLosses);
  constexpr int kSteps = 100;
  double least = 1e9, most = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k <= kSteps; ++k) {
        const double a = 23.5 + i / 100.0, b = 21.5 + j / 100.0, c = 20.5 + k / 100.0;
        const double mean = (a + b + c) / 3.0;
        const double squares =
            std::pow(a - mean, 2) + std::pow(b - mean, 2) + std::pow(c - mean, 2);
        const double sd = std::sqrt(240.0 * squares / 2.0 / 19.139);
        least = std::min(least, sd);
        most = std::max(most, sd);
      }
    }
  }
  EXPECT_NEAR(scatter[1].low, least, 1e-12 * least);  // the extremes are at steps
  EXPECT_NEAR(scatter[1].high, most, 1e-12 * most);
  EXPECT_NEAR(least, 3.54, 0.005);
  EXPECT_NEAR(most, 7.37, 0.005);
  EXPECT_EQ(scatter[0].low, 0.0);  // 22.5 and 22.5
  EXPECT_NEAR(scatter[0].high, std::sqrt(360.0 * 2.0 / 22.389), 1e-12);
  EXPECT_FALSE(scatter[1].allows(scatter[0].sd));
  EXPECT_TRUE(scatter[0].allows(scatter[1].sd));
  EXPECT_EQ(paper_rounding(29.0), 0.5);
  EXPECT_DOUBLE_EQ(paper_rounding(27.5), 0.05);
  EXPECT_DOUBLE_EQ(paper_rounding(0.101), 0.0005);
}

TEST(PowerOfThePaper, MeansKeepTheLevelsAndHaveNoInteraction) {
  for (const Outcome outcome : {Outcome::kTime, Outcome::kLosses, Outcome::kPenetration}) {
    const auto means = paper_condition_means(outcome);
    const PowerTests tests = power_tests(kSix);
    EXPECT_TRUE(tests.is_null(
        tests.tests[place_of(tests, "Rotation x Haptic", PowerCorrection::kNone)], means));
    EXPECT_FALSE(
        tests.is_null(tests.tests[place_of(tests, "Haptic", PowerCorrection::kNone)], means));
  }
  const auto time = paper_condition_means(Outcome::kTime);
  EXPECT_NEAR(0.5 * (time[0] + time[1]), 29.0, 1e-12);
  EXPECT_NEAR(time[1] - time[0], 29.15 - 25.14, 1e-12);
}

// Of the paper's experiment, the scatter of the paired difference must come out again.
TEST(PowerOfThePaper, AngleHasThePairedDifferenceWithAnyShares) {
  PowerRequest request;
  request.measure = "angle";
  const auto study = prepare_power(request);
  ASSERT_TRUE(study.ok());
  EXPECT_EQ(study->assumptions.size(), 36u);
  for (std::size_t i = 0; i < study->assumptions.size(); ++i) {
    EXPECT_NEAR(std::sqrt(2.0 * study->noise(i)), paper_angle_scatter().sd, 1e-12);
  }
  EXPECT_TRUE(study->has_one_noise());
  request.trials = 4;
  EXPECT_FALSE(prepare_power(request)->has_one_noise());
}

TEST(PowerRequest, SharesArePartsOfTheVarianceOfOneTrial) {
  PowerRequest request;
  request.error_sd = 10.0;
  request.share_u = 0.3;
  request.share_w = 0.1;
  const auto study = prepare_power(request);
  ASSERT_TRUE(study.ok());
  ASSERT_EQ(study->model.variances.size(), 1u);
  EXPECT_NEAR(study->model.variances[0].u, 30.0, 1e-12);
  EXPECT_NEAR(study->model.variances[0].w, 10.0, 1e-12);
  EXPECT_NEAR(study->model.variances[0].e, 60.0, 1e-12);
  EXPECT_NEAR(study->noise(0), 10.0 + 60.0 / 12.0, 1e-12);
  request.share_w.reset();
  EXPECT_EQ(prepare_power(request)->assumptions.size(), 6u);  // w 0.1 to 0.6
  request.share_u.reset();
  EXPECT_EQ(prepare_power(request)->assumptions.size(), 36u);
}

// Estimates before negative ones become 0. Their mean is compared with the truth by its own
// standard error.
class Estimates {
 public:
  void add(const PowerVariances& raw) {
    const double values[] = {raw.u, raw.w, raw.e};
    for (int i = 0; i < 3; ++i) of_[i].push_back(values[i]);
  }
  void expect(const PowerVariances& truth, int least_negative_w) const {
    const double values[] = {truth.u, truth.w, truth.e};
    for (int i = 0; i < 3; ++i) {
      const MeanInterval mean = mean_interval(of_[i]);
      double squares = 0.0;
      for (const double x : of_[i]) squares += (x - mean.mean) * (x - mean.mean);
      const double n = static_cast<double>(of_[i].size());
      const double error = std::sqrt(squares / (n - 1.0) / n);
      std::cout << "uwe"[i] << ": mean " << mean.mean << " +- " << error << ", truth " << values[i]
                << "\n";
      EXPECT_NEAR(mean.mean, values[i], 3.0 * error) << "uwe"[i];
    }
    int negative = 0;
    for (const double w : of_[1]) negative += w < 0.0;
    EXPECT_GE(negative, least_negative_w);
  }

 private:
  std::array<std::vector<double>, 3> of_;
};

constexpr int kPilots = 200;

TEST(PowerPilot, EstimatesAreUnbiasedOver200Pilots) {
  Random random(23003);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  const PowerVariances truth{30.0, 2.0, 60.0};  // w is often estimated below 0
  Estimates estimates;
  for (int i = 0; i < kPilots; ++i) {
    const PilotEstimate found = estimate_of(pilot_trials({5, 4, 3, truth}, random));
    EXPECT_EQ(found.variances.w, std::max(0.0, found.raw.w));
    EXPECT_EQ(found.m, 12.0);
    EXPECT_EQ(found.df_e, 6 * 4 * 11);
    estimates.add(found.raw);
  }
  estimates.expect(truth, 10);
}

// A tenth of the trials is missing at random; objects and blocks differ more than trials.
TEST(PowerPilot, EstimatesAreUnbiasedOver200PilotsWithMissingTrialsAndUnlikeObjects) {
  Random random(23004);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  const PowerVariances truth{30.0, 6.0, 20.0};
  Estimates estimates;
  for (int i = 0; i < kPilots; ++i) {
    std::vector<TrialRow> rows = pilot_trials({5, 2, 2, truth, 12.0}, random);
    for (TrialRow& row : rows) {
      if (random.uniform(0.0, 1.0) < 0.1) row.status = TrialStatus::kTimeout;
    }
    const PilotEstimate found = estimate_of(std::move(rows));
    EXPECT_LT(found.m, 4.0);
    estimates.add(found.raw);
  }
  estimates.expect(truth, 0);
}

// By the definitions of the mean squares, for a pilot without missing trials and without anything
// in common.
TEST(PowerPilot, MeanSquaresAreThoseOfTheAnalysisOfVariance) {
  Random random(23005);
  constexpr int n = 4, k = 6, m = 6;
  const auto rows = pilot_trials({n, 3, 2, {4.0, 3.0, 2.0}}, random);
  double y[n][k][m];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    y[i / (k * m)][i / m % k][i % m] = *rows[i].measures[kTotalTime];
  }
  double cell[n][k] = {}, person[n] = {}, condition[k] = {}, item[k][m] = {}, all = 0.0;
  for (int p = 0; p < n; ++p) {
    for (int c = 0; c < k; ++c) {
      for (int t = 0; t < m; ++t) {
        cell[p][c] += y[p][c][t] / m;
        item[c][t] += y[p][c][t] / n;
      }
      person[p] += cell[p][c] / k;
      condition[c] += cell[p][c] / n;
      all += cell[p][c] / (n * k);
    }
  }
  double ss_p = 0.0, ss_pc = 0.0, ss_e = 0.0;
  for (int p = 0; p < n; ++p) {
    ss_p += k * m * (person[p] - all) * (person[p] - all);
    for (int c = 0; c < k; ++c) {
      ss_pc += m * std::pow(cell[p][c] - person[p] - condition[c] + all, 2);
      for (int t = 0; t < m; ++t) {
        ss_e += std::pow(y[p][c][t] - cell[p][c] - item[c][t] + condition[c], 2);
      }
    }
  }
  const PilotEstimate found = estimate_of(rows);
  const double ms_p = ss_p / (n - 1), ms_pc = ss_pc / ((n - 1) * (k - 1)),
               ms_e = ss_e / (k * (n - 1) * (m - 1));
  EXPECT_NEAR(found.ms_p, ms_p, 1e-9 * ms_p);
  EXPECT_NEAR(found.ms_pc, ms_pc, 1e-9 * ms_pc);
  EXPECT_NEAR(found.ms_e, ms_e, 1e-9 * ms_e);
  EXPECT_NEAR(found.raw.e, ms_e, 1e-9 * ms_e);
  EXPECT_NEAR(found.raw.w, (ms_pc - ms_e) / m, 1e-9 * ms_pc);
  EXPECT_NEAR(found.raw.u, (ms_p - ms_pc) / (k * m), 1e-9 * ms_p);
  EXPECT_NEAR(found.means[2], condition[2], 1e-9);
  EXPECT_EQ(found.df_pc, (n - 1) * (k - 1));
}

// With missing trials: a regression on columns of participants and, with the sum 0, of objects and
// blocks gives the means of the participants in each condition, and their covariance.
TEST(PowerPilot, MissingTrialsAreAdjustedForByLeastSquares) {
  Random random(23007);
  constexpr int n = 4, k = 6, items = 4;
  auto rows = pilot_trials({n, 2, 2, {4.0, 3.0, 2.0}, 6.0}, random);
  for (std::size_t i = 0; i < rows.size(); i += 5) rows[i].status = TrialStatus::kTimeout;
  Eigen::MatrixXd cells(n, k);
  double residual_ss = 0.0, mean_scatter = 0.0;
  int df = 0;
  for (int c = 0; c < k; ++c) {
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(n * items, n + items - 1);
    Eigen::VectorXd y(n * items);
    Eigen::Index count = 0;
    for (int p = 0; p < n; ++p) {
      for (int item = 0; item < items; ++item) {
        const TrialRow& row = rows[static_cast<std::size_t>((p * k + c) * items + item)];
        if (row.status != TrialStatus::kDone) continue;
        x(count, p) = 1.0;
        if (item + 1 < items) x(count, n + item) = 1.0;
        if (item + 1 == items) x.row(count).tail(items - 1).setConstant(-1.0);
        y(count++) = *row.measures[kTotalTime];
      }
    }
    const Eigen::MatrixXd of_done = x.topRows(count);
    const Eigen::MatrixXd inverse = (of_done.transpose() * of_done).inverse();
    const Eigen::VectorXd fitted = inverse * (of_done.transpose() * y.head(count));
    cells.col(c) = fitted.head(n);
    residual_ss += (y.head(count) - of_done * fitted).squaredNorm();
    df += static_cast<int>(count) - (n + items - 1);
    const Eigen::MatrixXd covariance = inverse.topLeftCorner(n, n);
    mean_scatter += covariance.trace() - covariance.sum() / n;
  }
  const double m = k * (n - 1) / mean_scatter;
  const Eigen::MatrixXd centred = cells.rowwise() - cells.colwise().mean();
  const double ss_p = m * k * centred.rowwise().mean().squaredNorm();
  const double ss_pc = m * (centred.colwise() - centred.rowwise().mean()).squaredNorm();
  const PilotEstimate found = estimate_of(rows);
  EXPECT_LT(m, 3.5);
  EXPECT_NEAR(found.m, m, 1e-9 * m);
  EXPECT_EQ(found.df_e, df);
  EXPECT_NEAR(found.ms_e, residual_ss / df, 1e-9 * residual_ss);
  EXPECT_NEAR(found.ms_pc, ss_pc / ((n - 1) * (k - 1)), 1e-9 * ss_pc);
  EXPECT_NEAR(found.ms_p, ss_p / (n - 1), 1e-9 * ss_p);
}

// Practice counts for nothing, and a participant without one condition is left out by name.
TEST(PowerPilot, LeavesOutPracticeAndIncompleteParticipants) {
  Random random(23006);
  const auto rows = pilot_trials({3, 2, 2, {4.0, 3.0, 2.0}}, random);
  const PilotEstimate plain = estimate_of(rows);
  auto more = rows;
  for (const TrialRow& row : rows) {
    TrialRow practice = row;
    practice.block = 0;
    *practice.measures[kTotalTime] *= 7.0;
    more.push_back(practice);
    if (row.participant != "1" || row.rotation == "R") continue;
    more.push_back(row);
    more.back().participant = "Zoe";
  }
  const PilotEstimate found = estimate_of(more);
  EXPECT_EQ(found.left_out, std::vector<std::string>{"Zoe"});
  EXPECT_EQ(found.participants, 3);
  EXPECT_EQ(found.ms_e, plain.ms_e);
  EXPECT_EQ(found.ms_p, plain.ms_p);
}

TEST(PowerPilot, NotesSayWhatIsNegativeMissingOrNotNormal) {
  PowerRequest request;
  request.measure = "losses";
  auto study = prepare_power(request);
  ASSERT_TRUE(study.ok());
  study->pilot = PilotEstimate{};
  study->pilot->raw = {-1.0, -2.0, 3.0};
  study->pilot->variances = {0.0, 0.0, 3.0};
  study->pilot->ms_pc = 1.0;
  study->pilot->ms_e = 5.0;
  study->pilot->m = 4.0;
  study->pilot->df_pc = 8;
  study->pilot->df_e = 40;
  study->pilot->means = {22.0};
  study->pilot->cells = Eigen::MatrixXd::Zero(3, 6);
  study->pilot->missing = 5;
  study->pilot->left_out = {"Zoe"};
  std::string notes;
  for (const std::string& note : power_notes(*study)) notes += note + "\n";
  for (const char* const part :
       {"a count", "variance of u is -1, which is negative; 0 is used",
        "variance of w is -2, which is negative; 0 is used", "Zoe", "5 of 5 trials", "50 %",
        "MS_e / m = 1.25, is larger than what was observed, MS_pc / m = 0.25, by the factor 5",
        "The model does not fit this pilot: F = MS_pc / MS_e = 0.2 with 8 and 40 degrees",
        "The pilot's m is 4 trials of a person in a condition, an effective number; 12 are used",
        "as in the pilot, more people are needed", "are a lower bound", "Sphericity",
        "R - NoR = 1 may be 0 to 2"}) {
    EXPECT_NE(notes.find(part), std::string::npos) << part << "\n" << notes;
  }
  EXPECT_EQ(notes.find("Check the units"), std::string::npos);
  study->pilot->means = {0.4};
  EXPECT_NE(power_notes(*study)[0].find("Check the units: the mean of the pilot is 0.4"),
            std::string::npos);
}

// P(F < f) by counting: the ratio of two mean squares of normal numbers.
TEST(PowerPilot, FitIsTheTailOfFAndThePairsAreThoseOfThePeople) {
  Random random(23008);
  std::cout << "PALPATE_SEED=" << random.seed() << '\n';
  PilotEstimate pilot;
  pilot.df_pc = 10;
  pilot.df_e = 36;
  pilot.ms_pc = 0.5;
  pilot.ms_e = 1.0;
  pilot.m = 4.0;
  pilot.variances = {1.0, 0.0, 1.0};
  pilot.cells = Eigen::MatrixXd::Zero(3, 6);
  pilot.cells.col(1) << 1.0, 4.0, 7.0;  // NoH-R
  const PilotFit fit = pilot_fit(pilot, power_tests(kSix));
  constexpr int kDraws = 20'000;
  int below = 0;
  for (int i = 0; i < kDraws; ++i) {
    double pc = 0.0, e = 0.0;
    for (int d = 0; d < pilot.df_pc; ++d) pc += std::pow(random.normal(), 2);
    for (int d = 0; d < pilot.df_e; ++d) e += std::pow(random.normal(), 2);
    below += pc / pilot.df_pc < 0.5 * e / pilot.df_e;
  }
  const double share = static_cast<double>(below) / kDraws;
  EXPECT_NEAR(fit.p_below, share, 3.0 * std::sqrt(share * (1.0 - share) / kDraws));
  EXPECT_FALSE(fit.is_too_low());
  for (const PilotPair& pair : fit.pairs) {
    const bool is_in_noh = pair.pair == "R - NoR in NoH";
    // Of 1, 4, 7; the level NoH has half of each.
    const double expected = is_in_noh ? 3.0 : pair.pair.find("- NoH") < 5 ? 1.5 : 0.0;
    EXPECT_NEAR(pair.observed, expected, 1e-12) << pair.pair;
    EXPECT_NEAR(pair.model, pair.pair[0] == 'R' ? std::sqrt(0.5) : 0.5, 1e-12) << pair.pair;
  }
}

}  // namespace
}  // namespace palpate::test
