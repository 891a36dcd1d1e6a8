#include "engine/analysis/power_text.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/analysis/intervals.h"
#include "engine/analysis/power_fit.h"
#include "engine/analysis/power_notes.h"
#include "engine/analysis/statistics_text.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr const char* kNoEffect = "no effect";

std::string range_text(const std::string& from, const std::string& to) {
  return from == to ? from : from + " to " + to;
}

// The least and the largest of numbers that are shown alike.
std::string number_range(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return range_text(number_or_dash(values.front()), number_or_dash(values.back()));
}

std::string unit_suffix(const PowerStudy& study) {
  const std::string_view unit = outcome_text(study.measure->outcome).unit;
  return unit.empty() ? "" : " " + std::string(unit);
}

double power_of(const PowerStudy& study, std::size_t assumption, std::size_t test, int n) {
  return static_cast<double>(study.counts.at(assumption, test, n)) / study.settings().sets;
}

// Of one noise, with its interval; of several, the range.
std::string example_text(const PowerStudy& study, std::size_t test) {
  constexpr int kDecimals = 3;
  const int n = power_example(study);
  if (study.has_one_noise()) {
    const Interval interval = wilson_interval(study.counts.at(0, test, n), study.settings().sets);
    return with_decimals(power_of(study, 0, test, n), kDecimals) + " (" +
           with_decimals(interval.low, kDecimals) + " to " +
           with_decimals(interval.high, kDecimals) + ")";
  }
  double least = 1.0, most = 0.0;
  for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
    least = std::min(least, power_of(study, i, test, n));
    most = std::max(most, power_of(study, i, test, n));
  }
  return range_text(with_decimals(most, kDecimals), with_decimals(least, kDecimals));
}

std::string people_number(const PowerStudy& study, const std::optional<int>& n) {
  return n ? std::to_string(*n) : ">" + std::to_string(study.settings().participants);
}

// The smallest and the largest answer of all assumptions.
std::string people_range(const PowerStudy& study, std::size_t test, int percent) {
  const int beyond = study.settings().participants + 1;
  int least = beyond, most = 0;
  std::string least_text, most_text;
  for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
    const int n = study.counts.smallest(i, test, study.settings().sets, percent).value_or(beyond);
    const std::string text = people_text(study, i, test, percent);
    if (least_text.empty() || n < least) least_text = text;
    if (most_text.empty() || n > most) most_text = text;
    least = std::min(least, n);
    most = std::max(most, n);
  }
  return range_text(least_text, most_text);
}

// "12", or "12 (11 to 13)"
std::string people_with_bounds(const PowerStudy& study, std::size_t test, int percent) {
  const std::string people = people_text(study, 0, test, percent);
  const PeopleBounds bounds = people_bounds(study, 0, test, percent);
  if (people == kNoEffect || bounds.low == bounds.high) return people;
  return people + " (" + people_number(study, bounds.low) + " to " +
         people_number(study, bounds.high) + ")";
}

std::string effects_text(const PowerStudy& study) {
  std::string text;
  for (std::size_t c = 0; c < study.model.means.size(); ++c) {
    text += (c > 0 ? ", " : "") + study.model.design.condition_name(c) + " " +
            number_or_dash(study.model.means[c]);
  }
  return text + unit_suffix(study) + (study.has_paper_effects ? " (from the paper)" : "");
}

// "; 7.12 to 10.9 by rounding"
std::string rounding_text(const PaperScatter& scatter) {
  return "; " + number_or_dash(scatter.low) + " to " + number_or_dash(scatter.high) +
         " by the rounding of its means";
}

// Where an error is from, with what the rounding of the paper's means allows.
std::string error_source(const PowerStudy& study, const std::string& from) {
  for (const PaperScatter& scatter : study.paper_scatter) {
    if (study.measure->outcome == Outcome::kContactAngle) {
      return "assumed, so that the paired difference has the paper's " +
             number_or_dash(scatter.sd) + unit_suffix(study) + rounding_text(scatter);
    }
    if (from.ends_with(scatter.from)) return from + rounding_text(scatter);
  }
  return from;
}

// "8.98 s (paper, F of Haptic; 7.1 to 10.9 by ...), 9.88 s (paper, F of Rotation; ...)"
std::string errors_text(const PowerStudy& study) {
  std::string text;
  std::set<std::string> done;
  for (const PowerAssumption& assumed : study.assumptions) {
    if (!done.insert(assumed.error_from).second) continue;
    std::vector<double> sds;
    for (const PowerAssumption& other : study.assumptions) {
      if (other.error_from == assumed.error_from) sds.push_back(other.error_sd);
    }
    text += (text.empty() ? "" : ", ") + number_range(std::move(sds)) + unit_suffix(study) + " (" +
            error_source(study, assumed.error_from) + ")";
  }
  return text;
}

std::string shares_text(const PowerStudy& study) {
  std::vector<double> u, w;
  for (const PowerAssumption& assumed : study.assumptions) {
    u.push_back(assumed.share_u);
    w.push_back(assumed.share_w);
  }
  const std::size_t count = study.assumptions.size();
  std::string text = "u " + number_range(std::move(u)) + ", w " + number_range(std::move(w));
  if (count > 1) {
    text += "; " + std::to_string(count) + " combinations with the error";
    if (study.has_one_noise()) text += ", all with the same noise";
  }
  return text;
}

std::string pilot_text(const PowerStudy& study) {
  const PilotEstimate& pilot = *study.pilot;
  const PowerVariances& v = pilot.variances;
  return printable(study.request.pilot) + ": " + std::to_string(pilot.participants) + " people, " +
         std::to_string(pilot.trials) + " trials, m = " + number_or_dash(pilot.m) + "; sd of u " +
         number_or_dash(std::sqrt(v.u)) + ", of w " + number_or_dash(std::sqrt(v.w)) + ", of e " +
         number_or_dash(std::sqrt(v.e)) + unit_suffix(study);
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

std::string padded_rows(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows[0].size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size() + 2);
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i + 1 < row.size(); ++i) text += padded(row[i], widths[i]);
    text += row.back() + "\n";
  }
  return text;
}

std::string table_text(const PowerStudy& study) {
  const auto lines = power_lines(study);
  std::vector<std::vector<std::string>> rows = {{"people for a power of"}};
  for (const int percent : kPowerPercents) {
    rows[0].push_back("0." + std::to_string(percent / 10));
  }
  rows[0].push_back("power with " + std::to_string(power_example(study)) + " people");
  for (const PowerLine& line : lines) {
    rows.push_back({"  " + line.test});
    rows.back().insert(rows.back().end(), line.people.begin(), line.people.end());
    rows.back().push_back(line.power);
  }
  return padded_rows(rows);
}

std::string pairs_text(const PowerStudy& study) {
  if (!study.pilot) return "";
  std::vector<std::vector<std::string>> rows = {
      {"sd of people's differences" + (unit_suffix(study).empty() ? "" : "," + unit_suffix(study)),
       "pilot", "model with m = " + number_or_dash(study.pilot->m)}};
  for (const PilotPair& pair : pilot_fit(*study.pilot, study.tests).pairs) {
    rows.push_back({"  " + pair.pair, number_or_dash(pair.observed), number_or_dash(pair.model)});
  }
  return padded_rows(rows) + "\n";
}

}  // namespace

std::string people_text(const PowerStudy& study, std::size_t assumption, std::size_t test,
                        int percent) {
  if (study.tests.is_null(study.tests.tests[test], study.model.means)) return kNoEffect;
  return people_number(study,
                       study.counts.smallest(assumption, test, study.settings().sets, percent));
}

PeopleBounds people_bounds(const PowerStudy& study, std::size_t assumption, std::size_t test,
                           int percent) {
  const int sets = study.settings().sets;
  const double power = percent / 100.0;
  return {
      study.counts.first_from(
          assumption, test, [&](int count) { return wilson_interval(count, sets).high >= power; }),
      study.counts.first_from(
          assumption, test, [&](int count) { return wilson_interval(count, sets).low >= power; })};
}

int power_example(const PowerStudy& study) {
  return std::min(kPaperParticipants, study.settings().participants);
}

std::vector<PowerLine> power_lines(const PowerStudy& study) {
  std::vector<PowerLine> lines;
  for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
    const PowerTest& test = study.tests.tests[t];
    const std::string correction(kPowerCorrectionNames[static_cast<std::size_t>(test.correction)]);
    PowerLine line{test.name + ", " + correction, {}, example_text(study, t)};
    for (const int percent : kPowerPercents) {
      line.people.push_back(study.has_one_noise() ? people_with_bounds(study, t, percent)
                                                  : people_range(study, t, percent));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<std::pair<std::string, std::string>> power_facts(const PowerStudy& study) {
  std::vector<std::pair<std::string, std::string>> facts = {
      {"measure", std::string(outcome_text(study.measure->outcome).name)},
      {"model", "y = condition + u(person) + w(person, condition) + e(trial), all normal"},
      {"means of the conditions", effects_text(study)},
      {"trials of a person in a condition", std::to_string(study.model.trials)}};
  if (study.pilot) {
    facts.emplace_back("pilot", pilot_text(study));
  } else {
    facts.emplace_back("standard deviation of one trial", errors_text(study));
    facts.emplace_back("shares of its variance", shares_text(study));
  }
  facts.emplace_back("data sets", std::to_string(study.settings().sets) + ", seed " +
                                      std::to_string(study.settings().seed));
  return facts;
}

std::string assumption_text(const PowerStudy& study, std::size_t assumption) {
  const PowerAssumption& assumed = study.assumptions[assumption];
  if (study.pilot) return assumed.error_from;
  return "error " + number_or_dash(assumed.error_sd) + unit_suffix(study) + ", u " +
         number_or_dash(assumed.share_u) + ", w " + number_or_dash(assumed.share_w);
}

std::string power_text(const PowerStudy& study) {
  std::string text;
  for (const auto& [name, value] : power_facts(study)) text += name + ": " + value + "\n";
  text += "\n" + table_text(study) + "\n" + pairs_text(study);
  for (const std::string& note : power_notes(study)) text += "note: " + note + "\n";
  return text;
}

}  // namespace palpate
