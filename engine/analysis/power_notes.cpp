#include "engine/analysis/power_notes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/analysis/paper_findings.h"
#include "engine/analysis/power_fit.h"
#include "engine/analysis/statistics_text.h"

namespace palpate {
namespace {

using Notes = std::vector<std::string>;

// Means that differ by more than this factor are probably in different units.
constexpr double kMostUnitFactor = 5.0;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string in_unit(const PowerStudy& study, const std::string& number) {
  const std::string_view unit = outcome_text(study.measure->outcome).unit;
  return unit.empty() ? number : number + " " + std::string(unit);
}

void add_unit_note(const PowerStudy& study, Notes& notes) {
  const double of_pilot = mean_of(study.pilot->means), of_effects = mean_of(study.model.means);
  const double least = std::min(std::abs(of_pilot), std::abs(of_effects));
  const double most = std::max(std::abs(of_pilot), std::abs(of_effects));
  if (most <= kMostUnitFactor * least && of_pilot * of_effects >= 0.0) return;
  notes.emplace_back("Check the units: the mean of the pilot is " +
                     in_unit(study, number_or_dash(of_pilot)) + ", and that of the effects is " +
                     in_unit(study, number_or_dash(of_effects)) + ".");
}

void add_trials_note(const PowerStudy& study, Notes& notes) {
  const double m = study.pilot->m;
  if (m == study.model.trials) return;
  const std::string trials = std::to_string(study.model.trials);
  notes.emplace_back(study.request.trials
                         ? "The pilot has m = " + number_or_dash(m) +
                               " trials of a person in a condition, and --trials is " + trials +
                               ": the variance of e is divided by " + trials + "."
                         : "The pilot's m is " + number_or_dash(m) +
                               " trials of a person in a condition, an effective number; " +
                               trials + " are used.");
}

// What is common to objects in all conditions of a person is in MS_e alone.
void add_fit_notes(const PowerStudy& study, Notes& notes) {
  const PilotEstimate& pilot = *study.pilot;
  if (!(pilot.raw.w < 0.0)) return;
  const PilotFit fit = pilot_fit(pilot, study.tests);
  notes.emplace_back(
      "The noise of the model, MS_e / m = " + number_or_dash(pilot.ms_e / pilot.m) +
      ", is larger than what was observed, MS_pc / m = " + number_or_dash(pilot.ms_pc / pilot.m) +
      ", by the factor " + number_or_dash(1.0 / fit.f) +
      ". Numbers of people grow about in proportion to the noise.");
  if (!fit.is_too_low()) return;
  notes.emplace_back(
      "The model does not fit this pilot: F = MS_pc / MS_e = " + number_or_dash(fit.f) + " with " +
      std::to_string(pilot.df_pc) + " and " + std::to_string(pilot.df_e) +
      " degrees of freedom is significantly below 1 (" + p_text(fit.p_below) +
      "). It has no term for how a person differs in one object, in all conditions alike. Such "
      "scatter stays in MS_e and cancels in the tests, so that the numbers of people are too "
      "large.");
}

std::string uncertainty_note(const PilotEstimate& pilot) {
  const double spread = std::sqrt(2.0 / pilot.df_pc);
  return "A mean square of the pilot with d degrees of freedom has a relative standard error of "
         "sqrt(2 / d): MS_pc has " +
         std::to_string(pilot.df_pc) + ", which gives " + with_decimals(100.0 * spread, 0) +
         " %. The power inherits this error, which its interval does not show.";
}

void add_missing_notes(const PilotEstimate& pilot, Notes& notes) {
  if (!pilot.left_out.empty()) {
    std::string names;
    for (const std::string& name : pilot.left_out) names += (names.empty() ? "" : ", ") + name;
    notes.emplace_back(
        "Left out of the pilot, because a condition has no completed trial of theirs: " + names +
        ".");
  }
  if (pilot.missing > 0) {
    notes.emplace_back(
        std::to_string(pilot.missing) + " of " + std::to_string(pilot.missing + pilot.trials) +
        " trials of the pilot are missing (timeouts, faults, absent). The estimates "
        "hold if they are missing at random; a long trial that ran into the time limit "
        "is not.");
  }
}

void add_pilot_notes(const PowerStudy& study, Notes& notes) {
  const PilotEstimate& pilot = *study.pilot;
  add_trials_note(study, notes);
  add_fit_notes(study, notes);
  notes.emplace_back(uncertainty_note(pilot));
  const std::pair<const char*, double> raw[] = {{"u", pilot.raw.u}, {"w", pilot.raw.w}};
  for (const auto& [name, value] : raw) {
    if (!(value < 0.0)) continue;
    notes.emplace_back("The pilot's estimate of the variance of " + std::string(name) + " is " +
                       number_or_dash(value) + ", which is negative; 0 is used.");
  }
  add_missing_notes(pilot, notes);
}

// "R - NoR = 1 may be 0 to 2"
std::string rounded_difference(Outcome outcome, const char* level, const char* other) {
  const double a = paper_mean(outcome, level)->mean, b = paper_mean(outcome, other)->mean;
  const double rounding = paper_rounding(a) + paper_rounding(b);
  // A difference of decimal numbers, of which four are rounded.
  const double least = 4.0 * std::numeric_limits<double>::epsilon() * (std::abs(a) + std::abs(b));
  const auto text = [&](double value) {
    return number_or_dash(std::abs(value) <= least ? 0.0 : value);
  };
  return std::string(level) + " - " + other + " = " + text(a - b) + " may be " +
         text(a - b - rounding) + " to " + text(a - b + rounding);
}

std::string rounded_effects(Outcome outcome) {
  const std::string rotation = rounded_difference(outcome, "R", "NoR");
  if (outcome == Outcome::kContactAngle) return rotation;
  return rounded_difference(outcome, "H", "NoH") + ", and " + rotation;
}

void add_effect_notes(const PowerStudy& study, Notes& notes) {
  notes.emplace_back(
      "Effects of a study that was published because they were significant are too large on "
      "average: numbers of people from them are a lower bound.");
  if (!study.has_paper_effects) return;
  const Outcome outcome = study.measure->outcome;
  const std::string rounded =
      " These means are rounded, and so are the effects: " + rounded_effects(outcome) + ".";
  if (outcome == Outcome::kContactAngle) {
    notes.emplace_back(
        "The effects are the paper's means of UaH; the paper states no contact "
        "angle of the other levels of Haptic." +
        rounded);
    return;
  }
  notes.emplace_back(
      "The effects are the paper's means at the levels of Haptic and of Rotation. "
      "It states no means of their combinations: that the two add up, without an "
      "interaction, is an assumption." +
      rounded);
  if (paper_f(outcome, {kHapticFactor, kRotationFactor})->p.empty()) {
    notes.emplace_back("The paper found an interaction in this measure, which these effects lack.");
  }
}

// Which of the paper's two errors the other one's rounding excludes.
void add_incompatible_notes(const PowerStudy& study, Notes& notes) {
  for (const PaperScatter& one : study.paper_scatter) {
    for (const PaperScatter& other : study.paper_scatter) {
      if (other.allows(one.sd)) continue;
      notes.emplace_back(
          "The error " + in_unit(study, number_or_dash(one.sd)) + " from the F of " +
          std::string(one.from) + " is incompatible with the F of " + std::string(other.from) +
          ": the rounding of its means allows " + number_or_dash(other.low) + " to " +
          in_unit(study, number_or_dash(other.high)) + ". The F of " + std::string(one.from) +
          " allows " + number_or_dash(one.low) + " to " + in_unit(study, number_or_dash(one.high)) +
          "; both F have the same error.");
    }
  }
}

void add_error_notes(const PowerStudy& study, Notes& notes) {
  const PowerRequest& request = study.request;
  if (study.pilot) return add_pilot_notes(study, notes);
  if (!request.error_sd && study.measure->outcome == Outcome::kContactAngle) {
    notes.emplace_back(
        "The scatter is that of the paper's paired difference, which fixes w and "
        "the mean of 12 e together: with 12 trials in a condition, the shares make no "
        "difference.");
  } else if (!request.error_sd) {
    notes.emplace_back(
        "The error of one trial is that of the paper's own model, from its F and "
        "its means, which are rounded. It holds u, w and e; the paper does not say how "
        "much of each.");
    add_incompatible_notes(study, notes);
  }
  if (!request.share_u || !request.share_w) {
    notes.emplace_back(
        "The shares that are not given run from 0.1 to 0.8 in steps of 0.1, with at "
        "least 0.1 for e. They are assumptions; a pilot measures them.");
  }
}

void add_model_notes(const PowerStudy& study, Notes& notes) {
  notes.emplace_back(
      "u, how people differ in all conditions alike, cancels in every test; what "
      "counts is the variance of w plus that of e divided by the trials in a "
      "condition.");
  std::string equal = "w and e are independent and scatter equally in all conditions.";
  if (study.model.design.conditions() > 2) {
    equal +=
        " Sphericity therefore holds in the model, and what the correction of Greenhouse and "
        "Geisser really costs, where it does not hold, is not shown.";
  }
  notes.emplace_back(equal);
  notes.emplace_back(
      "A number of people counts people with completed trials in every condition. If trials or "
      "people will be missing" +
      std::string(study.pilot && (study.pilot->missing > 0 || !study.pilot->left_out.empty())
                      ? ", as in the pilot"
                      : "") +
      ", more people are needed.");
}

}  // namespace

std::vector<std::string> power_notes(const PowerStudy& study) {
  Notes notes;
  if (study.pilot) add_unit_note(study, notes);
  if (!study.measure->not_normal.empty()) {
    notes.emplace_back("The model is normal, and the measure is " +
                       std::string(study.measure->not_normal) +
                       ". Take the numbers of people as approximate.");
  }
  add_effect_notes(study, notes);
  add_error_notes(study, notes);
  add_model_notes(study, notes);
  return notes;
}

}  // namespace palpate
