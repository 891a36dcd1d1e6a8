#include "engine/analysis/power_study.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/analysis/statistics_text.h"
#include "engine/trials/strict_json.h"
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
    begin = std::min(text.find_first_not_of(' ', begin), end);
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
    return {{"paper's paired difference", angle_variance(shares)}};
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
  if (!study.request.error_sd && study.measure->outcome == Outcome::kContactAngle) {
    study.paper_scatter = {paper_angle_scatter()};
  } else if (!study.request.error_sd) {
    study.paper_scatter = paper_trial_scatter(study.measure->outcome);
  }
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
  const auto table = read_pilot(request.pilot, request.following, study.model.design);
  if (!table) return table.error();
  auto pilot = estimate_pilot(*table, study.measure->outcome, study.model.design, request.pilot);
  if (!pilot) return pilot.error();
  put_assumption(study, "pilot", pilot->variances);
  const double m = std::clamp(std::round(pilot->m), 1.0, double{kMostPowerTrials});
  study.model.trials = request.trials.value_or(static_cast<int>(m));
  study.pilot = std::move(*pilot);
  return std::nullopt;
}

// What makes the scatter so small beside the means.
Error bad_scale(const PowerStudy& study, double sd, double largest) {
  const PowerRequest& request = study.request;
  const std::string problem = "a standard deviation of " + number_or_dash(sd) +
                              " of w and e beside means of up to " + number_or_dash(largest) +
                              "; expected numbers of one scale";
  const std::string hint = "check the unit of the effects";
  if (study.pilot) {
    return {ErrorCode::kInvalidContent, request.pilot,
            "column " + std::string(outcome_text(study.measure->outcome).column),
            "gives " + problem, hint};
  }
  if (request.error_sd) return invalid_argument("--error", "gives " + problem, hint);
  return invalid_argument("--effect", "gives " + problem, hint);
}

// The sums of the simulation keep at least half of their digits.
std::optional<Error> check_scatter(const PowerStudy& study) {
  const double least = std::sqrt(std::numeric_limits<double>::epsilon());
  double largest = 0.0;
  for (const double mean : study.model.means) largest = std::max(largest, std::abs(mean));
  for (std::size_t i = 0; i < study.model.variances.size(); ++i) {
    const double sd = std::sqrt(study.noise(i));
    const double all = study.assumptions[i].error_sd;
    if (!(sd > least * all)) {
      if (study.pilot) return bad_scale(study, sd, all);
      return invalid_argument("--share-u",
                              "leaves w and e a standard deviation of " + number_or_dash(sd) +
                                  " beside " + number_or_dash(all) + " of one trial; expected less",
                              "u cancels in every test");
    }
    if (!(sd > least * largest)) return bad_scale(study, sd, largest);
  }
  return std::nullopt;
}

}  // namespace

bool PowerStudy::has_one_noise() const {
  const auto first = first_of_equal_noise(model);
  return std::count(first.begin(), first.end(), 0u) == std::ssize(first);
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
  study.model.trials = request.trials.value_or(kPaperTrialsOfCondition);
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

}  // namespace palpate
