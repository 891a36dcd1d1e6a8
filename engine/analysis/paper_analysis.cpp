#include "engine/analysis/paper_analysis.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/analysis/intervals.h"

namespace palpate {
namespace {

// A trial of the model: its levels of all four factors, and its measures.
struct ModelTrial {
  std::array<int, 4> levels;
  std::array<double, kPaperOutcomes.size()> values;
};

Result<std::vector<ModelTrial>> model_trials(const TrialTable& table) {
  for (const Outcome outcome : kPaperOutcomes) {
    if (table.has(outcome)) continue;
    return invalid_argument(std::string(outcome_text(outcome).column),
                            "is in no completed trial; expected it in every completed trial",
                            "the multivariate analysis needs total time, losses of contact and "
                            "penetration");
  }
  std::vector<ModelTrial> trials;
  for (int p = 0; p < static_cast<int>(table.participants().size()); ++p) {
    for (int c = 0; c < table.conditions(); ++c) {
      for (int t = 0; t < table.level_count(kTrialFactor); ++t) {
        const TrialRow* row = table.row(p, c, t);
        if (!row || row->status != TrialStatus::kDone) continue;
        ModelTrial trial{{table.level_in(c, kHapticFactor), table.level_in(c, kRotationFactor),
                          table.level_in(c, kObjectFactor), t},
                         {}};
        for (std::size_t i = 0; i < kPaperOutcomes.size(); ++i) {
          const auto value = outcome_of(*row, kPaperOutcomes[i], table.limit_s());
          if (!value) {
            return invalid_argument("participant " + row->participant + ", block " +
                                        std::to_string(row->block) + ", " +
                                        table.condition_name(c) + ", " +
                                        std::string(outcome_text(kPaperOutcomes[i]).column),
                                    "is empty; expected a number, because the status is done");
          }
          trial.values[i] = *value;
        }
        trials.push_back(trial);
      }
    }
  }
  return trials;
}

// A condition without a completed trial, if there is one.
std::optional<int> empty_condition(const TrialTable& table, const std::vector<ModelTrial>& trials) {
  std::vector<bool> is_filled(static_cast<std::size_t>(table.conditions()), false);
  for (const ModelTrial& trial : trials) {
    is_filled[table.condition(trial.levels[0], trial.levels[1], trial.levels[2])] = true;
  }
  const auto empty = std::find(is_filled.begin(), is_filled.end(), false);
  if (empty == is_filled.end()) return std::nullopt;
  return static_cast<int>(empty - is_filled.begin());
}

// A condition that has no completed trial in some block, if there is one.
std::optional<std::string> empty_block(const TrialTable& table,
                                       const std::vector<ModelTrial>& trials) {
  const int blocks = table.level_count(kTrialFactor);
  std::vector<bool> is_filled(static_cast<std::size_t>(table.conditions() * blocks), false);
  for (const ModelTrial& trial : trials) {
    const int condition = table.condition(trial.levels[0], trial.levels[1], trial.levels[2]);
    is_filled[condition * blocks + trial.levels[3]] = true;
  }
  const auto empty = std::find(is_filled.begin(), is_filled.end(), false);
  if (empty == is_filled.end()) return std::nullopt;
  const auto place = static_cast<int>(empty - is_filled.begin());
  return table.condition_name(place / blocks) + " in block " +
         table.levels(kTrialFactor)[place % blocks];
}

// The factors that the model has. A sentence for each other one.
std::vector<ExperimentFactor> factors_of(const TrialTable& table,
                                         const std::vector<ModelTrial>& trials,
                                         std::vector<std::string>& left_out) {
  std::vector<ExperimentFactor> factors;
  for (const ExperimentFactor f : {kHapticFactor, kRotationFactor, kObjectFactor, kTrialFactor}) {
    if (table.level_count(f) == 1) {
      left_out.push_back(
          std::string(kExperimentFactorNames[f]) +
          " is left out, because the file has one level of it: " + table.levels(f)[0] + ".");
    } else if (const auto empty = f == kTrialFactor ? empty_block(table, trials) : std::nullopt) {
      left_out.push_back("Trial is left out, because no trial of " + *empty + " was completed.");
    } else {
      factors.push_back(f);
    }
  }
  return factors;
}

std::vector<LevelMean> level_means(const TrialTable& table, const std::vector<ModelTrial>& trials,
                                   ExperimentFactor factor, std::size_t outcome) {
  std::vector<LevelMean> means(static_cast<std::size_t>(table.level_count(factor)));
  for (const ModelTrial& trial : trials) {
    means[trial.levels[factor]].mean += trial.values[outcome];
    means[trial.levels[factor]].count += 1.0;
  }
  for (LevelMean& mean : means) mean.mean /= mean.count;
  return means;
}

PaperAnova anova_of(const TrialTable& table, const std::vector<ModelTrial>& trials,
                    const std::vector<FactorSet>& terms, const FactorialFit& fit,
                    std::size_t outcome) {
  const auto response = static_cast<Eigen::Index>(outcome);
  PaperAnova anova{
      kPaperOutcomes[outcome], fit.error_sscp(response, response) / fit.error_df, {}, {}};
  for (std::size_t term = 0; term < terms.size(); ++term) {
    anova.effects.push_back(test_fixed_effect(fit, term, response));
    if (terms[term].size() > 1 || !(anova.effects.back().p < kSignificance)) continue;
    const auto factor = static_cast<ExperimentFactor>(terms[term][0]);
    PlsdFamily family{std::string(kExperimentFactorNames[factor]),
                      table.levels(factor),
                      level_means(table, trials, factor, outcome),
                      {}};
    family.pairs = fisher_plsd(family.means, anova.mean_square_error, fit.error_df);
    anova.comparisons.push_back(std::move(family));
  }
  return anova;
}

// The error matrix must have an inverse.
std::optional<Error> check_error_matrix(const FactorialFit& fit, Eigen::Index rows) {
  if (fit.error_df < static_cast<int>(kPaperOutcomes.size())) {
    return invalid_argument("rows",
                            "leave " + std::to_string(fit.error_df) +
                                " degrees of freedom for the error; expected at least 3",
                            "add participants or blocks");
  }
  const auto singular = singular_response(fit.error_sscp, fit.rounding_ss, rows);
  if (!singular) return std::nullopt;
  return invalid_argument(
      std::string(outcome_text(kPaperOutcomes[static_cast<std::size_t>(*singular)]).column),
      "is constant within the conditions, or follows from the measures before it, so that the "
      "error "
      "matrix is singular; expected a measure that varies",
      "check the column");
}

}  // namespace

Result<PaperAnalysis> analyse_as_paper(const TrialTable& table) {
  const auto trials = model_trials(table);
  if (!trials) return trials.error();
  if (const auto empty = empty_condition(table, *trials)) {
    return invalid_argument("condition " + table.condition_name(*empty),
                            "has no completed trial; expected one or more",
                            "the effects of its factors cannot be separated");
  }
  PaperAnalysis analysis;
  const auto factors = factors_of(table, *trials, analysis.left_out);
  if (factors.empty()) {
    return invalid_argument("rows", "have one level of every factor; expected a factor with two");
  }
  std::vector<Factor> columns;
  for (const ExperimentFactor f : factors) {
    columns.push_back({std::string(kExperimentFactorNames[f]), table.level_count(f), {}});
    for (const ModelTrial& trial : *trials) columns.back().level_of_row.push_back(trial.levels[f]);
  }
  const auto terms = all_terms(factors.size());
  const auto design = FactorialDesign::create(columns, terms);
  if (!design) return design.error();
  Eigen::MatrixXd responses(trials->size(), kPaperOutcomes.size());
  for (Eigen::Index row = 0; row < responses.rows(); ++row) {
    for (Eigen::Index i = 0; i < responses.cols(); ++i) {
      responses(row, i) = (*trials)[row].values[static_cast<std::size_t>(i)];
    }
  }
  const FactorialFit fit = design->fit(responses);
  if (const auto error = check_error_matrix(fit, responses.rows())) return *error;
  analysis.trials = static_cast<int>(trials->size());
  analysis.error_df = fit.error_df;
  for (const FactorSet& term : terms) {
    FactorSet of_experiment;
    for (const std::size_t f : term) of_experiment.push_back(factors[f]);
    analysis.terms.push_back(std::move(of_experiment));
  }
  for (const TermFit& term : fit.terms) {
    analysis.manova.push_back(rao_test(wilks_lambda(fit.error_sscp, term.sscp),
                                       static_cast<int>(kPaperOutcomes.size()), term.df,
                                       fit.error_df));
  }
  for (std::size_t i = 0; i < kPaperOutcomes.size(); ++i) {
    analysis.anovas.push_back(anova_of(table, *trials, analysis.terms, fit, i));
  }
  return analysis;
}

}  // namespace palpate
