#include "engine/analysis/report_explanations.h"

#include <algorithm>
#include <utility>

#include "engine/report/html.h"

namespace palpate {
namespace {

std::string item(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + text) + "\n";
}

// For every file.
std::string statistics_items(bool is_simulated) {
  return item("Why two analyses?",
              "The paper\u2019s analysis takes its 720 trials for independent, although ten people "
              "made 72 each. We repeat it in order to compare our numbers with the paper\u2019s. "
              "If there is no effect at all, it should reject 5 % of the time. In random data "
              "in which people differ by one standard deviation of the residuals, it rejects the "
              "hypothesis of no effect of force in 0.4 % of the cases; if people also react "
              "differently to force, by 0.4 standard deviations, in 27 %. Repeated measures "
              "compare each effect with its own scatter between participants, and reject at most "
              "as often "
              "as they should. They decide here whether a finding agrees.") +
         item("Counts and times are not normal.",
              "F and t tests assume normal residuals. Counts and times are skewed, so their small "
              "p values are approximate.") +
         item("Losses of contact grow with time.",
              "A condition that takes longer loses contact more often for this reason alone. The "
              "rounded means of the paper are 0.84 (H), 0.80 (UaH) and 0.83 (NoH) losses per "
              "second, 0.88 without rotation (NoR) and 0.79 with it (R). The report therefore has "
              "the losses per second" +
                  std::string(is_simulated ? " as well." : " as well, if the file allows it.")) +
         item("When does a finding agree?",
              "An effect agrees if it is significant at the 5 % level and the means are in the "
              "paper\u2019s order. \u201cNo effect\u201d agrees if the effect is not significant, "
              "which few participants make likely. For the MANOVA, which repeated measures do not "
              "have, the paper\u2019s analysis decides. A finding is not testable if the file "
              "lacks the measure or the level, or if too few participants are complete.") +
         item("Factors with one level",
              "are left out of the model. The notes of the analysis name them. The paper\u2019s "
              "means pool three forces, two rotations and four objects; beside a file that has "
              "fewer, they are not like for like.");
}

// For simulated operators alone.
std::string simulation_items() {
  return item("What do p values of simulated operators mean?",
              "The three measures of a simulated person have no population behind them. A p value "
              "speaks of the seeds and of the ranges in the operator file, not of people, and more "
              "simulated participants make any difference significant.") +
         item("What is our choice?",
              "The paper states neither the sizes of its objects and spheres nor its stiffness K "
              "and damping B. Those of the plan are ours, so its seconds and its numbers of losses "
              "are no target. The hand slows down when the proxy and the device are far apart: "
              "this is our reading of the paper\u2019s instruction to keep frame and ball close, "
              "and it can favour force.") +
         item("Why may the contact angles with rotation be below the paper\u2019s 32.1 deg?",
              "The rule of alignment may be one reason. A4 turns the normal to the nearer end of "
              "the "
              "motor\u2019s axis unless the plan asks for the alignment forward. Table 1\u2019s "
              "acos, taken literally, is that alignment: it turns the normal to the positive end, "
              "by up to 180 deg, so that the normal is away from the axis for longer.") +
         item(
             "What follows from the construction?",
             "That force makes the penetration smaller (H &lt; UaH &lt; NoH) follows from springs, "
             "and that rotation makes the contact angle smaller follows from A4. These two test "
             "the machinery and are no findings. The operator file people2005 also takes its hand "
             "from the paper\u2019s penetration in NoH and H.") +
         item(
             "Nothing was tuned until it agreed.",
             "The operator files and the plan do not follow these results; an earlier sketch of "
             "the "
             "operator had been seen before, as the operator files state. The following that leads "
             "is chosen by the plan, not by its results.");
}

std::string words(bool is_simulated, bool is_still) {
  using Word = std::pair<const char*, const char*>;
  constexpr Word kWords[] = {
      {"NoH, UaH, H", "no force; force along the actuated axis only (under-actuated); full force."},
      {"NoR, R",
       "the scene stands still; A4 turns the scene until the contact normal lies along "
       "the motor\u2019s axis."},
      {"losses of contact",
       "how often the proxy left the wall between start and end; a gap of 100 "
       "ms or more counts in the second measure of losses."},
      {"penetration",
       "mean distance between the device and the proxy in contact, in decimetres as "
       "in the paper: 0.1 dm are 10 mm."},
      {"contact angle", "angle between the contact normal and the motor\u2019s axis, 0 to 90 deg."},
      {"F, df, p",
       "the test statistic, its degrees of freedom, and the probability of at least "
       "this F without an effect."},
      {"MANOVA, Wilks\u2019 \u03bb",
       "a test of several measures together; a small \u03bb is a large "
       "effect. Rao\u2019s F is computed from it."},
      {"GG \u03b5, GG p",
       "Greenhouse and Geisser\u2019s correction for unequal variances of "
       "differences; \u03b5 is 1 if none is needed."},
      {"\u03b7\u00b2",
       "the share of the variance that an effect explains: partial, of what the "
       "other effects leave; generalized, of all that holds participants."},
      {"Holm p", "the p of a pair, adjusted for the number of pairs in its group."},
      {"PLSD",
       "Fisher\u2019s protected least significant difference, which the paper used for "
       "pairs; it is computed only after a significant F."},
      {"Trial", "the block: how often a participant met the same condition before."},
      {"n.s.", "not significant."}};
  constexpr Word kFollowings[] = {
      {"delayed",
       "the simulated operator takes the scene to be where it was in the newest picture "
       "it has seen."},
      {"predict", "it turns that picture on at the speed it has seen, for the picture\u2019s age."},
      {"replan", "it holds a seen pose of the scene for a time before it looks again."},
      {"frozen", "it keeps the pose seen at the last corner or loss of contact."}};
  constexpr Word kAdaptations = {
      "adapts-0, adapts-0.5, adapts-1",
      "it sees the scene stand still (view still) while its hand moves in another direction than "
      "the picture. It believes the scene to be turned by none, half or all of the turn."};
  std::string out = "<h2 id=\"words\">Words</h2>\n<dl class=\"facts\">\n";
  const auto put = [&](const Word& word) {
    out += html_element("dt", word.first) + html_element("dd", word.second) + "\n";
  };
  for (const Word& word : kWords) put(word);
  if (is_simulated) {
    for (const Word& word : kFollowings) put(word);
  }
  if (is_still) put(kAdaptations);
  return out + "</dl>\n";
}

}  // namespace

std::string levels_html() {
  return "<p>Participants follow the contour of an object with a device of one motor. Force: "
         "<strong>NoH</strong> none, <strong>UaH</strong> along the motor\u2019s axis only, "
         "<strong>H</strong> full force. Rotation: <strong>NoR</strong> the scene stands still, "
         "<strong>R</strong> the scene turns towards the motor\u2019s axis (A4). The paper is "
         "L\u00e9cuyer, Burkhardt, Le Biller and Congedo, 2005.</p>\n";
}

std::string explanations_html(const ExperimentAnalysis& analysis) {
  const bool is_simulated = analysis.has_simulated();
  const bool is_still = std::any_of(
      analysis.operators.begin(), analysis.operators.end(), [](const OperatorAnalysis& each) {
        return each.is_simulated() && each.table.variant().view == "still";
      });
  return "<section id=\"explanations\">\n<h2>What these numbers can state</h2>\n" +
         (is_simulated ? simulation_items() : std::string()) + statistics_items(is_simulated) +
         words(is_simulated, is_still) + "</section>\n";
}

}  // namespace palpate
