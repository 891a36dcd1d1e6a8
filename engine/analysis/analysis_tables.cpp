#include "engine/analysis/analysis_tables.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Row = std::vector<ResultCell>;

ResultCell text_cell(std::string_view value) {
  return std::string(value);
}
ResultCell verdict_cell(Verdict verdict) {
  return text_cell(kVerdictNames[static_cast<std::size_t>(verdict)]);
}

// Effects

const std::vector<std::string> kEffectColumns = {"following",
                                                 "analysis",
                                                 "outcome",
                                                 "effect",
                                                 "wilks_lambda",
                                                 "f",
                                                 "df1",
                                                 "df2",
                                                 "p",
                                                 "gg_epsilon",
                                                 "gg_p",
                                                 "partial_eta2",
                                                 "generalized_eta2",
                                                 "trials",
                                                 "participants",
                                                 "paper_lambda",
                                                 "paper_f",
                                                 "paper_p"};

Row effect_row(const OperatorAnalysis& analysis, std::string_view kind, std::string_view outcome,
               const FactorSet& term) {
  Row row(kEffectColumns.size());
  row[0] = analysis.following();
  row[1] = text_cell(kind);
  row[2] = text_cell(outcome);
  row[3] = effect_name(term);
  return row;
}

void put_paper_f(Row& row, const PaperF* paper) {
  if (!paper) return;
  row[16] = paper->f;
  if (!paper->p.empty()) row[17] = text_cell(paper->p);
}

void put_manova(const OperatorAnalysis& analysis, ResultTable& table) {
  const PaperAnalysis& paper = *analysis.paper;
  for (std::size_t i = 0; i < paper.terms.size(); ++i) {
    const WilksTest& test = paper.manova[i];
    Row row = effect_row(analysis, "manova", "total time, losses of contact, mean penetration",
                         paper.terms[i]);
    row[4] = test.lambda;
    row[5] = test.f;
    row[6] = test.df1;
    row[7] = test.df2;
    row[8] = test.p;
    row[13] = paper.trials;
    if (const PaperLambda* printed = paper_lambda(paper.terms[i])) {
      row[15] = printed->lambda;
      row[16] = printed->f;
    }
    table.rows.push_back(std::move(row));
  }
}

void put_anova(const OperatorAnalysis& analysis, const PaperAnova& anova, ResultTable& table) {
  for (std::size_t i = 0; i < anova.effects.size(); ++i) {
    const FixedEffectTest& test = anova.effects[i];
    const FactorSet& term = analysis.paper->terms[i];
    Row row = effect_row(analysis, "anova", outcome_text(anova.outcome).name, term);
    row[5] = test.f;
    row[6] = test.df1;
    row[7] = test.df2;
    row[8] = test.p;
    row[11] = test.partial_eta2;
    row[13] = analysis.paper->trials;
    put_paper_f(row, paper_f(anova.outcome, term));
    table.rows.push_back(std::move(row));
  }
}

// "repeated measures"; "repeated measures, UaH"
std::string primary_kind(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary) {
  if (!primary.only_haptic) return "repeated measures";
  return "repeated measures, " + analysis.table.levels(kHapticFactor)[*primary.only_haptic];
}

void put_primary(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary,
                 ResultTable& table) {
  for (const PrimaryEffect& effect : primary.effects) {
    Row row = effect_row(analysis, primary_kind(analysis, primary),
                         outcome_text(primary.outcome).name, effect.term);
    row[14] = effect.participants;
    if (effect.test) {
      const RepeatedEffect& test = *effect.test;
      row[5] = test.f;
      row[6] = test.df1;
      row[7] = test.df2;
      row[8] = test.p;
      row[9] = test.epsilon;
      row[10] = test.p_gg;
      row[12] = test.generalized_eta2;
    }
    const bool is_of_paper =
        primary.outcome != Outcome::kContactAngle || primary.only_haptic.has_value();
    if (is_of_paper) put_paper_f(row, paper_f(primary.outcome, effect.term));
    table.rows.push_back(std::move(row));
  }
}

void put_effects(const OperatorAnalysis& analysis, ResultTable& table) {
  if (analysis.paper) {
    put_manova(analysis, table);
    for (const PaperAnova& anova : analysis.paper->anovas) put_anova(analysis, anova, table);
  }
  for (const PrimaryAnalysis& primary : analysis.primary) put_primary(analysis, primary, table);
  if (analysis.angle_of_uah) put_primary(analysis, *analysis.angle_of_uah, table);
}

// Comparisons

const std::vector<std::string> kComparisonColumns = {"following",
                                                     "analysis",
                                                     "outcome",
                                                     "unit",
                                                     "family",
                                                     "pair",
                                                     "difference",
                                                     "half_width_95",
                                                     "t",
                                                     "df",
                                                     "p",
                                                     "p_holm",
                                                     "least_significant_difference",
                                                     "participants"};

void put_plsd(const OperatorAnalysis& analysis, ResultTable& table) {
  for (const PaperAnova& anova : analysis.paper->anovas) {
    const OutcomeText& outcome = outcome_text(anova.outcome);
    for (const PlsdFamily& family : anova.comparisons) {
      for (const PlsdPair& pair : family.pairs) {
        table.rows.push_back({analysis.following(),
                              text_cell("plsd"),
                              text_cell(outcome.name),
                              text_cell(outcome.unit),
                              family.factor,
                              family.levels[pair.first] + " - " + family.levels[pair.second],
                              pair.difference,
                              {},
                              pair.t,
                              static_cast<double>(analysis.paper->error_df),
                              pair.p,
                              {},
                              pair.least_significant,
                              {}});
      }
    }
  }
}

void put_paired(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary,
                ResultTable& table) {
  const OutcomeText& outcome = outcome_text(primary.outcome);
  for (const PrimaryFamily& family : primary.families) {
    for (const PrimaryPair& pair : family.pairs) {
      table.rows.push_back({analysis.following(),
                            text_cell(primary.only_haptic ? "paired t, UaH" : "paired t"),
                            text_cell(outcome.name),
                            text_cell(outcome.unit),
                            family.name,
                            pair.name,
                            pair.test.difference,
                            pair.test.half_width,
                            pair.test.t,
                            pair.test.df,
                            pair.test.p,
                            pair.p_holm,
                            {},
                            pair.test.pairs});
    }
  }
}

// Means

const std::vector<std::string> kMeanColumns = {
    "following", "of",   "outcome", "unit",          "haptic",     "rotation", "object",
    "n",         "mean", "sd",      "half_width_95", "paper_mean", "paper_sd"};

Row mean_row(const OperatorAnalysis& analysis, std::string_view of, Outcome outcome,
             const TrialLevels& at) {
  const auto level = [&](int place, ExperimentFactor factor) -> ResultCell {
    return place < 0 ? text_cell("all") : text_cell(analysis.table.levels(factor)[place]);
  };
  Row row = {analysis.following(),
             text_cell(of),
             text_cell(outcome_text(outcome).name),
             text_cell(outcome_text(outcome).unit),
             level(at.haptic, kHapticFactor),
             level(at.rotation, kRotationFactor),
             level(at.object, kObjectFactor),
             {},
             {},
             {},
             {},
             {},
             {}};
  if (const PaperMean* paper = paper_mean_at(analysis.table, outcome, at)) {
    row[11] = paper->mean;
    row[12] = paper->sd;
  }
  return row;
}

void put_participant_means(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary,
                           ResultTable& table) {
  for (const PrimaryMean& mean : primary.means) {
    const TrialLevels at = {primary.only_haptic.value_or(mean.haptic), mean.rotation, -1};
    // The analysis of UaH alone can have more participants.
    Row row = mean_row(analysis, primary.only_haptic ? "participants, UaH" : "participants",
                       primary.outcome, at);
    row[7] = mean.participants;
    row[8] = mean.mean;
    row[10] = mean.half_width;
    table.rows.push_back(std::move(row));
  }
}

void put_mean_rows(const OperatorAnalysis& analysis, ResultTable& table) {
  for (const Outcome outcome : reported_outcomes(analysis)) {
    for (const TrialLevels& at : levels_of_means(analysis.table)) {
      const TrialMean mean = trial_mean(analysis.table, outcome, at);
      Row row = mean_row(analysis, "trials", outcome, at);
      row[7] = mean.trials;
      row[8] = mean.mean;
      row[9] = mean.sd;
      table.rows.push_back(std::move(row));
    }
  }
  for (const PrimaryAnalysis& primary : analysis.primary) {
    put_participant_means(analysis, primary, table);
  }
  if (analysis.angle_of_uah) put_participant_means(analysis, *analysis.angle_of_uah, table);
}

// Missing trials

const std::vector<std::string> kMissingColumns = {
    "following",         "haptic", "rotation", "object",        "done",
    "timeouts",          "faults", "absent",   "timeout_share", "timeout_share_low",
    "timeout_share_high"};

Row missing_row(const OperatorAnalysis& analysis, const TrialCounts& counts) {
  const auto level = [&](int place, ExperimentFactor factor) -> ResultCell {
    return place < 0 ? text_cell("all") : text_cell(analysis.table.levels(factor)[place]);
  };
  const int held = counts.done + counts.timeouts + counts.faults;
  ResultCell share;
  if (held > 0) share = static_cast<double>(counts.timeouts) / held;
  return {analysis.following(),
          level(counts.at.haptic, kHapticFactor),
          level(counts.at.rotation, kRotationFactor),
          level(counts.at.object, kObjectFactor),
          counts.done,
          counts.timeouts,
          counts.faults,
          counts.absent,
          share,
          counts.timeout_share.low,
          counts.timeout_share.high};
}

// Findings

const std::vector<std::string> kFindingColumns = {"following",
                                                  "finding",
                                                  "paper_statement",
                                                  "paper_figures",
                                                  "verdict",
                                                  "because",
                                                  "verdict_of_the_papers_analysis",
                                                  "differs_between_followings"};

void put_findings(const ExperimentAnalysis& all, const OperatorAnalysis& analysis,
                  ResultTable& table) {
  for (std::size_t i = 0; i < analysis.findings.size(); ++i) {
    const PaperFinding& finding = paper_findings()[i];
    const FindingResult& result = analysis.findings[i];
    Row row = {analysis.following(),
               finding.name,
               finding.statement,
               finding.printed,
               verdict_cell(result.verdict),
               result.because,
               {},
               verdicts_differ(all, i) ? 1 : 0};
    if (result.as_paper) row[6] = verdict_cell(*result.as_paper);
    table.rows.push_back(std::move(row));
  }
}

// Differences between variants

const std::vector<std::string> kDifferenceColumns = {"following",
                                                     "view",
                                                     "align",
                                                     "start_orientation_deg",
                                                     "scale",
                                                     "other_following",
                                                     "other_view",
                                                     "other_align",
                                                     "other_start_orientation_deg",
                                                     "other_scale",
                                                     "outcome",
                                                     "unit",
                                                     "haptic",
                                                     "rotation",
                                                     "difference",
                                                     "half_width_95",
                                                     "t",
                                                     "df",
                                                     "p",
                                                     "participants"};

void put_whose(const OperatorAnalysis& analysis, Row& row) {
  const TrialVariant& variant = analysis.table.variant();
  row.insert(row.end(), {text_cell(variant.view), text_cell(variant.align),
                         variant.start_orientation_deg, variant.scale});
}

void put_differences(const ExperimentAnalysis& analysis, ResultTable& table) {
  for (const VariantDifference& difference : analysis.differences) {
    Row row;
    for (const std::size_t i : {difference.second, difference.first}) {
      row.push_back(analysis.operators[i].following());
      put_whose(analysis.operators[i], row);
    }
    const OutcomeText& outcome = outcome_text(difference.outcome);
    const PairedT& test = difference.test;
    row.insert(row.end(), {text_cell(outcome.name), text_cell(outcome.unit), difference.haptic,
                           difference.rotation, test.difference, test.half_width, test.t, test.df,
                           test.p, test.pairs});
    table.rows.push_back(std::move(row));
  }
}

nlohmann::ordered_json operator_json(const OperatorAnalysis& analysis) {
  const TrialTable& table = analysis.table;
  nlohmann::ordered_json json = {{"following", analysis.following()},
                                 {"view", table.variant().view},
                                 {"align", table.variant().align},
                                 {"start_orientation_deg", table.variant().start_orientation_deg},
                                 {"scale", table.variant().scale},
                                 {"simulated", analysis.is_simulated()},
                                 {"participants", table.participants()}};
  for (const ExperimentFactor f : {kHapticFactor, kRotationFactor, kObjectFactor, kTrialFactor}) {
    json["levels"][std::string(kExperimentFactorNames[f])] = table.levels(f);
  }
  json["trials_done"] = analysis.counts.done;
  json["trials_missing"] = analysis.counts.missing();
  json["error_df_of_the_papers_analysis"] =
      analysis.paper ? nlohmann::ordered_json(analysis.paper->error_df) : nullptr;
  json["problem_of_the_papers_analysis"] = analysis.paper_problem;
  for (const PaperAnova& anova :
       analysis.paper ? analysis.paper->anovas : std::vector<PaperAnova>{}) {
    json["mean_square_error"][std::string(outcome_text(anova.outcome).name)] =
        anova.mean_square_error;
  }
  json["notes"] = analysis.notes;
  return json;
}

}  // namespace

std::vector<Outcome> reported_outcomes(const OperatorAnalysis& analysis) {
  std::vector<Outcome> outcomes;
  for (const Outcome outcome :
       {Outcome::kTime, Outcome::kLosses, Outcome::kPenetration, Outcome::kContactAngle,
        Outcome::kLossesPerSecond, Outcome::kLosses100ms, Outcome::kTimeToLimit}) {
    if (outcome == Outcome::kTimeToLimit && analysis.counts.timeouts == 0) continue;
    if (analysis.table.has(outcome)) outcomes.push_back(outcome);
  }
  return outcomes;
}

const PaperMean* paper_mean_at(const TrialTable& table, Outcome outcome, const TrialLevels& at) {
  if (at.object >= 0) return nullptr;
  const auto& haptic = table.levels(kHapticFactor);
  const auto& rotation = table.levels(kRotationFactor);
  if (outcome == Outcome::kContactAngle) {
    const int place = at.haptic < 0 && haptic.size() == 1 ? 0 : at.haptic;
    if (place < 0 || haptic[place] != "UaH" || at.rotation < 0) return nullptr;
    return paper_mean(outcome, rotation[at.rotation]);
  }
  if ((at.haptic < 0) == (at.rotation < 0)) return nullptr;
  return paper_mean(outcome, at.haptic < 0 ? rotation[at.rotation] : haptic[at.haptic]);
}

const PaperLambda* paper_lambda(const FactorSet& term) {
  const auto rows = paper_manova();
  const auto found = std::find_if(rows.begin(), rows.end(),
                                  [&](const PaperLambda& row) { return row.term == term; });
  return found == rows.end() ? nullptr : &*found;
}

bool verdicts_differ(const ExperimentAnalysis& analysis, std::size_t finding) {
  const auto has = [&](Verdict verdict) {
    return std::any_of(
        analysis.operators.begin(), analysis.operators.end(),
        [&](const OperatorAnalysis& each) { return each.findings[finding].verdict == verdict; });
  };
  return has(Verdict::kAgrees) && has(Verdict::kDisagrees);
}

std::vector<ResultTable> analysis_tables(const ExperimentAnalysis& analysis) {
  std::vector<ResultTable> tables;
  for (const auto* columns :
       {&kEffectColumns, &kComparisonColumns, &kMeanColumns, &kMissingColumns, &kFindingColumns}) {
    tables.push_back({std::string(kAnalysisTableNames[tables.size()]), *columns, {}});
    for (const char* const name : {"view", "align", "start_orientation_deg", "scale"}) {
      tables.back().columns.emplace_back(name);
    }
  }
  for (const OperatorAnalysis& each : analysis.operators) {
    put_effects(each, tables[0]);
    if (each.paper) put_plsd(each, tables[1]);
    for (const PrimaryAnalysis& primary : each.primary) put_paired(each, primary, tables[1]);
    if (each.angle_of_uah) put_paired(each, *each.angle_of_uah, tables[1]);
    put_mean_rows(each, tables[2]);
    tables[3].rows.push_back(missing_row(each, each.counts));
    for (const TrialCounts& counts : each.by_condition) {
      tables[3].rows.push_back(missing_row(each, counts));
    }
    put_findings(analysis, each, tables[4]);
    for (ResultTable& table : tables) {
      for (Row& row : table.rows) {
        if (row.size() < table.columns.size()) put_whose(each, row);
      }
    }
  }
  tables.push_back({std::string(kAnalysisTableNames.back()), kDifferenceColumns, {}});
  put_differences(analysis, tables.back());
  return tables;
}

std::string analysis_json(const ExperimentAnalysis& analysis, const TrialSource& source) {
  const auto line = [](const nlohmann::ordered_json& json) {
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  };
  std::string text = "{\"palpate_analysis\": 1,\n \"file\": " + line(source.file) +
                     ",\n \"limit_s\": " + line(source.limit_s) + ",\n \"operators\": [";
  for (std::size_t i = 0; i < analysis.operators.size(); ++i) {
    text += (i > 0 ? ",\n   " : "\n   ") + line(operator_json(analysis.operators[i]));
  }
  text += "\n ]";
  for (const ResultTable& table : analysis_tables(analysis)) {
    text += ",\n " + line(table.name) + ": " + json_rows_of(table, 1);
  }
  return text + "}\n";
}

}  // namespace palpate
