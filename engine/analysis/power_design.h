#pragma once

// The conditions of an experiment whose power is computed, and the tests that its primary analysis
// (primary_analysis.h) makes.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "engine/analysis/trial_table.h"

namespace palpate {

// Every combination of a level of Haptic and a level of Rotation; Rotation varies fastest.
struct PowerDesign {
  std::vector<std::string> haptic;    // of kHapticNames, in their order; at least one
  std::vector<std::string> rotation;  // of kRotationNames, in their order; at least one

  std::size_t conditions() const { return haptic.size() * rotation.size(); }
  // "UaH-R"
  std::string condition_name(std::size_t condition) const;
};

// The conditions in which the paper's experiment and the primary analysis test an outcome: all six;
// for the contact angle, the two of UaH.
PowerDesign power_design_of(Outcome outcome);

enum class PowerCorrection : std::uint8_t { kNone, kGreenhouseGeisser, kHolm };
inline constexpr std::array<std::string_view, 3> kPowerCorrectionNames = {
    "uncorrected", "Greenhouse-Geisser", "Holm"};

// A test of an effect, or of a pair of means. scores: the columns of PowerTests::weights.
struct PowerTest {
  std::string name;    // "Haptic"; "H - UaH"
  std::string family;  // of pairs, for which Holm's correction is made; empty: an effect
  PowerCorrection correction = PowerCorrection::kNone;
  std::size_t first_score = 0;
  std::size_t scores = 1;  // the degrees of freedom of the effect
};

// The tests of a design, in the order of the primary analysis: the effects, each uncorrected and,
// with more than one degree of freedom, by Greenhouse and Geisser; then the pairs by Holm, the
// pairs of a family side by side. An effect of one degree of freedom has no correction.
//
// weights: one row per condition, one column per score. A score is a contrast of the conditions of
// one participant: first the orthonormal contrasts of each effect, then the difference of each
// pair.
struct PowerTests {
  std::vector<PowerTest> tests;
  Eigen::MatrixXd weights;

  // Whether these means of the conditions make the hypothesis of a test true: the mean of each of
  // its scores is 0 to within rounding.
  bool is_null(const PowerTest& test, const std::vector<double>& means) const;
};
PowerTests power_tests(const PowerDesign& design);

}  // namespace palpate
