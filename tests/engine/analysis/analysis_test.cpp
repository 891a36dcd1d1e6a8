// The analysis of trials: its tests by their definitions, missing trials, and refusals.

#include "engine/analysis/analysis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/engine/analysis/sample_trials.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

constexpr double kLimit_s = 120.0;
const FactorSet kHaptic = {kHapticFactor}, kRotation = {kRotationFactor};

OperatorAnalysis analysed(std::vector<TrialRow> rows) {
  auto analysis = analyse_trials(std::move(rows), kLimit_s);
  EXPECT_TRUE(analysis.ok()) << analysis.error().to_string();
  return std::move(analysis->operators.at(0));
}

std::string refusal(std::vector<TrialRow> rows) {
  const auto analysis = analyse_trials(std::move(rows), kLimit_s);
  return analysis.ok() ? "" : analysis.error().to_string();
}

std::size_t term_place(const PaperAnalysis& paper, const FactorSet& term) {
  return static_cast<std::size_t>(std::find(paper.terms.begin(), paper.terms.end(), term) -
                                  paper.terms.begin());
}

// The sum of squares between groups of rows, about the mean of all.
double between_ss(const std::vector<TrialRow>& rows, MeasureIndex measure,
                  const std::function<std::string(const TrialRow&)>& group) {
  std::map<std::string, std::pair<double, double>> groups;  // sum, count
  double sum = 0.0, count = 0.0;
  for (const TrialRow& row : rows) {
    if (row.block == 0) continue;
    auto& [group_sum, group_count] = groups[group(row)];
    group_sum += *row.measures[measure];
    group_count += 1.0;
    sum += *row.measures[measure];
    count += 1.0;
  }
  double ss = 0.0;
  for (const auto& [name, of_group] : groups) {
    const double mean = of_group.first / of_group.second;
    ss += of_group.second * (mean - sum / count) * (mean - sum / count);
  }
  return ss;
}

std::string cell_of(const TrialRow& row) {
  return row.haptic + row.rotation + row.object + std::to_string(row.block);
}
std::string haptic_of(const TrialRow& row) {
  return row.haptic;
}
std::string participant_of(const TrialRow& row) {
  return row.participant;
}
std::string haptic_participant_of(const TrialRow& row) {
  return row.haptic + "/" + row.participant;
}

TEST(PaperAnalysis, HasTheDegreesOfFreedomOfThePaper) {
  const OperatorAnalysis analysis = analysed(sample_trials({}));
  ASSERT_TRUE(analysis.paper);
  EXPECT_EQ(analysis.paper->trials, 720);
  EXPECT_EQ(analysis.paper->error_df, 648);
  EXPECT_EQ(analysis.paper->terms.size(), 15u);
  for (const PaperLambda& printed : paper_manova()) {
    const WilksTest& test = analysis.paper->manova[term_place(*analysis.paper, printed.term)];
    EXPECT_NEAR(test.df2, printed.df2, 0.05) << effect_name(printed.term);
  }
}

// On full data the sums of squares are those between groups of rows.
TEST(PaperAnalysis, FIsThatOfTheDefinition) {
  const auto rows = sample_trials({});
  const OperatorAnalysis analysis = analysed(rows);
  const PaperAnova& time = analysis.paper->anovas[0];
  ASSERT_EQ(time.outcome, Outcome::kTime);
  const double total = between_ss(
      rows, kTotalTime, [](const TrialRow& row) { return cell_of(row) + "/" + row.participant; });
  const double error = total - between_ss(rows, kTotalTime, cell_of);
  const double f = between_ss(rows, kTotalTime, haptic_of) / 2.0 / (error / 648.0);
  const FixedEffectTest& test = time.effects[term_place(*analysis.paper, kHaptic)];
  EXPECT_NEAR(test.f, f, 1e-9 * f);
  EXPECT_NEAR(time.mean_square_error, error / 648.0, 1e-9 * error);
  EXPECT_NEAR(
      test.partial_eta2,
      between_ss(rows, kTotalTime, haptic_of) / (between_ss(rows, kTotalTime, haptic_of) + error),
      1e-12);
}

TEST(PaperAnalysis, ComparesPairsOnlyAfterASignificantF) {
  const OperatorAnalysis with = analysed(sample_trials({}));
  const OperatorAnalysis without = analysed(sample_trials({.effects = 0.0, .seed = 5}));
  const auto has_haptic = [](const PaperAnova& anova) {
    return std::any_of(anova.comparisons.begin(), anova.comparisons.end(),
                       [](const PlsdFamily& family) { return family.factor == "Haptic"; });
  };
  for (const OperatorAnalysis* analysis : {&with, &without}) {
    for (const PaperAnova& anova : analysis->paper->anovas) {
      const double p = anova.effects[term_place(*analysis->paper, kHaptic)].p;
      EXPECT_EQ(has_haptic(anova), p < 0.05);
    }
  }
  EXPECT_TRUE(has_haptic(with.paper->anovas[2]));
  EXPECT_FALSE(has_haptic(without.paper->anovas[2]));
}

// One factor, F = SS_c / (k - 1) over SS_e / ((k - 1)(n - 1)), SS_e = SS_t - SS_c - SS_s of the
// participants' means.
TEST(PrimaryAnalysis, FIsThatOfTheDefinition) {
  const auto rows = sample_trials({});
  const OperatorAnalysis analysis = analysed(rows);
  const double effect = between_ss(rows, kTotalTime, haptic_of);
  const double error = between_ss(rows, kTotalTime, haptic_participant_of) - effect -
                       between_ss(rows, kTotalTime, participant_of);
  const double f = effect / 2.0 / (error / 18.0);
  const PrimaryEffect* found = analysis.primary_of(Outcome::kTime)->effect(kHaptic);
  ASSERT_TRUE(found && found->test);
  EXPECT_EQ(found->participants, 10);
  EXPECT_NEAR(found->test->f, f, 1e-9 * f);
  EXPECT_EQ(found->test->df2, 18.0);
}

TEST(PrimaryAnalysis, HasEffectsComparisonsAndMeans) {
  const OperatorAnalysis analysis = analysed(sample_trials({}));
  const PrimaryAnalysis& depth = *analysis.primary_of(Outcome::kPenetration);
  EXPECT_EQ(depth.effects.size(), 15u);
  ASSERT_EQ(depth.families.size(), 2u);
  EXPECT_EQ(depth.families[0].pairs.size(), 3u);
  EXPECT_EQ(depth.families[1].pairs.size(), 3u);
  EXPECT_EQ(depth.means.size(), 3u + 2u + 6u);
  EXPECT_EQ(depth.families[0].pairs[0].name, "UaH - NoH");
  EXPECT_LT(depth.families[0].pairs[0].test.difference, 0.0);
  ASSERT_TRUE(analysis.angle_of_uah);
  EXPECT_EQ(analysis.angle_of_uah->effects.size(), 7u);  // Rotation, Object, Trial
  EXPECT_EQ(analysis.angle_of_uah->means.size(), 2u);
  const PrimaryEffect* rotation = analysis.angle_of_uah->effect(kRotation);
  EXPECT_EQ(rotation->test->df1, 1.0);
  EXPECT_EQ(rotation->test->df2, 9.0);
}

// The practice block has values a hundred times as large.
TEST(Analysis, LeavesOutPractice) {
  auto rows = sample_trials({});
  const double with = analysed(rows).primary_of(Outcome::kTime)->means[0].mean;
  std::erase_if(rows, [](const TrialRow& row) { return row.block == 0; });
  EXPECT_EQ(with, analysed(rows).primary_of(Outcome::kTime)->means[0].mean);
  EXPECT_LT(with, 50.0);
}

TEST(Analysis, DoesNotDependOnTheOrderOfRows) {
  auto rows = sample_trials({.followings = {"delayed", "frozen"}, .has_timeouts = true});
  const auto first = analyse_trials(rows, kLimit_s);
  Random random(18201);
  for (std::size_t i = rows.size(); i > 1; --i) std::swap(rows[i - 1], rows[random.index(i)]);
  const auto second = analyse_trials(rows, kLimit_s);
  ASSERT_EQ(first->operators.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const OperatorAnalysis& a = first->operators[i];
    const OperatorAnalysis& b = second->operators[i];
    EXPECT_EQ(a.name(), b.name());
    for (std::size_t t = 0; t < a.paper->terms.size(); ++t) {
      EXPECT_EQ(a.paper->manova[t].f, b.paper->manova[t].f);
    }
    for (std::size_t m = 0; m < a.primary.size(); ++m) {
      for (std::size_t e = 0; e < a.primary[m].effects.size(); ++e) {
        const auto &left = a.primary[m].effects[e].test, &right = b.primary[m].effects[e].test;
        ASSERT_EQ(left.has_value(), right.has_value());
        if (left) {
          EXPECT_EQ(left->f, right->f);
        }
      }
    }
    for (std::size_t f = 0; f < a.findings.size(); ++f) {
      EXPECT_EQ(a.findings[f].because, b.findings[f].because);
    }
  }
}

TrialRow& row_at(std::vector<TrialRow>& rows, const std::string& participant, int block,
                 const std::string& haptic, const std::string& rotation,
                 const std::string& object) {
  return *std::find_if(rows.begin(), rows.end(), [&](const TrialRow& row) {
    return row.participant == participant && row.block == block && row.haptic == haptic &&
           row.rotation == rotation && row.object == object;
  });
}

TEST(MissingTrials, OneOfThreeBlocksLeavesOnlyTheEffectsWithTrial) {
  auto rows = sample_trials({});
  TrialRow& timeout = row_at(rows, "3", 2, "UaH", "R", "O2");
  timeout.status = TrialStatus::kTimeout;
  const OperatorAnalysis analysis = analysed(rows);
  EXPECT_EQ(analysis.paper->trials, 719);
  EXPECT_EQ(analysis.paper->error_df, 647);
  const PrimaryAnalysis& time = *analysis.primary_of(Outcome::kTime);
  for (const PrimaryEffect& effect : time.effects) {
    EXPECT_EQ(effect.participants, effect.term.back() == kTrialFactor ? 9 : 10);
  }
  EXPECT_EQ(time.families[1].pairs[1].test.pairs, 10);
  EXPECT_EQ(analysis.counts.done, 719);
  EXPECT_EQ(analysis.counts.timeouts, 1);
  // Once more, with the timeout as the limit.
  const PrimaryAnalysis* limited = analysis.primary_of(Outcome::kTimeToLimit);
  ASSERT_TRUE(limited);
  for (const PrimaryEffect& effect : limited->effects) EXPECT_EQ(effect.participants, 10);
  EXPECT_GT(limited->mean(-1, 1)->mean, time.mean(-1, 1)->mean);
  const auto cell =
      analysis.table.value(2, analysis.table.condition(1, 1, 1), 1, Outcome::kTimeToLimit);
  EXPECT_EQ(cell, kLimit_s);
}

// A cell is the mean of the blocks that are there, and cells count equally.
TEST(MissingTrials, CellsCountEquallyWhateverTheirBlocks) {
  auto rows = sample_trials({.participants = 2, .objects = {"O1", "O2"}});
  for (TrialRow& row : rows) row.measures[kTotalTime] = row.object == "O1" ? 10.0 : 30.0;
  rows[12].measures[kTotalTime] = 11.0;  // of NoH: the measure is not constant
  std::erase_if(rows, [](const TrialRow& row) {
    return row.participant == "1" && row.object == "O2" && row.block > 1 && row.haptic == "UaH";
  });
  const OperatorAnalysis analysis = analysed(rows);
  EXPECT_NEAR(analysis.primary_of(Outcome::kTime)->mean(1, -1)->mean, 20.0, 1e-12);
}

TEST(MissingTrials, ParticipantWithAnEmptyCellLeavesWhatNeedsIt) {
  auto rows = sample_trials({});
  for (int block = 1; block <= 3; ++block) {
    row_at(rows, "3", block, "UaH", "R", "O2").status = TrialStatus::kFault;
  }
  std::erase_if(rows, [](const TrialRow& row) {  // absent
    return row.participant == "7" && row.haptic == "H" && row.rotation == "NoR" &&
           row.object == "O4" && row.block == 3;
  });
  const OperatorAnalysis analysis = analysed(rows);
  const PrimaryAnalysis& time = *analysis.primary_of(Outcome::kTime);
  EXPECT_EQ(time.effect(kHaptic)->participants, 9);
  EXPECT_EQ(time.effect({kHapticFactor, kTrialFactor})->participants, 8);
  const auto pairs = [&](int family, int pair) {
    return time.families[family].pairs[pair].test.pairs;
  };
  EXPECT_EQ(pairs(0, 0), 9);   // UaH - NoH
  EXPECT_EQ(pairs(0, 1), 10);  // H - NoH
  EXPECT_EQ(pairs(1, 0), 10);  // R - NoR in NoH
  EXPECT_EQ(pairs(1, 1), 9);   // in UaH
  EXPECT_EQ(analysis.angle_of_uah->effect(kRotation)->participants, 9);
  EXPECT_EQ(analysis.counts.faults, 3);
  EXPECT_EQ(analysis.counts.absent, 1);
  EXPECT_EQ(analysis.counts.missing(), 4);
}

TEST(MissingTrials, EffectOfFewerThanTwoParticipantsIsNotTestable) {
  auto rows = sample_trials({.participants = 2});
  for (int block = 1; block <= 3; ++block) {
    row_at(rows, "2", block, "UaH", "R", "O2").status = TrialStatus::kTimeout;
  }
  const OperatorAnalysis analysis = analysed(rows);
  const PrimaryEffect* effect = analysis.primary_of(Outcome::kTime)->effect(kHaptic);
  EXPECT_EQ(effect->participants, 1);
  EXPECT_FALSE(effect->test);
  EXPECT_EQ(analysis.findings[0].verdict, Verdict::kNotTestable);
  EXPECT_TRUE(analysis.findings[0].as_paper);
  EXPECT_NE(*analysis.findings[0].as_paper, Verdict::kNotTestable);
}

TEST(MissingTrials, BlockWithoutATrialOfAConditionLeavesOutTrial) {
  auto rows = sample_trials({});
  std::erase_if(rows, [](const TrialRow& row) {
    return row.haptic == "H" && row.rotation == "R" && row.object == "O3" && row.block == 2;
  });
  const OperatorAnalysis analysis = analysed(rows);
  EXPECT_EQ(analysis.paper->terms.size(), 7u);
  ASSERT_EQ(analysis.notes.size(), 1u);
  EXPECT_EQ(analysis.notes[0],
            "Trial is left out, because no trial of H, R, O3 in block 2 was completed.");
}

TEST(MissingTrials, FollowingWithoutACompletedTrialOfAConditionIsReported) {
  auto rows = sample_trials({.followings = {"delayed", "frozen"}});
  for (TrialRow& row : rows) {
    if (row.following == "frozen" && row.haptic == "NoH" && row.rotation == "R" &&
        row.object == "O1") {
      row.status = TrialStatus::kTimeout;
    }
  }
  const auto analysis = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(analysis.ok());
  EXPECT_TRUE(analysis->operators[0].paper);
  EXPECT_FALSE(analysis->operators[1].paper);
  EXPECT_EQ(analysis->operators[1].paper_problem,
            "No trial of NoH, R, O1 was completed: its effects cannot be separated.");
  // Alone it is refused.
  std::erase_if(rows, [](const TrialRow& row) { return row.following == "delayed"; });
  EXPECT_EQ(refusal(rows).find("following frozen, condition NoH, R, O1: has no completed trial"),
            0u);
}

TEST(Analysis, TakesFilesOfPeople) {
  auto rows = sample_trials({.participants = 4,
                             .blocks = 1,
                             .rotation = {"NoR"},
                             .objects = {"cup", "Vase 10", "Vase 2"}});
  for (TrialRow& row : rows) {
    row.participant = "P" + row.participant;
    row.measures[kPenetrationDm].reset();  // in metres alone
    row.measures[kLossesPerSecond].reset();
    row.measures[kLosses100ms].reset();
    row.measures[kContactAngle].reset();
  }
  const auto all = analyse_trials(rows, kLimit_s);
  EXPECT_FALSE(all->has_simulated());
  const OperatorAnalysis& analysis = all->operators[0];
  EXPECT_EQ(analysis.name(), "people");
  EXPECT_EQ(analysis.table.levels(kObjectFactor),
            (std::vector<std::string>{"Vase 2", "Vase 10", "cup"}));
  EXPECT_EQ(analysis.paper->terms.size(), 3u);  // Haptic and Object
  EXPECT_EQ(analysis.paper->anovas[2].outcome, Outcome::kPenetration);
  EXPECT_NEAR(analysis.primary_of(Outcome::kPenetration)->mean(2, -1)->mean, 0.031, 0.02);
  EXPECT_TRUE(analysis.primary_of(Outcome::kLossesPerSecond));
  EXPECT_FALSE(analysis.angle_of_uah && analysis.angle_of_uah->effect(kRotation));
  const std::set<std::string> notes(analysis.notes.begin(), analysis.notes.end());
  EXPECT_TRUE(notes.contains("Rotation is left out, because the file has one level of it: NoR."));
  EXPECT_TRUE(notes.contains("Trial is left out, because the file has one level of it: 1."));
  EXPECT_TRUE(notes.contains(
      "The file does not have the column mean_contact_angle_deg, so that there is no "
      "analysis of mean contact angle."));
  EXPECT_EQ(analysis.findings[1].verdict, Verdict::kNotTestable);  // Rotation
}

TEST(Analysis, LastAttemptCounts) {
  auto rows = sample_trials({});
  TrialRow again = row_at(rows, "3", 2, "UaH", "R", "O2");
  again.attempt = 2;
  row_at(rows, "3", 2, "UaH", "R", "O2").status = TrialStatus::kFault;
  rows.push_back(again);
  const OperatorAnalysis analysis = analysed(rows);
  EXPECT_EQ(analysis.paper->trials, 720);
  EXPECT_EQ(analysis.notes.at(0),
            "Of several attempts at a trial the last one counts; rows of earlier attempts: 1.");
}

TEST(Findings, OfThePapersMeansAgree) {
  const OperatorAnalysis analysis = analysed(sample_trials({.participants = 40}));
  ASSERT_EQ(analysis.findings.size(), paper_findings().size());
  for (std::size_t i = 0; i < analysis.findings.size(); ++i) {
    // The sample plants no interactions of Object and Trial.
    if (paper_findings()[i].name.find("Object x") != std::string::npos) continue;
    EXPECT_EQ(analysis.findings[i].verdict, Verdict::kAgrees)
        << paper_findings()[i].name << ": " << analysis.findings[i].because;
  }
}

TEST(Findings, OfTheOppositeOrderDisagree) {
  const OperatorAnalysis analysis = analysed(sample_trials({.participants = 40, .effects = -1.0}));
  for (const int order : {0, 1, 3, 4, 6, 9}) {
    EXPECT_EQ(analysis.findings[order].verdict, Verdict::kDisagrees)
        << paper_findings()[order].name;
  }
}

TEST(Findings, StateTestAndMeans) {
  const OperatorAnalysis analysis = analysed(sample_trials({}));
  EXPECT_EQ(paper_findings()[0].printed, "F(2, 648) = 12.141; H 25, UaH 27.5, NoH 29 s");
  EXPECT_EQ(paper_findings()[9].printed, "F(1, 9) = 162.31; R 32.1, NoR 49.4 deg");
  EXPECT_EQ(paper_findings()[10].printed, "lambda = 0.236, F = 228.207");
  const std::string& because = analysis.findings[6].because;
  EXPECT_EQ(because.find("F(2, 18) = "), 0u) << because;
  EXPECT_NE(because.find("; H 0.0"), std::string::npos) << because;
  EXPECT_NE(because.find(" dm"), std::string::npos) << because;
}

using Change = std::function<void(std::vector<TrialRow>&)>;
struct Refused {
  const char* name;
  Change change;
  const char* message;  // its beginning
};

TEST(Refusals, NameWhatToChange) {
  const auto erase = [](auto predicate) {
    return [predicate](std::vector<TrialRow>& rows) { std::erase_if(rows, predicate); };
  };
  const auto change_all = [](auto change) {
    return [change](std::vector<TrialRow>& rows) {
      for (TrialRow& row : rows) change(row);
    };
  };
  const Refused refused[] = {
      {"no rows", [](auto& rows) { rows.clear(); },
       "rows: are 0; expected trials of two participants or more"},
      {"practice alone", erase([](const TrialRow& row) { return row.block > 0; }),
       "participant: has 0 levels beside practice; expected two participants or more"},
      {"one participant", erase([](const TrialRow& row) { return row.participant != "4"; }),
       "participant: has 1 level beside practice; expected two participants or more"},
      {"unknown force", [](auto& rows) { rows[30].haptic = "h"; },
       "haptic: is \"h\"; expected one of NoH, UaH, H"},
      {"unknown rotation", [](auto& rows) { rows[30].rotation = ""; },
       "rotation: is \"\"; expected one of NoR, R"},
      {"unknown following", [](auto& rows) { rows[30].following = "Delayed"; },
       "following: is \"Delayed\"; expected one of delayed, predict, replan, frozen, adapts-0, "
       "adapts-0.5, adapts-1, or nothing "
       "for "
       "people"},
      {"a column of numbers taken for objects",
       [](auto& rows) {
         for (std::size_t i = 0; i < rows.size(); ++i) rows[i].object = std::to_string(i);
       },
       "object and block: have "},
      {"doubled row", [](auto& rows) { rows.push_back(rows[30]); },
       "participant 1, block 1, NoH, R, O3: is there twice; expected one row"},
      {"not a number", [](auto& rows) { rows[30].measures[kContactAngle] = std::nan(""); },
       "participant 1, block 1, NoH, R, O3, mean_contact_angle_deg: is not finite; expected a "
       "number"},
      {"no value", [](auto& rows) { rows[30].measures[kLosses].reset(); },
       "participant 1, block 1, NoH, R, O3, losses_of_contact: is empty; expected a number"},
      {"no column", change_all([](TrialRow& row) { row.measures[kTotalTime].reset(); }),
       "total_time_s: is in no completed trial"},
      {"no penetration", change_all([](TrialRow& row) {
         row.measures[kPenetration].reset();
         row.measures[kPenetrationDm].reset();
       }),
       "mean_penetration_dm: is in no completed trial"},
      {"condition without a row", erase([](const TrialRow& row) {
         return row.haptic == "UaH" && row.rotation == "R" && row.object == "O2";
       }),
       "condition UaH, R, O2: has no trial"},
      {"condition without a completed trial", change_all([](TrialRow& row) {
         if (row.haptic == "UaH" && row.rotation == "R" && row.object == "O2")
           row.status = TrialStatus::kTimeout;
       }),
       "condition UaH, R, O2: has no completed trial"},
      {"constant measure", change_all([](TrialRow& row) { row.measures[kLosses] = 7.0; }),
       "losses_of_contact: is constant within the conditions"},
      {"measure that follows from another", change_all([](TrialRow& row) {
         row.measures[kPenetrationDm] = 0.001 * *row.measures[kLosses] + 0.1;
       }),
       "mean_penetration_dm: is constant within the conditions, or follows from the measures "
       "before "
       "it"},
      {"constant angle", change_all([](TrialRow& row) { row.measures[kContactAngle] = 45.0; }),
       "mean_contact_angle_deg: is 45 in every trial; expected a measure that varies"},
  };
  for (const Refused& each : refused) {
    auto rows = sample_trials({});
    each.change(rows);
    EXPECT_EQ(refusal(rows).find(each.message), 0u) << each.name << ": " << refusal(rows);
  }
}

}  // namespace
}  // namespace palpate::test
