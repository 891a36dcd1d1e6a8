#include "engine/trials/compare/compare_means.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <span>
#include <sstream>
#include <string_view>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/devices/light_device.h"
#include "engine/report/csv.h"
#include "engine/trials/compare/compare_run.h"
#include "engine/trials/compare/compared_measures.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/plan_device.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMmPerM = 1e3;

std::size_t place_in(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

struct RunningMean {
  double sum = 0.0;
  int count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  double mean() const { return sum / count; }
};

// The trials of one strategy, in the order of hands, scenes and blocks, so that a sum does not
// depend on the order of the file.
std::vector<const TrialRow*> trials_of(const std::vector<TrialRow>& rows,
                                       const std::string& following, const std::string& strategy) {
  std::vector<const TrialRow*> found;
  for (const TrialRow& row : rows) {
    if (row.following == following && row.block > 0 && row.strategy == strategy) {
      found.push_back(&row);
    }
  }
  const auto key = [](const TrialRow* row) {  // hand "2" before "10"
    return std::tuple(row->participant.size(), std::string_view(row->participant),
                      std::string_view(row->object), row->block);
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const TrialRow* a, const TrialRow* b) { return key(a) < key(b); });
  return found;
}

StrategyCounts counts_of(const std::vector<const TrialRow*>& trials, double workspace_m) {
  StrategyCounts counts;
  for (const TrialRow* trial : trials) {
    ++counts.trials;
    if (trial->status == TrialStatus::kDone) ++counts.done;
    if (trial->status == TrialStatus::kTimeout) ++counts.timeouts;
    if (trial->status == TrialStatus::kFault) ++counts.faults;
    const std::optional<double>& travel_m = trial->measures[kDeviceTravel];
    if (!travel_m) continue;
    counts.largest_travel_m = std::max(counts.largest_travel_m.value_or(0.0), *travel_m);
    if (exceeds_workspace(*travel_m, workspace_m)) ++counts.beyond_workspace;
  }
  return counts;
}

// scene: empty for all scenes together.
HandMean mean_over_hands(const std::vector<const TrialRow*>& trials, const std::string& scene,
                         const ComparedMeasure& measure) {
  RunningMean of_all, of_hand;
  const auto end_hand = [&] {
    if (of_hand.count > 0) of_all.add(of_hand.mean());
    of_hand = {};
  };
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (i > 0 && trials[i]->participant != trials[i - 1]->participant) end_hand();
    if (!scene.empty() && trials[i]->object != scene) continue;
    if (const auto value = compared_value(measure, *trials[i])) of_hand.add(*value);
  }
  end_hand();
  return {of_all.count,
          of_all.count > 0 ? of_all.mean() : std::numeric_limits<double>::quiet_NaN()};
}

std::string role_of(const std::string& strategy) {
  return strategy == "none" || strategy == "full" ? "reference" : "technique";
}

const char* better_text(const ComparedMeasure& measure) {
  return measure.better == Better::kLower ? "lower" : "nearer to 0";
}

// A row for each strategy, or for each mean: the columns are the keys.
std::vector<Json> strategy_rows(const std::vector<StrategyMeans>& followings) {
  std::vector<Json> rows;
  for (const StrategyMeans& of : followings) {
    for (std::size_t i = 0; i < of.strategies.size(); ++i) {
      const StrategyCounts& counts = of.counts[i];
      rows.push_back({{"following", of.following},
                      {"strategy", of.strategies[i]},
                      {"role", role_of(of.strategies[i])},
                      {"trials", counts.trials},
                      {"done", counts.done},
                      {"timeouts", counts.timeouts},
                      {"faults", counts.faults},
                      {"beyond_workspace", counts.beyond_workspace},
                      {"largest_travel_m",
                       counts.largest_travel_m ? Json(*counts.largest_travel_m) : Json()}});
    }
  }
  return rows;
}

std::vector<Json> mean_rows(const std::vector<StrategyMeans>& followings) {
  const std::span<const ComparedMeasure> measures = compared_measures();
  std::vector<Json> rows;
  for (const StrategyMeans& of : followings) {
    const HandMean* mean = of.means.data();
    for (const std::string& scene : of.scenes) {
      for (const ComparedMeasure& measure : measures) {
        for (const std::string& strategy : of.strategies) {
          rows.push_back({{"following", of.following},
                          {"scene", scene},
                          {"measure", measure.name},
                          {"column", measure.column},
                          {"unit", measure.unit},
                          {"better", better_text(measure)},
                          {"strategy", strategy},
                          {"role", role_of(strategy)},
                          {"hands", mean->hands},
                          {"mean", mean->hands > 0 ? Json(mean->mean) : Json()}});
          ++mean;
        }
      }
    }
  }
  return rows;
}

std::string csv_of(const std::vector<Json>& rows) {
  std::string columns;
  for (const auto& [key, cell] : rows.front().items()) {
    columns += (columns.empty() ? "" : ",") + key;
  }
  CsvLines lines(columns);
  for (const Json& row : rows) {
    for (const Json& cell : row) {
      if (cell.is_string()) {
        lines.add(cell.get_ref<const std::string&>());
      } else if (cell.is_number_integer()) {
        lines.add(cell.get<int>());
      } else if (cell.is_number()) {
        lines.add(cell.get<double>());
      } else {
        lines.skip(1);
      }
    }
    lines.end_line();
  }
  return lines.text();
}

std::string padded_left(std::string text, std::size_t columns) {
  if (text.size() < columns) text.insert(0, columns - text.size(), ' ');
  return text;
}

std::string padded_right(std::string text, std::size_t columns) {
  text.resize(std::max(columns, text.size()), ' ');
  return text;
}

std::string with_decimals(double value, int decimals) {
  std::array<char, 400> text;  // the largest double has 309 digits before the point
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  std::string number(text.data(), end.ptr);
  const bool is_zero = number.find_first_of("123456789") == std::string::npos;
  return is_zero && number.front() == '-' ? number.substr(1) : number;
}

// The decimals that show a number, of which this is the largest, with three digits.
int decimals_for(double largest) {
  return largest > 0.0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(largest))), 0, 4)
                       : 0;
}

// The means of one measure with three digits of the largest, in the shown unit; "!" after those of
// strategies that left the workspace.
std::string measure_line(const StrategyMeans& means, std::size_t place, std::size_t columns,
                         const std::vector<std::size_t>& widths) {
  const ComparedMeasure& measure = compared_measures()[place];
  double largest = 0.0;
  for (std::size_t i = 0; i < means.strategies.size(); ++i) {
    const HandMean& mean = means.mean(0, place, i);
    if (mean.hands > 0) largest = std::max(largest, std::abs(mean.mean) * measure.shown_per_unit);
  }
  const int decimals = decimals_for(largest);
  std::string heading(measure.name);
  if (!measure.shown_unit.empty()) heading += ", " + std::string(measure.shown_unit);
  std::string line = padded_right(heading, columns);
  for (std::size_t i = 0; i < means.strategies.size(); ++i) {
    const HandMean& mean = means.mean(0, place, i);
    std::string number =
        mean.hands == 0 ? "-" : with_decimals(mean.mean * measure.shown_per_unit, decimals);
    if (measure.name == kTravelMeasure && means.counts[i].beyond_workspace > 0) number += " !";
    line += padded_left(number, widths[i]);
  }
  return line + "\n";
}

// A line for each strategy that left the workspace: in how many trials, and by how much.
std::string workspace_lines(const StrategyMeans& means) {
  std::ostringstream text;
  for (std::size_t i = 0; i < means.strategies.size(); ++i) {
    const StrategyCounts& counts = means.counts[i];
    if (counts.beyond_workspace == 0) continue;
    const double beyond_mm = kMmPerM * (*counts.largest_travel_m - means.workspace_m);
    text << "! beyond the workspace of " << kMmPerM * means.workspace_m
         << " mm: " << means.strategies[i] << " in " << counts.beyond_workspace << " of "
         << counts.trials << " trials, by up to "
         << with_decimals(beyond_mm, decimals_for(beyond_mm)) << " mm\n";
  }
  return text.str();
}

}  // namespace

const HandMean& StrategyMeans::mean(std::size_t scene, std::size_t measure,
                                    std::size_t strategy) const {
  return means[(scene * compared_measures().size() + measure) * strategies.size() + strategy];
}

std::vector<std::string> StrategyMeans::incomplete() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < strategies.size(); ++i) {
    if (!counts[i].is_comparable()) names.push_back(strategies[i]);
  }
  return names;
}

StrategyMeans strategy_means(const std::vector<TrialRow>& rows, const std::string& following,
                             const std::vector<std::string>& strategies,
                             const std::vector<std::string>& scenes, double workspace_m) {
  StrategyMeans found{following, 0, workspace_m, strategies, {}, {""}, {}};
  if (scenes.size() > 1) found.scenes.insert(found.scenes.end(), scenes.begin(), scenes.end());
  std::vector<std::vector<const TrialRow*>> trials;
  std::set<std::string> hands;
  for (const std::string& strategy : strategies) {
    trials.push_back(trials_of(rows, following, strategy));
    found.counts.push_back(counts_of(trials.back(), workspace_m));
    for (const TrialRow* trial : trials.back()) hands.insert(trial->participant);
  }
  found.hands = static_cast<int>(hands.size());
  for (const std::string& scene : found.scenes) {
    for (const ComparedMeasure& measure : compared_measures()) {
      for (const auto& of_strategy : trials) {
        found.means.push_back(mean_over_hands(of_strategy, scene, measure));
      }
    }
  }
  return found;
}

Result<std::vector<StrategyMeans>> compare_means(const CompareSettings& settings,
                                                 const std::string& folder) {
  const auto plan = compare_plan(settings);
  if (!plan) return plan.error();
  const OwnResultsScope own;
  const auto rows =
      read_trials((std::filesystem::path(compare_trials_folder(folder)) / kTrialsFile).string());
  if (!rows) return rows.error();
  std::vector<std::string> strategies, scenes;
  for (const Strategy& strategy : settings.strategies) strategies.push_back(name_of(strategy));
  for (const PlanObject& object : plan->objects) scenes.push_back(object.name);
  std::vector<StrategyMeans> followings;
  for (const Following following : plan->followings) {
    const std::string name(kFollowingNames[static_cast<std::size_t>(following)]);
    followings.push_back(strategy_means(*rows, name, strategies, scenes,
                                        workspace_extent_m(settings.device.device)));
  }
  return followings;
}

std::string means_csv(const std::vector<StrategyMeans>& followings) {
  return csv_of(mean_rows(followings));
}

std::string strategies_csv(const std::vector<StrategyMeans>& followings) {
  return csv_of(strategy_rows(followings));
}

std::string means_text(const StrategyMeans& means) {
  constexpr std::size_t kHeadingColumns = 26, kLeastColumns = 9, kGap = 2;
  std::string text =
      padded_right("mean over " + std::to_string(means.hands) + " hands", kHeadingColumns);
  std::string settings(kHeadingColumns, ' ');  // ":0.25" is on a line of its own
  std::vector<std::size_t> widths;
  for (const std::string& strategy : means.strategies) {
    const std::size_t colon = std::min(strategy.find(':'), strategy.size());
    widths.push_back(std::max(kLeastColumns, std::max(colon, strategy.size() - colon) + kGap));
    text += padded_left(strategy.substr(0, colon), widths.back());
    settings += padded_left(strategy.substr(colon), widths.back());
  }
  text += "\n";
  const std::size_t last = settings.find_last_not_of(' ');
  if (last != std::string::npos) text += settings.substr(0, last + 1) + "\n";
  for (std::size_t measure = 0; measure < compared_measures().size(); ++measure) {
    text += measure_line(means, measure, kHeadingColumns, widths);
  }
  text += workspace_lines(means);
  for (const std::string& name : means.incomplete()) {
    const StrategyCounts& counts = means.counts[place_in(means.strategies, name)];
    text += "not comparable: " + std::to_string(counts.done) + " of " +
            std::to_string(counts.trials) + " trials of " + name +
            " ended at the red sphere; expected 90 %\n";
  }
  return text;
}

Json means_json(const CompareSettings& settings, const std::vector<StrategyMeans>& followings) {
  Json comparable = Json::object();
  for (const StrategyMeans& of : followings) comparable[of.following] = of.incomplete().empty();
  return {{"palpate_comparison", 1},       {"scenes", settings.scenes},
          {"operator", settings.person},   {"hands", settings.hands},
          {"seed", settings.seed},         {"device", plan_device_json(settings.device)},
          {"comparable", comparable},      {"strategies", strategy_rows(followings)},
          {"means", mean_rows(followings)}};
}

}  // namespace palpate
