#include "engine/analysis/paper_findings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/analysis/intervals.h"
#include "engine/analysis/statistics_text.h"
#include "engine/analysis/trial_means.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

const FactorSet kHapticEffect = {kHapticFactor};
const FactorSet kRotationEffect = {kRotationFactor};
const FactorSet kObjectEffect = {kObjectFactor};
const FactorSet kTrialEffect = {kTrialFactor};
const FactorSet kRotationHapticEffect = {kHapticFactor, kRotationFactor};
const FactorSet kObjectHapticEffect = {kHapticFactor, kObjectFactor};
const FactorSet kObjectRotationEffect = {kRotationFactor, kObjectFactor};

constexpr int kPaperErrorDf = 648;

// What is claimed of an effect.
enum class Claim {
  kOrder,        // significant, with means in this order
  kEffect,       // significant; the paper's text does not state the means
  kNoEffect,     // not significant
  kMultivariate  // significant in the MANOVA
};

struct ClaimedFinding {
  Outcome outcome;  // not of kMultivariate
  FactorSet term;
  Claim claim;
  std::vector<std::string_view> ascending;  // levels, of kOrder
  std::string_view statement;
};

const std::vector<ClaimedFinding>& claims() {
  using enum Outcome;
  using Levels = std::vector<std::string_view>;
  static const std::vector<ClaimedFinding> all = {
      {kTime, kHapticEffect, Claim::kOrder, Levels{"H", "UaH", "NoH"},
       "H is quickest, then UaH, then NoH"},
      {kTime, kRotationEffect, Claim::kOrder, Levels{"NoR", "R"}, "rotation takes longer"},
      {kTime, kRotationHapticEffect, Claim::kNoEffect, {}, "no interaction"},
      {kLosses, kHapticEffect, Claim::kOrder, Levels{"H", "UaH", "NoH"},
       "H loses contact least often, then UaH, then NoH"},
      {kLosses, kRotationEffect, Claim::kOrder, Levels{"NoR", "R"},
       "with rotation, contact is lost more often"},
      {kLosses, kRotationHapticEffect, Claim::kNoEffect, {}, "no interaction"},
      {kPenetration, kHapticEffect, Claim::kOrder, Levels{"H", "UaH", "NoH"},
       "H is least deep, then UaH, then NoH"},
      {kPenetration, kRotationEffect, Claim::kNoEffect, {}, "rotation makes no difference"},
      {kPenetration,
       kRotationHapticEffect,
       Claim::kEffect,
       {},
       "the effect of rotation depends on the force"},
      {kContactAngle, kRotationEffect, Claim::kOrder, Levels{"R", "NoR"},
       "in UaH, rotation makes the angle smaller"},
      {kTime, kHapticEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kRotationEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kObjectEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kTrialEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kRotationHapticEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kObjectHapticEffect, Claim::kMultivariate, {}, "an effect"},
      {kTime, kObjectRotationEffect, Claim::kMultivariate, {}, "an effect"}};
  return all;
}

// "H 25, UaH 27.5, NoH 29 s"
std::string printed_means(const ClaimedFinding& finding) {
  std::string text;
  for (const std::string_view level : finding.ascending) {
    const PaperMean* mean = paper_mean(finding.outcome, level);
    text += (text.empty() ? "; " : ", ") + std::string(level) + " " + as_printed(mean->mean);
  }
  const std::string_view unit = outcome_text(finding.outcome).unit;
  return text.empty() || unit.empty() ? text : text + " " + std::string(unit);
}

std::string printed_text(const ClaimedFinding& finding) {
  if (finding.claim == Claim::kMultivariate) {
    for (const PaperLambda& row : paper_manova()) {
      if (row.term != finding.term) continue;
      return "lambda = " + with_decimals(row.lambda, 3) + ", F = " + with_decimals(row.f, 3);
    }
    return "";
  }
  const PaperF* f = paper_f(finding.outcome, finding.term);
  const bool is_angle = finding.outcome == Outcome::kContactAngle;
  const int df1 = finding.term == kRotationEffect ? 1 : 2;
  std::string text = "F(" + std::to_string(df1) + ", " +
                     std::to_string(is_angle ? 9 : kPaperErrorDf) +
                     ") = " + with_decimals(f->f, is_angle ? 2 : 3);
  if (!f->p.empty()) text += ", " + std::string(f->p);
  return text + printed_means(finding);
}

// The test of an effect, and the means at the levels of a claimed order.
struct Evidence {
  double f, df1, df2, p;
  std::vector<double> means;  // empty: the trials do not have all levels
};

// The place of a level in the table; -1: not there.
int level_place(const TrialTable& table, ExperimentFactor factor, std::string_view level) {
  const auto& levels = table.levels(factor);
  const auto found = std::find(levels.begin(), levels.end(), level);
  return found == levels.end() ? -1 : static_cast<int>(found - levels.begin());
}

// Calls mean_at(haptic, rotation) for the levels of an order.
template <typename MeanAt>
std::vector<double> ordered_means(const TrialTable& table, const ClaimedFinding& finding,
                                  MeanAt mean_at) {
  std::vector<double> means;
  const bool is_haptic = finding.term == kHapticEffect;
  for (const std::string_view level : finding.ascending) {
    const int place = level_place(table, is_haptic ? kHapticFactor : kRotationFactor, level);
    if (place < 0) return {};
    means.push_back(is_haptic ? mean_at(place, -1) : mean_at(-1, place));
  }
  return means;
}

// The paper's effects of Haptic are about all three levels.
bool has_levels(const TrialTable& table, const ClaimedFinding& finding) {
  const bool is_of_haptic =
      std::find(finding.term.begin(), finding.term.end(), kHapticFactor) != finding.term.end();
  return !is_of_haptic || table.level_count(kHapticFactor) == static_cast<int>(kHapticNames.size());
}

std::optional<Evidence> primary_evidence(const TrialTable& table, const PrimaryAnalysis* analysis,
                                         const ClaimedFinding& finding) {
  if (!has_levels(table, finding)) return std::nullopt;
  const PrimaryEffect* effect = analysis ? analysis->effect(finding.term) : nullptr;
  if (!effect || !effect->test) return std::nullopt;
  const auto mean_at = [&](int haptic, int rotation) {
    const PrimaryMean* mean = analysis->mean(haptic, rotation);
    return mean ? mean->mean : std::nan("");
  };
  const RepeatedEffect& test = *effect->test;
  return Evidence{test.f, test.df1, test.df2, test.p_gg, ordered_means(table, finding, mean_at)};
}

std::optional<Evidence> paper_evidence(const TrialTable& table,
                                       const std::optional<PaperAnalysis>& analysis,
                                       const ClaimedFinding& finding) {
  if (!analysis || !has_levels(table, finding)) return std::nullopt;
  const auto term = std::find(analysis->terms.begin(), analysis->terms.end(), finding.term);
  if (term == analysis->terms.end()) return std::nullopt;
  const auto place = static_cast<std::size_t>(term - analysis->terms.begin());
  if (finding.claim == Claim::kMultivariate) {
    const WilksTest& test = analysis->manova[place];
    return Evidence{test.f, test.df1, test.df2, test.p, {}};
  }
  for (const PaperAnova& anova : analysis->anovas) {
    if (anova.outcome != finding.outcome) continue;
    const FixedEffectTest& test = anova.effects[place];
    const auto mean_at = [&](int haptic, int rotation) {
      return trial_mean(table, finding.outcome, {haptic, rotation, -1}).mean;
    };
    return Evidence{test.f, test.df1, test.df2, test.p, ordered_means(table, finding, mean_at)};
  }
  return std::nullopt;
}

Verdict verdict_of(const ClaimedFinding& finding, const std::optional<Evidence>& evidence) {
  if (!evidence || std::isnan(evidence->p)) return Verdict::kNotTestable;
  const bool is_significant = evidence->p < kSignificance;
  const auto agrees = [](bool yes) { return yes ? Verdict::kAgrees : Verdict::kDisagrees; };
  if (finding.claim == Claim::kNoEffect) return agrees(!is_significant);
  if (finding.claim != Claim::kOrder) return agrees(is_significant);
  if (evidence->means.empty()) return Verdict::kNotTestable;
  const auto falls = std::adjacent_find(evidence->means.begin(), evidence->means.end(),
                                        [](double a, double b) { return !(a < b); });
  return agrees(is_significant && falls == evidence->means.end());
}

// "H 27.1 < UaH 27.3 < NoH 29.1 s", in the order of the trials.
std::string found_order(const ClaimedFinding& finding, const Evidence& evidence) {
  std::vector<std::pair<double, std::string_view>> means;
  for (std::size_t i = 0; i < evidence.means.size(); ++i) {
    means.emplace_back(evidence.means[i], finding.ascending[i]);
  }
  std::stable_sort(means.begin(), means.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (const auto& [mean, level] : means) {
    text += (text.empty() ? "; " : " < ") + std::string(level) + " " + number_or_dash(mean);
  }
  const std::string_view unit = outcome_text(finding.outcome).unit;
  return text.empty() || unit.empty() ? text : text + " " + std::string(unit);
}

std::string reason(const ClaimedFinding& finding, const std::optional<Evidence>& evidence) {
  if (!evidence) {
    return "the trials do not have all levels of the effect, too few participants are complete, or "
           "the effect is equal in all participants";
  }
  std::string text = f_text(evidence->f, evidence->df1, evidence->df2) + ", " + p_text(evidence->p);
  return finding.claim == Claim::kOrder ? text + found_order(finding, *evidence) : text;
}

}  // namespace

std::span<const PaperLambda> paper_manova() {
  static const std::vector<PaperLambda> rows = {
      {kHapticEffect, 0.236, 228.207, 1292.0},        {kRotationEffect, 0.925, 17.486, 646.0},
      {kObjectEffect, 0.110, 257.433, 1572.3},        {kTrialEffect, 0.925, 8.590, 1292.0},
      {kRotationHapticEffect, 0.911, 10.271, 1292.0}, {kObjectHapticEffect, 0.868, 5.227, 1827.6},
      {kObjectRotationEffect, 0.934, 4.964, 1572.3}};
  return rows;
}

std::span<const PaperF> paper_fs() {
  using enum Outcome;
  static const std::vector<PaperF> rows = {{kTime, kHapticEffect, 12.141, ""},
                                           {kTime, kRotationEffect, 29.674, ""},
                                           {kTime, kRotationHapticEffect, 0.433, "n.s."},
                                           {kLosses, kHapticEffect, 19.139, ""},
                                           {kLosses, kRotationEffect, 22.389, ""},
                                           {kLosses, kRotationHapticEffect, 2.608, "p < .07"},
                                           {kPenetration, kHapticEffect, 836.377, ""},
                                           {kPenetration, kRotationEffect, 0.845, "n.s."},
                                           {kPenetration, kRotationHapticEffect, 22.859, ""},
                                           {kContactAngle, kRotationEffect, 162.31, ""}};
  return rows;
}

const PaperF* paper_f(Outcome outcome, const FactorSet& term) {
  for (const PaperF& row : paper_fs()) {
    if (row.outcome == outcome && row.term == term) return &row;
  }
  return nullptr;
}

std::span<const PaperMean> paper_means() {
  using enum Outcome;
  static const std::vector<PaperMean> rows = {{kTime, "NoH", 29.0, 15.0},
                                              {kTime, "UaH", 27.5, 15.0},
                                              {kTime, "H", 25.0, 13.0},
                                              {kTime, "NoR", 25.14, 12.041},
                                              {kTime, "R", 29.15, 15.972},
                                              {kLosses, "NoH", 24.0, 11.0},
                                              {kLosses, "UaH", 22.0, 11.0},
                                              {kLosses, "H", 21.0, 10.0},
                                              {kLosses, "NoR", 22.0, 10.0},
                                              {kLosses, "R", 23.0, 12.0},
                                              {kPenetration, "NoH", 0.101, 0.031},
                                              {kPenetration, "UaH", 0.068, 0.023},
                                              {kPenetration, "H", 0.031, 0.008},
                                              {kPenetration, "NoR", 0.067, 0.035},
                                              {kPenetration, "R", 0.066, 0.038},
                                              {kContactAngle, "NoR", 49.4, 3.0},
                                              {kContactAngle, "R", 32.1, 5.0}};
  return rows;
}

const PaperMean* paper_mean(Outcome outcome, std::string_view level) {
  for (const PaperMean& row : paper_means()) {
    if (row.outcome == outcome && row.level == level) return &row;
  }
  return nullptr;
}

std::span<const PaperFinding> paper_findings() {
  static const std::vector<PaperFinding> all = [] {
    std::vector<PaperFinding> findings;
    for (const ClaimedFinding& claim : claims()) {
      const std::string of = claim.claim == Claim::kMultivariate
                                 ? "MANOVA"
                                 : std::string(outcome_text(claim.outcome).name);
      findings.push_back(
          {of + ", " + effect_name(claim.term), std::string(claim.statement), printed_text(claim)});
    }
    return findings;
  }();
  return all;
}

std::vector<PaperRanking> paper_rankings() {
  std::vector<PaperRanking> rankings;
  for (const ClaimedFinding& claim : claims()) {
    if (claim.claim != Claim::kOrder) continue;
    rankings.push_back({claim.outcome, claim.term, claim.ascending, claim.statement});
  }
  return rankings;
}

std::vector<FindingResult> judge_findings(const TrialTable& table,
                                          const std::optional<PaperAnalysis>& paper,
                                          const std::vector<PrimaryAnalysis>& primary,
                                          const std::optional<PrimaryAnalysis>& angle) {
  std::vector<FindingResult> results;
  for (const ClaimedFinding& finding : claims()) {
    const auto as_paper = paper_evidence(table, paper, finding);
    std::optional<Evidence> decisive = as_paper;
    if (finding.claim != Claim::kMultivariate) {
      const auto found = std::find_if(
          primary.begin(), primary.end(),
          [&](const PrimaryAnalysis& analysis) { return analysis.outcome == finding.outcome; });
      const PrimaryAnalysis* analysis = found == primary.end() ? nullptr : &*found;
      if (finding.outcome == Outcome::kContactAngle) analysis = angle ? &*angle : nullptr;
      decisive = primary_evidence(table, analysis, finding);
    }
    FindingResult result{verdict_of(finding, decisive), reason(finding, decisive), std::nullopt};
    if (finding.outcome != Outcome::kContactAngle) result.as_paper = verdict_of(finding, as_paper);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace palpate
