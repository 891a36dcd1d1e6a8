#include "engine/analysis/power_tables.h"

#include <array>
#include <charconv>

#include <nlohmann/json.hpp>

#include "engine/analysis/intervals.h"
#include "engine/analysis/power_fit.h"
#include "engine/analysis/power_notes.h"
#include "engine/analysis/power_text.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

using PowerJson = nlohmann::ordered_json;

std::string correction_name(const PowerTest& test) {
  return std::string(kPowerCorrectionNames[static_cast<std::size_t>(test.correction)]);
}

// With six digits, or fewer that identify them.
std::string six_digits(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::scientific, 5);
  double rounded = value;
  std::from_chars(text.data(), end.ptr, rounded);
  return as_printed(rounded);
}

std::vector<ResultCell> assumption_cells(const PowerStudy& study, std::size_t i) {
  const PowerAssumption& assumed = study.assumptions[i];
  return {assumed.error_from, six_digits(assumed.error_sd), six_digits(assumed.share_u),
          six_digits(assumed.share_w)};
}

ResultCell people_cell(const PowerStudy& study, std::size_t i, std::size_t test, int percent) {
  const auto n = study.counts.smallest(i, test, study.settings().sets, percent);
  if (!n || study.tests.is_null(study.tests.tests[test], study.model.means)) return {};
  return *n;
}

ResultCell bound_cell(const PowerStudy& study, std::size_t test, const std::optional<int>& n) {
  if (!n || study.tests.is_null(study.tests.tests[test], study.model.means)) return {};
  return *n;
}

PowerJson json_count(const ResultCell& cell) {
  const int* n = std::get_if<int>(&cell);
  return n ? PowerJson(*n) : PowerJson(nullptr);
}

PowerJson json_number(const std::optional<double>& value) {
  return value ? PowerJson(*value) : PowerJson(nullptr);
}

PowerJson variances_json(const PowerVariances& variances) {
  return {{"u", variances.u}, {"w", variances.w}, {"e", variances.e}};
}

PowerJson settings_json(const PowerStudy& study) {
  const PowerRequest& request = study.request;
  PowerJson json;
  json["measure"] = request.measure;
  json["unit"] = outcome_text(study.measure->outcome).unit;
  json["effects_from"] = study.has_paper_effects ? "paper" : "--effect";
  for (std::size_t c = 0; c < study.model.means.size(); ++c) {
    json["effects"][study.model.design.condition_name(c)] = study.model.means[c];
  }
  json["error_sd"] = json_number(request.error_sd);
  json["share_u"] = json_number(request.share_u);
  json["share_w"] = json_number(request.share_w);
  for (const PaperScatter& scatter : study.paper_scatter) {
    json["paper_errors"].push_back({{"from", scatter.from},
                                    {"sd", scatter.sd},
                                    {"rounding_low", scatter.low},
                                    {"rounding_high", scatter.high}});
  }
  json["trials_of_condition"] = study.model.trials;
  json["participants"] = request.settings.participants;
  json["data_sets"] = request.settings.sets;
  json["seed"] = request.settings.seed;
  json["significance"] = kSignificance;
  return json;
}

PowerJson pilot_json(const PowerStudy& study) {
  if (!study.pilot) return nullptr;
  const PilotEstimate& pilot = *study.pilot;
  PowerJson json;
  json["file"] = study.request.pilot;
  json["following"] = study.request.following;
  json["participants"] = pilot.participants;
  json["left_out"] = pilot.left_out;
  json["trials"] = pilot.trials;
  json["missing"] = pilot.missing;
  json["trials_of_condition"] = pilot.m;
  json["mean_squares"] = {{"p", pilot.ms_p}, {"pc", pilot.ms_pc}, {"e", pilot.ms_e}};
  json["degrees_of_freedom"] = {{"p", pilot.df_p}, {"pc", pilot.df_pc}, {"e", pilot.df_e}};
  json["estimates"] = variances_json(pilot.raw);
  json["variances"] = variances_json(pilot.variances);
  for (std::size_t c = 0; c < pilot.means.size(); ++c) {
    json["means"][study.model.design.condition_name(c)] = pilot.means[c];
  }
  const PilotFit fit = pilot_fit(pilot, study.tests);
  json["fit"] = {{"f", fit.f}, {"p_below", fit.p_below}};
  for (const PilotPair& pair : fit.pairs) {
    json["fit"]["sd_of_differences"][pair.pair] = {{"pilot", pair.observed}, {"model", pair.model}};
  }
  return json;
}

// "0.8" for 80
std::string percent_name(int percent) {
  return "0." + std::to_string(percent / 10);
}

PowerJson test_json(const PowerStudy& study, std::size_t i, std::size_t t) {
  const PowerTest& test = study.tests.tests[t];
  PowerJson json;
  json["test"] = test.name;
  json["correction"] = correction_name(test);
  json["has_effect"] = !study.tests.is_null(test, study.model.means);
  for (const int percent : kPowerPercents) {
    const std::string name = percent_name(percent);
    const PeopleBounds bounds = people_bounds(study, i, t, percent);
    json["people"][name] = json_count(people_cell(study, i, t, percent));
    json["people_bounds"][name] = {json_count(bound_cell(study, t, bounds.low)),
                                   json_count(bound_cell(study, t, bounds.high))};
  }
  for (int n = 2; n <= study.settings().participants; ++n) {
    json["significant"].push_back(study.counts.at(i, t, n));
  }
  return json;
}

}  // namespace

ResultTable power_people_table(const PowerStudy& study) {
  ResultTable table{
      "needed_people",
      {"error_from", "error_sd", "share_u", "share_w", "test", "correction", "has_effect"},
      {}};
  for (const int percent : kPowerPercents) {
    table.columns.push_back("people_for_" + percent_name(percent));
  }
  for (const int percent : kPowerPercents) {
    table.columns.push_back("low_for_" + percent_name(percent));
    table.columns.push_back("high_for_" + percent_name(percent));
  }
  for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
    for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
      const PowerTest& test = study.tests.tests[t];
      auto row = assumption_cells(study, i);
      row.insert(row.end(), {test.name, correction_name(test),
                             study.tests.is_null(test, study.model.means) ? 0 : 1});
      for (const int percent : kPowerPercents) row.push_back(people_cell(study, i, t, percent));
      for (const int percent : kPowerPercents) {
        const PeopleBounds bounds = people_bounds(study, i, t, percent);
        row.push_back(bound_cell(study, t, bounds.low));
        row.push_back(bound_cell(study, t, bounds.high));
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

ResultTable power_curve_table(const PowerStudy& study) {
  ResultTable table{"power",
                    {"error_from", "error_sd", "share_u", "share_w", "test", "correction",
                     "participants", "data_sets", "significant", "power", "low", "high"},
                    {}};
  const int sets = study.settings().sets;
  for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
    for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
      for (int n = 2; n <= study.settings().participants; ++n) {
        const int count = study.counts.at(i, t, n);
        const Interval interval = wilson_interval(count, sets);
        auto row = assumption_cells(study, i);
        row.insert(row.end(), {study.tests.tests[t].name, correction_name(study.tests.tests[t]), n,
                               sets, count, as_printed(static_cast<double>(count) / sets),
                               six_digits(interval.low), six_digits(interval.high)});
        table.rows.push_back(std::move(row));
      }
    }
  }
  return table;
}

std::string power_json(const PowerStudy& study) {
  PowerJson json;
  json["settings"] = settings_json(study);
  json["pilot"] = pilot_json(study);
  json["notes"] = power_notes(study);
  for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
    const PowerAssumption& assumed = study.assumptions[i];
    PowerJson model;
    model["error_from"] = assumed.error_from;
    model["error_sd"] = assumed.error_sd;
    model["share_u"] = assumed.share_u;
    model["share_w"] = assumed.share_w;
    model["variances"] = variances_json(study.model.variances[i]);
    for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
      model["tests"].push_back(test_json(study, i, t));
    }
    json["assumptions"].push_back(std::move(model));
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace palpate
