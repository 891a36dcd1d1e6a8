#pragma once

// The findings of the paper (Lecuyer et al., 2005), and the test of whether trials agree with them.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/paper_analysis.h"
#include "engine/analysis/primary_analysis.h"
#include "engine/analysis/trial_table.h"

namespace palpate {

// A line of the paper's MANOVA. lambda is printed with three digits.
struct PaperLambda {
  FactorSet term;
  double lambda, f, df2;
};
std::span<const PaperLambda> paper_manova();

// An F of the paper's ANOVAs (648 error degrees of freedom), or of its test of the contact angle
// (9).
struct PaperF {
  Outcome outcome;
  FactorSet term;
  double f;
  std::string_view p;  // as the paper states it; empty: it states only "significant"
};
std::span<const PaperF> paper_fs();
const PaperF* paper_f(Outcome outcome, const FactorSet& term);

// A mean of the paper at a level, with its standard deviation. Contact angles are those of UaH.
struct PaperMean {
  Outcome outcome;
  std::string_view level;
  double mean, sd;
};
std::span<const PaperMean> paper_means();
const PaperMean* paper_mean(Outcome outcome, std::string_view level);

enum class Verdict : std::uint8_t { kAgrees, kDisagrees, kNotTestable };
inline constexpr std::array<std::string_view, 3> kVerdictNames = {"agrees", "disagrees",
                                                                  "not testable"};

// A finding of the paper. The statement is about people.
struct PaperFinding {
  std::string name;       // "total time, Haptic"
  std::string statement;  // "H is quickest and NoH slowest"
  std::string printed;    // "F(2, 648) = 12.141; H 25, UaH 27.5, NoH 29 s"
};

// The findings that state an order of means: these levels of Haptic or Rotation, by ascending mean.
// That of the contact angle is about UaH alone; the others are about all conditions.
struct PaperRanking {
  Outcome outcome;
  FactorSet term;  // Haptic or Rotation
  std::vector<std::string_view> ascending;
  std::string_view statement;
};
std::vector<PaperRanking> paper_rankings();

// Whether trials agree with a finding. If the paper found an effect, trials agree if the effect is
// significant at 5 % and the means have the paper's order. If the paper found no effect, trials
// agree if the effect is not significant. The primary analysis decides. It has no MANOVA; for the
// MANOVA, PaperAnalysis decides.
struct FindingResult {
  Verdict verdict = Verdict::kNotTestable;
  std::string because;              // "F(2, 18) = 14.2, p = 0.001; H 27.1 < UaH 27.3 < NoH 29.1 s"
  std::optional<Verdict> as_paper;  // by the analysis as the paper did it
};

// All findings. judge_findings() returns the results in the order of the findings. paper: no value
// if that analysis is not possible. primary: the analyses of all levels of Haptic. angle: the
// analysis of the contact angle of UaH alone; no value if the trials do not have it.
std::span<const PaperFinding> paper_findings();
std::vector<FindingResult> judge_findings(const TrialTable& table,
                                          const std::optional<PaperAnalysis>& paper,
                                          const std::vector<PrimaryAnalysis>& primary,
                                          const std::optional<PrimaryAnalysis>& angle);

}  // namespace palpate
