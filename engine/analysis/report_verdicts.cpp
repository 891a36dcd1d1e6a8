#include "engine/analysis/report_verdicts.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "engine/analysis/analysis_plots.h"
#include "engine/analysis/analysis_tables.h"
#include "engine/report/html.h"

namespace palpate {
namespace {

constexpr std::array<const char*, kVerdictNames.size()> kVerdictMarks = {"good", "bad", "untested"};

constexpr std::string_view kManova = "MANOVA, ";  // begins the names of its findings

std::string verdict_mark(Verdict verdict) {
  const auto place = static_cast<std::size_t>(verdict);
  return html_element(std::string("span class=\"mark ") + kVerdictMarks[place] + "\"",
                      kVerdictNames[place]);
}

// Statistics and means on a line each, without a line break within a p value.
std::string in_lines(const std::string& text) {
  constexpr std::pair<std::string_view, std::string_view> kReplacements[] = {
      {"; ", "<br>"}, {"p = ", "p&nbsp;=&nbsp;"}, {"p < ", "p&nbsp;&lt;&nbsp;"}};
  std::string html;
  for (std::string_view rest = text; !rest.empty();) {
    std::size_t taken = 0;
    for (const auto& [found, by] : kReplacements) {
      if (!rest.starts_with(found)) continue;
      html += by;
      taken = found.size();
    }
    if (taken == 0) {
      html += html_escaped(rest.substr(0, rest.find_first_of(";p", 1)));
      taken = std::min(rest.size(), rest.find_first_of(";p", 1));
    }
    rest.remove_prefix(taken);
  }
  return html;
}

std::string finding_cell(const ExperimentAnalysis& analysis, std::size_t i) {
  const PaperFinding& finding = paper_findings()[i];
  std::string text = html_element("strong", html_escaped(finding.name)) + "<br>" +
                     html_escaped(finding.statement) + "<br>" +
                     html_element("span class=\"spread\"", in_lines(finding.printed));
  if (verdicts_differ(analysis, i)) {
    text += "<br>" +
            html_element("span class=\"mark flips\"", "flips between " + columns_text(analysis));
  }
  return html_element("td class=\"finding\"", text);
}

// The verdict, its reason, and the other analysis if it disagrees.
std::string result_cell(const FindingResult& result) {
  std::string text = verdict_mark(result.verdict) + "<br>" + in_lines(result.because);
  if (result.as_paper && *result.as_paper != result.verdict) {
    text +=
        "<br>" +
        html_element("span class=\"spread\"",
                     "the paper\u2019s analysis: " +
                         std::string(kVerdictNames[static_cast<std::size_t>(*result.as_paper)]));
  }
  return html_element("td class=\"found\"", text);
}

std::string heading_row(const char* text, std::size_t columns) {
  return "<tr class=\"method\"><th>" + std::string(text) + "</th><th colspan=\"" +
         std::to_string(columns - 1) + "\"></th></tr>\n";
}

std::string findings_table(const ExperimentAnalysis& analysis) {
  const std::size_t columns = 1 + analysis.operators.size();
  std::string out =
      "<div class=\"wide\"><table class=\"findings\">\n<thead><tr><th>finding of the paper, and "
      "its figures</th>";
  for (const OperatorAnalysis& each : analysis.operators) {
    out += html_element(
        "th", html_escaped(each.name()) + (each.is_simulated() ? "<br>(simulated operators)" : ""));
  }
  out += "</tr></thead>\n<tbody>\n";
  const auto findings = paper_findings();
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (is_multivariate(findings[i]) && !is_multivariate(findings[i - 1])) {
      out += heading_row("MANOVA: time, losses and penetration together", columns);
    }
    out += "<tr>" + finding_cell(analysis, i);
    for (const OperatorAnalysis& each : analysis.operators) out += result_cell(each.findings[i]);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

// The statements with a verdict.
std::string statements(const OperatorAnalysis& analysis, Verdict verdict) {
  std::string items;
  for (const auto& [name, statement] : findings_with(analysis, verdict)) {
    items += html_element("li", html_element("strong", html_escaped(name)) + ": " +
                                    html_escaped(statement)) +
             "\n";
  }
  return items.empty() ? "<p>None.</p>\n" : "<ul>\n" + items + "</ul>\n";
}

std::string flips_sentence(const ExperimentAnalysis& analysis) {
  if (analysis.operators.size() == 1) return "";
  const auto flips = differing_findings(analysis);
  if (flips.empty()) return "<p>All columns of the table have the same verdicts.</p>\n";
  std::string names;
  for (const std::size_t i : flips) {
    names += (names.empty() ? "" : "; ") + html_escaped(paper_findings()[i].name);
  }
  const std::string why = analysis.has_people() || analysis.variants() > 1
                              ? ""
                              : " (how a simulated operator takes the turning of the scene into "
                                "account)";
  return "<p>Verdicts flip between " + columns_text(analysis) + why + " for " +
         std::to_string(flips.size()) + " of " + std::to_string(paper_findings().size()) +
         " findings: " + names + ".</p>\n";
}

std::string evidence_sentence(const ExperimentAnalysis& analysis) {
  if (!analysis.has_simulated()) return "";
  return "<p>Two of these findings are no evidence about people, because the simulation is built "
         "so: "
         "force reduces the penetration (springs), and rotation reduces the contact angle (A4). <a "
         "href=\"#explanations\">What these numbers can state</a></p>\n";
}

}  // namespace

std::string columns_text(const ExperimentAnalysis& analysis) {
  if (analysis.has_people() && analysis.has_simulated()) return "people and simulated operators";
  if (analysis.variants() == 1) return "followings";
  return analysis.has_simulated() ? "followings and settings" : "settings";
}

std::array<int, kVerdictNames.size()> verdict_counts(const OperatorAnalysis& analysis) {
  std::array<int, kVerdictNames.size()> counts{};
  for (const FindingResult& result : analysis.findings) {
    ++counts[static_cast<std::size_t>(result.verdict)];
  }
  return counts;
}

std::string verdict_counts_text(const OperatorAnalysis& analysis) {
  const auto [agree, disagree, untested] = verdict_counts(analysis);
  return std::to_string(agree) + (agree == 1 ? " agrees, " : " agree, ") +
         std::to_string(disagree) + (disagree == 1 ? " disagrees, " : " disagree, ") +
         std::to_string(untested) + " not testable";
}

std::vector<std::size_t> differing_findings(const ExperimentAnalysis& analysis) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < paper_findings().size(); ++i) {
    if (verdicts_differ(analysis, i)) found.push_back(i);
  }
  return found;
}

std::vector<std::pair<std::string, std::string>> findings_with(const OperatorAnalysis& analysis,
                                                               Verdict verdict) {
  std::vector<std::pair<std::string, std::string>> found;
  std::string multivariate;
  for (std::size_t i = 0; i < analysis.findings.size(); ++i) {
    if (analysis.findings[i].verdict != verdict) continue;
    const PaperFinding& finding = paper_findings()[i];
    if (is_multivariate(finding)) {
      multivariate += (multivariate.empty() ? "" : ", ") + finding.name.substr(kManova.size());
    } else {
      found.emplace_back(finding.name, finding.statement);
    }
  }
  if (!multivariate.empty()) found.emplace_back("MANOVA", "effects of " + multivariate);
  return found;
}

bool is_multivariate(const PaperFinding& finding) {
  return finding.name.starts_with(kManova);
}

std::string verdicts_html(const ExperimentAnalysis& analysis) {
  const OperatorAnalysis& leading = analysis.operators[0];
  std::string out =
      "<section class=\"advice\" id=\"answer\">\n<h2>What agrees with the paper</h2>\n";
  out +=
      html_element("p", html_element("strong", "Of the paper\u2019s " +
                                                   std::to_string(paper_findings().size()) +
                                                   " findings, " + verdict_counts_text(leading)) +
                            " (" + html_escaped(whose_trials(leading)) + ").") +
      "\n";
  out += "<div class=\"lists\"><div><h3>Agrees</h3>\n" + statements(leading, Verdict::kAgrees) +
         "</div>\n<div><h3>Disagrees</h3>\n" + statements(leading, Verdict::kDisagrees) +
         "</div>\n";
  if (verdict_counts(leading)[2] > 0) {
    out += "<div><h3>Not testable</h3>\n" + statements(leading, Verdict::kNotTestable) + "</div>\n";
  }
  return out + "</div>\n" + flips_sentence(analysis) + evidence_sentence(analysis) +
         findings_table(analysis) + "</section>\n";
}

}  // namespace palpate
