#include "engine/analysis/report_operator.h"

#include <algorithm>

#include "engine/analysis/analysis_plots.h"
#include "engine/analysis/analysis_tables.h"
#include "engine/analysis/statistics_tables.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

std::string subheading(const std::string& title) {
  return html_element("h3", html_escaped(title)) + "\n";
}
std::string note(const std::string& text) {
  return html_element("p class=\"note\"", text) + "\n";
}

// The figures of one kind of operator; ids and names contain its name.
class Figures {
 public:
  Figures(const OperatorAnalysis& analysis, std::vector<std::string>& warnings)
      : analysis_(analysis), warnings_(warnings) {}

  std::string figure_6() {
    return "<figure class=\"figure6\">\n<div class=\"panels\">\n" +
           panel(rotation_haptic_svg(analysis_, Outcome::kTime), "time", "Figure 6, total time") +
           panel(rotation_haptic_svg(analysis_, Outcome::kPenetration), "depth",
                 "Figure 6, mean penetration") +
           "</div>\n" + html_element("figcaption", figure_6_caption()) + "\n</figure>\n";
  }

  std::string figure_7() {
    return "<figure class=\"figure7\">\n<div class=\"panels\">\n" +
           panel(angle_svg(analysis_), "angle", "Figure 7, contact angle of UaH") +
           html_element("div", angle_table()) + "</div>\n" +
           html_element("figcaption",
                        "<strong>Figure 7</strong>, " + html_escaped(whose_trials(analysis_)) +
                            ": the mean angle between the contact normal and the motor\u2019s "
                            "axis, with force along that axis only (UaH). " +
                            whiskers()) +
           "\n</figure>\n";
  }

 private:
  std::string panel(const Result<std::string>& svg, const std::string& id,
                    const std::string& title) {
    const std::string name = title + ", " + whose_trials(analysis_);
    if (svg) return inline_svg(*svg, analysis_.anchor() + "-" + id + "-", name);
    warnings_.push_back(name + ": is not drawn: " + svg.error().to_string());
    return html_element("p class=\"bad\"", html_escaped(title) + ": no diagram: " +
                                               html_escaped(svg.error().to_string())) +
           "\n";
  }

  static std::string whiskers() {
    return "Whiskers on coloured points are 95 % intervals of differences within participants "
           "(Cousineau and Morey). ";
  }

  std::string figure_6_caption() const {
    return "<strong>Figure 6</strong>, " + html_escaped(whose_trials(analysis_)) +
           ": means of participants by force and rotation. " + whiskers() +
           "Diamonds are the paper\u2019s means by force over both rotations: the paper prints no "
           "number of its Figure 6. By rotation it prints " +
           paper_by_rotation(Outcome::kTime) + ", and " + paper_by_rotation(Outcome::kPenetration) +
           ". Penetration is in decimetres, as in the paper: 0.1 dm are 10 mm. The axis of time "
           "need not "
           "begin at 0.";
  }

  // "total time NoR 25.14 (12.041), R 29.15 (15.972) s"
  static std::string paper_by_rotation(Outcome outcome) {
    std::string text(outcome_text(outcome).name);
    const char* separator = " ";
    for (const std::string_view level : kRotationNames) {
      const PaperMean* mean = paper_mean(outcome, level);
      text += separator + std::string(level) + " " + as_printed(mean->mean) + " (" +
              as_printed(mean->sd) + ")";
      separator = ", ";
    }
    return html_escaped(text + " " + std::string(outcome_text(outcome).unit));
  }

  // Ours beside the paper's.
  std::string angle_table() const {
    HtmlTable table({"rotation", "this file, mean \u00b1 95 % interval", "the paper, mean (sd)"});
    const auto& rotation = analysis_.table.levels(kRotationFactor);
    for (int r = 0; r < static_cast<int>(rotation.size()); ++r) {
      const PrimaryMean* mean = analysis_.angle_of_uah->mean(-1, r);
      const PaperMean* paper = paper_mean(Outcome::kContactAngle, rotation[r]);
      table.row({html_escaped(rotation[r]),
                 mean ? mean_with_interval(mean->mean, mean->half_width, 1) + " deg" : "-",
                 as_printed(paper->mean) + " (" + as_printed(paper->sd) + ") deg"});
    }
    return table.html();
  }

  const OperatorAnalysis& analysis_;
  std::vector<std::string>& warnings_;
};

std::string means_html(const OperatorAnalysis& analysis) {
  return subheading("Means and standard deviations of trials") +
         note(
             "Mean (standard deviation) of completed trials; the paper\u2019s beside them, in "
             "grey. The paper\u2019s contact angles are those of UaH. If fewer trials have the "
             "measure, their number n follows.") +
         trial_means_table(analysis) + subheading("Means of participants") +
         note(
             "Mean \u00b1 half of the 95 % interval (Cousineau and Morey) and the number n of "
             "participants who have every condition that is compared: of all levels of the factor "
             "in a row of means, so that the means of these levels are of the same people.") +
         participant_means_table(analysis);
}

std::string manova_html(const OperatorAnalysis& analysis) {
  const std::string heading = subheading("MANOVA: total time, losses of contact and penetration");
  if (!analysis.paper) {
    return heading + note("The paper\u2019s analysis is not possible. " +
                          html_escaped(analysis.paper_problem));
  }
  return heading +
         note(
             "Wilks\u2019 \u03bb with Rao\u2019s F, as the paper did it. A significant p is "
             "bold.") +
         manova_table(analysis);
}

std::string effects_html(const OperatorAnalysis& analysis) {
  std::string out = subheading("Every F") +
                    note(
                        "Significant p values are bold. The repeated measures decide, with the "
                        "p of Greenhouse and Geisser (GG p). A dash: not in the model, or fewer "
                        "than two participants have all conditions.");
  for (const PrimaryAnalysis& primary : analysis.primary) {
    out += html_element("h4", html_escaped(outcome_heading(primary.outcome))) +
           effects_table(analysis, primary);
  }
  if (analysis.angle_of_uah) {
    out += html_element("h4", "Mean contact angle of UaH alone (deg)") +
           angle_effects_table(*analysis.angle_of_uah);
  }
  return out;
}

std::string comparisons_html(const OperatorAnalysis& analysis) {
  std::string out = subheading("Comparisons of pairs");
  out += note(
      "Paired t tests of participants\u2019 means. Holm\u2019s p is adjusted within each "
      "group of pairs.");
  for (const PrimaryAnalysis& primary : analysis.primary) {
    out +=
        html_element("h4", html_escaped(outcome_heading(primary.outcome))) + paired_table(primary);
  }
  if (!analysis.paper) return out;
  out += subheading("Comparisons as the paper did them") +
         note(
             "Fisher\u2019s PLSD over all trials, only for factors whose F is significant in the "
             "paper\u2019s analysis.");
  for (const PaperAnova& anova : analysis.paper->anovas) {
    const std::string table = plsd_table(anova);
    out += html_element("h4", html_escaped(outcome_heading(anova.outcome))) +
           (table.empty() ? note("No factor has a significant F.") : table);
  }
  return out;
}

std::string missing_html(const OperatorAnalysis& analysis) {
  std::string out = subheading("Missing trials");
  if (analysis.counts.missing() == 0) return out + note("No trial is missing.");
  out += note("Timeouts reached the limit of " +
              html_escaped(number_or_dash(analysis.table.limit_s())) +
              " s; faults were ended by a fault of the engine; absent trials are not in the file. "
              "None is replaced by a number. The interval is Wilson\u2019s.") +
         missing_table(analysis);
  if (analysis.counts.timeouts > 0) {
    out += note(
        "Slow trials end as timeouts, so the times of completed trials are too short on "
        "average. The tables have the total time once more with each timeout as the "
        "limit.");
  }
  return out;
}

// "675 of 720 trials were completed by 10 participants; timeouts: 45, faults: 0, absent: 0."
std::string counts_sentence(const OperatorAnalysis& analysis) {
  const TrialCounts& counts = analysis.counts;
  std::string text = std::to_string(counts.done) + " of " +
                     std::to_string(counts.done + counts.missing()) + " trials were completed by " +
                     std::to_string(analysis.table.participants().size()) + " participants";
  if (counts.missing() > 0) {
    text += "; timeouts: " + std::to_string(counts.timeouts) +
            ", faults: " + std::to_string(counts.faults) +
            ", absent: " + std::to_string(counts.absent);
  }
  return note(text + ".");
}

std::string notes_html(const OperatorAnalysis& analysis) {
  if (analysis.notes.empty()) return "";
  std::string items;
  for (const std::string& text : analysis.notes) {
    items += html_element("li", html_escaped(text)) + "\n";
  }
  return subheading("Notes of the analysis") + "<ul>\n" + items + "</ul>\n";
}

}  // namespace

std::string operator_html(const OperatorAnalysis& analysis, bool leads,
                          std::vector<std::string>& warnings) {
  Figures figures(analysis, warnings);
  std::string title = whose_trials(analysis);
  title[0] = static_cast<char>(title[0] - 'a' + 'A');
  std::string out = "<section class=\"operator\" id=\"" + analysis.anchor() + "\">\n" +
                    html_element("h2", html_escaped(title)) + "\n" + counts_sentence(analysis) +
                    notes_html(analysis) + figures.figure_6();
  if (analysis.angle_of_uah) {
    out += figures.figure_7();
  } else {
    out += note("No Figure 7: the file does not have the contact angle of UaH.");
  }
  const std::string tables = means_html(analysis) + effects_html(analysis) +
                             comparisons_html(analysis) + manova_html(analysis) +
                             missing_html(analysis);
  if (leads) return out + tables + "</section>\n";
  return out + "<details>\n" +
         html_element("summary", "All tables: " + html_escaped(whose_trials(analysis))) + "\n" +
         tables + "</details>\n</section>\n";
}

}  // namespace palpate
