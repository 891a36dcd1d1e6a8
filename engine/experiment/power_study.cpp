#include "engine/experiment/power_study.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/experiment/paper_findings.h"
#include "engine/experiment/statistics_text.h"
#include "engine/experiment/strict_json.h"
#include "geometry/base/printable.h"
#include "geometry/base/quoted.h"

namespace palpate {
namespace {

// The default grid of both shares, in tenths. The sum of the two is at most nine tenths.
constexpr int kLeastTenths = 1, kMostTenths = 8, kMostTenthsTogether = 9;

Result<const PowerMeasure*> find_power_measure(const std::string& name) {
  std::vector<std::string_view> names;
  for (const PowerMeasure& measure : kPowerMeasures) {
    if (measure.name == name) return &measure;
    names.push_back(measure.name);
  }
  return invalid_argument("--measure",
                          "is " + in_quotes(name) + "; expected " + joined_words(names));
}

std::string condition_list(const PowerDesign& design) {
  std::string text;
  for (std::size_t c = 0; c < design.conditions(); ++c) {
    text += (c > 0 ? ", " : "") + design.condition_name(c);
  }
  return text;
}

Error bad_effect(const PowerDesign& design, const std::string& problem) {
  return invalid_argument(
      "--effect", problem,
      "write " + design.condition_name(0) + "=29.5,... for each of " + condition_list(design));
}

// "NoH-R=29.5": the condition and its mean.
Result<std::pair<std::size_t, double>> parse_effect(const PowerDesign& design,
                                                    const std::string& part) {
  const std::size_t equals = part.find('=');
  const std::string name = part.substr(0, equals);
  std::size_t condition = 0;
  while (condition < design.conditions() && design.condition_name(condition) != name) ++condition;
  if (equals == std::string::npos || condition == design.conditions()) {
    return bad_effect(design, "has the part " + in_quotes(part) + "; expected CONDITION=MEAN");
  }
  const char* const end = part.data() + part.size();
  double value = 0.0;
  const auto [stop, failed] = std::from_chars(part.data() + equals + 1, end, value);
  if (failed != std::errc() || stop != end || !(std::abs(value) <= kMostPowerValue)) {
    return bad_effect(design, "has " + in_quotes(part.substr(equals + 1)) + " for " + name +
                                  "; expected a number from -1e9 to 1e9");
  }
  return std::pair(condition, value);
}

Result<std::vector<double>> parse_effects(const PowerDesign& design, const std::string& text) {
  std::vector<std::optional<double>> found(design.conditions());
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto effect = parse_effect(design, text.substr(begin, end - begin));
    if (!effect) return effect.error();
    if (found[effect->first]) {
      return bad_effect(design, "has " + design.condition_name(effect->first) +
                                    " twice; expected each condition once");
    }
    found[effect->first] = effect->second;
    begin = end + 1;
  }
  std::vector<double> means;
  for (std::size_t c = 0; c < found.size(); ++c) {
    if (!found[c]) {
      return bad_effect(design, "lacks " + design.condition_name(c) + "; expected each condition");
    }
    means.push_back(*found[c]);
  }
  return means;
}

using Shares = std::pair<double, double>;  // of u and w

std::vector<double> share_candidates(const std::optional<double>& given) {
  if (given) return {*given};
  std::vector<double> tenths;
  for (int i = kLeastTenths; i <= kMostTenths; ++i) tenths.push_back(i / 10.0);
  return tenths;
}

Result<std::vector<Shares>> power_shares(const PowerRequest& request) {
  // A share that was given may leave less than a tenth to e.
  const bool is_given = request.share_u && request.share_w;
  const double most =
      (is_given ? 1.0 : kMostTenthsTogether / 10.0) + 4.0 * std::numeric_limits<double>::epsilon();
  std::vector<Shares> shares;
  for (const double w : share_candidates(request.share_w)) {
    for (const double u : share_candidates(request.share_u)) {
      if (u + w <= most) shares.emplace_back(u, w);
    }
  }
  if (is_given && shares.empty()) {
    return invalid_argument("--share-u",
                            "and --share-w have a sum above 1; expected shares of one "
                            "variance");
  }
  if (shares.empty()) {
    return invalid_argument(request.share_u ? "--share-u" : "--share-w",
                            "leaves no room for the other share, from 0.1 on, and 0.1 for e",
                            "give both shares");
  }
  if (is_given && shares[0].first >= 1.0) {
    return invalid_argument("--share-u", "is 1; expected less, so that w and e scatter",
                            "u cancels in every test");
  }
  return shares;
}

PowerVariances split_variance(double variance, const Shares& shares) {
  const auto [u, w] = shares;
  return {variance * u, variance * w, variance * std::max(0.0, 1.0 - u - w)};
}

// The variance of one trial of the paper's contact angle, from that of the paired difference, which
// is twice the variance of w and of the mean of 12 e.
double angle_variance(const Shares& shares) {
  const double sd = paper_angle_scatter().sd;
  const PowerVariances parts = split_variance(1.0, shares);
  return 0.5 * sd * sd / (parts.w + parts.e / kPaperTrialsOfCondition);
}

// The variances of one trial that are assumed with these shares, and where each comes from.
std::vector<std::pair<std::string, double>> error_variances(const PowerRequest& request,
                                                            Outcome outcome, const Shares& shares) {
  if (request.error_sd) return {{"--error", *request.error_sd * *request.error_sd}};
  if (outcome == Outcome::kContactAngle) {
    return {{"paper, F of " + std::string(paper_angle_scatter().from), angle_variance(shares)}};
  }
  std::vector<std::pair<std::string, double>> found;
  for (const PaperScatter& scatter : paper_trial_scatter(outcome)) {
    found.emplace_back("paper, F of " + std::string(scatter.from), scatter.sd * scatter.sd);
  }
  return found;
}

void put_assumption(PowerStudy& study, std::string from, const PowerVariances& variances) {
  const double all = variances.u + variances.w + variances.e;
  study.assumptions.push_back(
      {std::move(from), std::sqrt(all), variances.u / all, variances.w / all});
  study.model.variances.push_back(variances);
}

std::optional<Error> assume_variances(PowerStudy& study) {
  const auto shares = power_shares(study.request);
  if (!shares) return shares.error();
  for (const Shares& of : *shares) {
    for (const auto& [from, variance] :
         error_variances(study.request, study.measure->outcome, of)) {
      put_assumption(study, from, split_variance(variance, of));
      study.assumptions.back().share_u = of.first;  // without rounding
      study.assumptions.back().share_w = of.second;
    }
  }
  return std::nullopt;
}

std::optional<Error> take_pilot(PowerStudy& study) {
  const PowerRequest& request = study.request;
  const std::pair<const char*, bool> excluded[] = {{"--error", request.error_sd.has_value()},
                                                   {"--share-u", request.share_u.has_value()},
                                                   {"--share-w", request.share_w.has_value()}};
  for (const auto& [option, is_given] : excluded) {
    if (is_given) {
      return invalid_argument(option, "excludes --pilot; expected one of them",
                              "the pilot gives all variances");
    }
  }
  const auto table = read_pilot(request.pilot, request.following);
  if (!table) return table.error();
  auto pilot = estimate_pilot(*table, study.measure->outcome, study.model.design, request.pilot);
  if (!pilot) return pilot.error();
  put_assumption(study, "pilot", pilot->variances);
  study.pilot = std::move(*pilot);
  return std::nullopt;
}

// The sums of the simulation keep at least half of their digits.
std::optional<Error> check_scatter(const PowerStudy& study) {
  double largest = 0.0;
  for (const double mean : study.model.means) largest = std::max(largest, std::abs(mean));
  for (std::size_t i = 0; i < study.model.variances.size(); ++i) {
    const double sd = std::sqrt(study.noise(i));
    const double all = study.assumptions[i].error_sd;
    if (std::isfinite(all) && all <= kMostPowerValue &&
        sd > std::sqrt(std::numeric_limits<double>::epsilon()) * std::max(largest, all)) {
      continue;
    }
    const std::string option = study.pilot ? "--pilot" : "--error";
    return invalid_argument(option,
                            "gives a standard deviation of " + number_or_dash(sd) +
                                " of w and e beside means of up to " + number_or_dash(largest) +
                                "; expected numbers of one scale",
                            "check the unit of the effects");
  }
  return std::nullopt;
}

std::string pilot_note(const PilotEstimate& pilot) {
  const double spread = std::sqrt(2.0 / pilot.df_pc);
  return "A mean square of the pilot with d degrees of freedom has a relative standard error of "
         "sqrt(2 / d): MS_pc has " +
         std::to_string(pilot.df_pc) + ", which gives " + with_decimals(100.0 * spread, 0) +
         " %. The power inherits this error, which its interval does not show.";
}

void add_pilot_notes(const PilotEstimate& pilot, std::vector<std::string>& notes) {
  notes.emplace_back(pilot_note(pilot));
  const std::pair<const char*, double> raw[] = {{"u", pilot.raw.u}, {"w", pilot.raw.w}};
  for (const auto& [name, value] : raw) {
    if (!(value < 0.0)) continue;
    notes.emplace_back("The pilot's estimate of the variance of " + std::string(name) + " is " +
                       number_or_dash(value) + ", which is negative; 0 is used.");
  }
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

void add_effect_notes(const PowerStudy& study, std::vector<std::string>& notes) {
  if (!study.has_paper_effects) return;
  if (study.measure->outcome == Outcome::kContactAngle) {
    notes.emplace_back(
        "The effects are the paper's means of UaH; the paper states no contact "
        "angle of the other levels of Haptic.");
    return;
  }
  notes.emplace_back(
      "The effects are the paper's means at the levels of Haptic and of Rotation. "
      "It states no means of their combinations: that the two add up, without an "
      "interaction, is an assumption.");
  if (paper_f(study.measure->outcome, {kHapticFactor, kRotationFactor})->p.empty()) {
    notes.emplace_back("The paper found an interaction in this measure, which these effects lack.");
  }
}

void add_error_notes(const PowerStudy& study, std::vector<std::string>& notes) {
  const PowerRequest& request = study.request;
  if (study.pilot) return add_pilot_notes(*study.pilot, notes);
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
  }
  if (!request.share_u || !request.share_w) {
    notes.emplace_back(
        "The shares that are not given run from 0.1 to 0.8 in steps of 0.1, with at "
        "least 0.1 for e. They are assumptions; a pilot measures them.");
  }
}

}  // namespace

double PowerStudy::noise(std::size_t model_index) const {
  const PowerVariances& variances = model.variances[model_index];
  return variances.w + variances.e / model.trials;
}

std::vector<std::size_t> PowerStudy::by_noise() const {
  std::vector<std::size_t> order(model.variances.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return noise(a) < noise(b); });
  return order;
}

Result<PowerStudy> prepare_power(const PowerRequest& request) {
  PowerStudy study;
  study.request = request;
  const auto measure = find_power_measure(request.measure);
  if (!measure) return measure.error();
  study.measure = *measure;
  study.model.design = power_design_of(study.measure->outcome);
  study.model.trials = request.trials;
  study.tests = power_tests(study.model.design);
  study.has_paper_effects = request.effects.empty();
  if (study.has_paper_effects) {
    study.model.means = paper_condition_means(study.measure->outcome);
  } else {
    auto means = parse_effects(study.model.design, request.effects);
    if (!means) return means.error();
    study.model.means = std::move(*means);
  }
  if (request.pilot.empty() && !request.following.empty()) {
    return invalid_argument("--following", "is given without --pilot; expected a pilot",
                            "it chooses trials of the pilot's file");
  }
  auto failed = request.pilot.empty() ? assume_variances(study) : take_pilot(study);
  if (!failed) failed = check_scatter(study);
  if (failed) return *failed;
  return study;
}

std::vector<std::string> power_notes(const PowerStudy& study) {
  std::vector<std::string> notes;
  if (!study.measure->not_normal.empty()) {
    notes.emplace_back("The model is normal, and the measure is " +
                       std::string(study.measure->not_normal) +
                       ". Take the numbers of people as approximate.");
  }
  add_effect_notes(study, notes);
  add_error_notes(study, notes);
  notes.emplace_back(
      "u, how people differ in all conditions alike, cancels in every test; what "
      "counts is the variance of w plus that of e divided by the trials in a "
      "condition.");
  return notes;
}

}  // namespace palpate
