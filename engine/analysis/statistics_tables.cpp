#include "engine/analysis/statistics_tables.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/analysis/analysis_tables.h"
#include "engine/analysis/intervals.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/human_units.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

using TableCells = std::vector<std::string>;

// A number of the paper, in the quiet colour.
std::string of_paper(const std::string& text) {
  return text.empty() ? "" : html_element("span class=\"spread\"", html_escaped(text));
}

// A p value, in bold if it is significant.
std::string p_cell(double p) {
  const std::string text = html_escaped(p_number(p));
  return p < kSignificance ? html_element("strong", text) : text;
}

std::string df_pair(double df1, double df2) {
  return df_text(df1) + ", " + df_text(df2);
}

std::string paper_f_text(const PaperF* paper) {
  if (!paper) return "";
  return as_printed(paper->f) + (paper->p.empty() ? "" : " (" + std::string(paper->p) + ")");
}

// Digits that suit an outcome: those that the paper prints, or two.
int decimals_of(Outcome outcome) {
  return outcome == Outcome::kPenetration ? 4 : 2;
}

// "27.12 (13.40)"
std::string mean_sd(double mean, double sd, int decimals) {
  return with_decimals(mean, decimals) + " (" + with_decimals(sd, decimals) + ")";
}

// "27.5 (15)"
std::string paper_mean_text(const PaperMean* paper) {
  if (!paper) return "";
  return as_printed(paper->mean) + " (" + as_printed(paper->sd) + ")";
}

// Whether the paper has a mean of the outcome at one of these levels.
bool has_paper_mean(const TrialTable& table, Outcome outcome,
                    const std::vector<TrialLevels>& levels) {
  return std::any_of(levels.begin(), levels.end(), [&](const TrialLevels& at) {
    return paper_mean_at(table, outcome, at) != nullptr;
  });
}

// The six cells of repeated measures: F, df, p, epsilon, corrected p, generalized eta squared.
void put_repeated(const PrimaryEffect& effect, TableCells& cells) {
  if (!effect.test) {
    cells.insert(cells.end(), {"-", "-", "-", "-", "-", "-"});
  } else {
    const RepeatedEffect& test = *effect.test;
    cells.insert(cells.end(), {number_or_dash(test.f), df_pair(test.df1, test.df2),
                               html_escaped(p_number(test.p)), with_decimals(test.epsilon, 3),
                               p_cell(test.p_gg), with_decimals(test.generalized_eta2, 3)});
  }
  cells.push_back(std::to_string(effect.participants));
}

const TableCells kFixedHeads = {"F", "df", "p", "partial \u03b7\u00b2", "n"};
const TableCells kRepeatedHeads = {"F", "df", "p", "GG \u03b5", "GG p", "gen. \u03b7\u00b2", "n"};
constexpr const char* kRepeatedGroup = "repeated measures (n participants)";

const PaperAnova* anova_with(const OperatorAnalysis& analysis, Outcome outcome) {
  if (!analysis.paper) return nullptr;
  for (const PaperAnova& anova : analysis.paper->anovas) {
    if (anova.outcome == outcome) return &anova;
  }
  return nullptr;
}

// The test of an effect in the paper's analysis; null if the model does not have the effect.
const FixedEffectTest* fixed_effect(const OperatorAnalysis& analysis, const PaperAnova* anova,
                                    const FactorSet& term) {
  if (!anova) return nullptr;
  const auto& terms = analysis.paper->terms;
  const auto found = std::find(terms.begin(), terms.end(), term);
  return found == terms.end() ? nullptr : &anova->effects[found - terms.begin()];
}

void put_fixed(const OperatorAnalysis& analysis, const FixedEffectTest* test, TableCells& cells) {
  if (!test) {
    cells.insert(cells.end(), {"-", "-", "-", "-", "-"});
    return;
  }
  cells.insert(cells.end(),
               {number_or_dash(test->f), df_pair(test->df1, test->df2), p_cell(test->p),
                with_decimals(test->partial_eta2, 3), std::to_string(analysis.paper->trials)});
}

std::string share_text(const TrialCounts& counts) {
  const int held = counts.done + counts.timeouts + counts.faults;
  if (held == 0) return "-";
  const auto percent = [](double share) { return with_decimals(100.0 * share, 1); };
  return percent(static_cast<double>(counts.timeouts) / held) + " % [" +
         percent(counts.timeout_share.low) + ", " + percent(counts.timeout_share.high) + "]";
}

TableCells counts_row(const std::string& name, const TrialCounts& counts) {
  return {name,
          std::to_string(counts.done),
          std::to_string(counts.timeouts),
          share_text(counts),
          std::to_string(counts.faults),
          std::to_string(counts.absent)};
}

}  // namespace

std::string outcome_heading(Outcome outcome) {
  const OutcomeText& text = outcome_text(outcome);
  std::string heading = with_unit(text.name, text.unit);
  if (heading[0] >= 'a' && heading[0] <= 'z') heading[0] = static_cast<char>(heading[0] - 32);
  return heading;
}

std::string mean_with_interval(double mean, double half_width, int decimals) {
  const std::string text = with_decimals(mean, decimals);
  return std::isnan(half_width) ? text : text + " \u00b1 " + with_decimals(half_width, decimals);
}

std::string trial_means_table(const OperatorAnalysis& analysis) {
  const TrialTable& trials = analysis.table;
  const auto outcomes = reported_outcomes(analysis);
  const auto levels = levels_of_means(trials);
  TableCells heads = {"level", "n trials"};
  for (const Outcome outcome : outcomes) {
    heads.push_back(with_unit(outcome_text(outcome).name, outcome_text(outcome).unit));
    if (has_paper_mean(trials, outcome, levels)) heads.emplace_back("the paper");
  }
  HtmlTable table(heads);
  for (const TrialLevels& at : levels) {
    const int done = trial_counts(trials, at).done;
    TableCells cells = {html_escaped(levels_name(trials, at)), std::to_string(done)};
    for (const Outcome outcome : outcomes) {
      const TrialMean mean = trial_mean(trials, outcome, at);
      cells.push_back(mean_sd(mean.mean, mean.sd, decimals_of(outcome)));
      if (mean.trials != done) cells.back() += ", n " + std::to_string(mean.trials);
      if (has_paper_mean(trials, outcome, levels)) {
        cells.push_back(of_paper(paper_mean_text(paper_mean_at(trials, outcome, at))));
      }
    }
    table.row(cells);
  }
  return table.html();
}

std::string participant_means_table(const OperatorAnalysis& analysis) {
  TableCells heads = {"level"};
  for (const PrimaryAnalysis& primary : analysis.primary) {
    heads.push_back(
        with_unit(outcome_text(primary.outcome).name, outcome_text(primary.outcome).unit));
  }
  HtmlTable table(heads);
  std::vector<TrialLevels> rows = levels_of_means(analysis.table);
  std::erase_if(rows, [](const TrialLevels& at) {
    return at.object >= 0 || (at.haptic < 0 && at.rotation < 0);
  });
  for (const TrialLevels& at : rows) {
    TableCells cells = {html_escaped(levels_name(analysis.table, at))};
    for (const PrimaryAnalysis& primary : analysis.primary) {
      const PrimaryMean* mean = primary.mean(at.haptic, at.rotation);
      const int decimals = decimals_of(primary.outcome);
      cells.push_back(mean ? mean_with_interval(mean->mean, mean->half_width, decimals) + ", n " +
                                 std::to_string(mean->participants)
                           : "-");
    }
    table.row(cells);
  }
  return table.html();
}

std::string manova_table(const OperatorAnalysis& analysis) {
  if (!analysis.paper) return "";
  HtmlTable table(
      {"effect", "Wilks\u2019 \u03bb", "F", "df2", "Wilks\u2019 \u03bb", "F", "df", "p", "n"}, 1,
      {{"", 1}, {"the paper", 3}, {"this file (n trials)", 5}});
  for (std::size_t i = 0; i < analysis.paper->terms.size(); ++i) {
    const WilksTest& test = analysis.paper->manova[i];
    const PaperLambda* paper = paper_lambda(analysis.paper->terms[i]);
    table.row({html_escaped(effect_name(analysis.paper->terms[i])),
               of_paper(paper ? with_decimals(paper->lambda, 3) : ""),
               of_paper(paper ? with_decimals(paper->f, 3) : ""),
               of_paper(paper ? df_text(paper->df2) : ""), with_decimals(test.lambda, 3),
               number_or_dash(test.f), df_pair(test.df1, test.df2), p_cell(test.p),
               std::to_string(analysis.paper->trials)});
  }
  return table.html();
}

std::string effects_table(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary) {
  const PaperAnova* anova = anova_with(analysis, primary.outcome);
  TableCells heads = {"effect"};
  std::vector<std::pair<std::string, std::size_t>> groups = {{"", 1}};
  if (anova) {
    heads.emplace_back("F");
    heads.insert(heads.end(), kFixedHeads.begin(), kFixedHeads.end());
    groups.emplace_back("the paper", 1);
    groups.emplace_back("as the paper did it (n trials)", kFixedHeads.size());
  }
  heads.insert(heads.end(), kRepeatedHeads.begin(), kRepeatedHeads.end());
  groups.emplace_back(kRepeatedGroup, kRepeatedHeads.size());
  HtmlTable table(heads, 1, groups);
  for (const PrimaryEffect& effect : primary.effects) {
    TableCells cells = {html_escaped(effect_name(effect.term))};
    if (anova) {
      cells.push_back(of_paper(paper_f_text(paper_f(primary.outcome, effect.term))));
      put_fixed(analysis, fixed_effect(analysis, anova, effect.term), cells);
    }
    put_repeated(effect, cells);
    table.row(cells);
  }
  return table.html();
}

std::string angle_effects_table(const PrimaryAnalysis& angle) {
  TableCells heads = {"effect", "F(1, 9)"};
  heads.insert(heads.end(), kRepeatedHeads.begin(), kRepeatedHeads.end());
  HtmlTable table(heads, 1, {{"", 1}, {"the paper", 1}, {kRepeatedGroup, kRepeatedHeads.size()}});
  for (const PrimaryEffect& effect : angle.effects) {
    TableCells cells = {html_escaped(effect_name(effect.term)),
                        of_paper(paper_f_text(paper_f(angle.outcome, effect.term)))};
    put_repeated(effect, cells);
    table.row(cells);
  }
  return table.html();
}

std::string plsd_table(const PaperAnova& anova) {
  if (anova.comparisons.empty()) return "";
  const int decimals = decimals_of(anova.outcome) + 1;
  HtmlTable table({"pair", "difference", "least significant", "t", "p"});
  for (const PlsdFamily& family : anova.comparisons) {
    table.heading(html_escaped(family.factor));
    for (const PlsdPair& pair : family.pairs) {
      table.row({html_escaped(family.levels[pair.first] + " \u2212 " + family.levels[pair.second]),
                 with_decimals(pair.difference, decimals),
                 with_decimals(pair.least_significant, decimals), number_or_dash(pair.t),
                 p_cell(pair.p)});
    }
  }
  return table.html();
}

std::string paired_table(const PrimaryAnalysis& primary) {
  if (primary.families.empty()) return "";
  const int decimals = decimals_of(primary.outcome) + 1;
  HtmlTable table(
      {"pair", "difference, 95 % interval", "t", "df", "p", "Holm p", "n participants"});
  for (const PrimaryFamily& family : primary.families) {
    table.heading(html_escaped(family.name));
    for (const PrimaryPair& pair : family.pairs) {
      const PairedT& test = pair.test;
      table.row({html_escaped(pair.name),
                 mean_with_interval(test.difference, test.half_width, decimals),
                 number_or_dash(test.t), df_text(test.df), html_escaped(p_number(test.p)),
                 p_cell(pair.p_holm), std::to_string(test.pairs)});
    }
  }
  return table.html();
}

std::string missing_table(const OperatorAnalysis& analysis) {
  HtmlTable table({"condition", "completed", "timeouts", "share of timeouts, 95 % interval",
                   "faults", "absent"});
  table.row(counts_row("all trials", analysis.counts));
  for (const TrialCounts& counts : analysis.by_condition) {
    if (analysis.counts.missing() == 0) break;
    table.row(counts_row(html_escaped(levels_name(analysis.table, counts.at)), counts));
  }
  return table.html();
}

}  // namespace palpate
