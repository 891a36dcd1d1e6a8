#include "engine/analysis/strategy_tables.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/plan_device.h"

namespace palpate {
namespace {

using StrategyRow = std::vector<ResultCell>;

const std::vector<std::string> kOutcomeColumns = {"following", "strategy", "role",  "trials",
                                                  "done",      "timeouts", "faults"};
const std::vector<std::string> kStrategyMeanColumns = {
    "following",  "scene",           "measure",    "column",   "unit",          "better",
    "strategy",   "tuned_to",        "role",       "hands",    "mean",          "half_width",
    "minus_mask", "mask_half_width", "mask_hands", "minus_a4", "a4_half_width", "a4_hands",
    "standing"};
const std::vector<std::string> kLossColumns = {"following", "measure",  "unit",      "strategy",
                                               "role",      "minus_a4", "half_width"};
const std::vector<std::string> kTuningColumns = {
    "following", "scene", "measure", "unit", "strategy", "hands", "mean", "half_width", "chosen"};

std::string view_cell(std::string_view text) {
  return std::string(text);
}

std::string role_name(StrategyRole role) {
  return std::string(kStrategyRoleNames[static_cast<std::size_t>(role)]);
}

void put_outcomes(const FollowingComparison& following, ResultTable& table) {
  for (const StrategyOutcome& outcome : following.outcomes) {
    const StrategyCounts& counts = outcome.counts;
    table.rows.push_back({following.following, outcome.strategy, role_name(outcome.role),
                          counts.trials, counts.done, counts.timeouts, counts.faults});
  }
}

void add_difference(StrategyRow& row, const std::optional<MeanInterval>& difference) {
  if (difference) {
    row.insert(row.end(), {difference->mean, difference->half_width, difference->count});
  } else {
    row.resize(row.size() + 3);
  }
}

StrategyRow strategy_mean_row(const std::string& following, const std::string& scene,
                              const ComparedMeasure& measure, const StrategyEntry& entry) {
  StrategyRow row = {following,
                     scene,
                     view_cell(measure.name),
                     view_cell(measure.column),
                     view_cell(measure.unit),
                     measure.better == Better::kLower ? "lower" : "nearer to 0",
                     entry.strategy,
                     entry.tuned_to,
                     role_name(entry.role),
                     entry.mean.count,
                     entry.mean.mean,
                     entry.mean.half_width};
  add_difference(row, entry.minus_mask);
  add_difference(row, entry.minus_a4);
  row.emplace_back(view_cell(kStandingNames[static_cast<std::size_t>(entry.standing)]));
  return row;
}

void put_strategy_means(const FollowingComparison& following, ResultTable& table) {
  for (const SceneComparison& scene : following.scenes) {
    for (const MeasureComparison& comparison : scene.measures) {
      for (const StrategyEntry& entry : comparison.entries) {
        table.rows.push_back(
            strategy_mean_row(following.following, scene.scene, *comparison.measure, entry));
      }
    }
  }
}

void put_losses(const FollowingComparison& following, ResultTable& table) {
  for (const A4Loss& loss : following.a4_losses()) {
    table.rows.push_back({following.following, view_cell(loss.measure->name),
                          view_cell(loss.measure->unit), loss.better->strategy,
                          role_name(loss.better->role), loss.better->minus_a4->mean,
                          loss.better->minus_a4->half_width});
  }
}

void put_tuning(const FollowingComparison& following, ResultTable& table) {
  for (const TuningEntry& entry : following.tuning) {
    table.rows.push_back({following.following, entry.scene, view_cell(entry.measure->name),
                          view_cell(entry.measure->unit), entry.strategy, entry.mean.count,
                          entry.mean.mean, entry.mean.half_width, entry.is_chosen ? 1 : 0});
  }
}

}  // namespace

std::vector<ResultTable> strategy_tables(const std::vector<FollowingComparison>& followings) {
  std::vector<ResultTable> tables;
  for (const auto* columns :
       {&kOutcomeColumns, &kStrategyMeanColumns, &kLossColumns, &kTuningColumns}) {
    tables.push_back({std::string(kStrategyTableNames[tables.size()]), *columns, {}});
  }
  for (const FollowingComparison& following : followings) {
    put_outcomes(following, tables[0]);
    put_strategy_means(following, tables[1]);
    put_losses(following, tables[2]);
    put_tuning(following, tables[3]);
  }
  return tables;
}

std::string comparison_json(const CompareSettings& settings,
                            const std::vector<FollowingComparison>& followings) {
  nlohmann::ordered_json head = {{"palpate_comparison", 1},
                                 {"scenes", settings.scenes},
                                 {"operator", settings.person},
                                 {"hands", settings.hands},
                                 {"seed", settings.seed}};
  if (settings.is_tuned) {
    head["tuning_seed"] = compare_seed(settings.seed, CompareHands::kTuning);
  }
  head["device"] = plan_device_json(settings.device);
  head["comparable"] = nlohmann::ordered_json::object();
  for (const FollowingComparison& following : followings) {
    head["comparable"][following.following] = following.incomplete().empty();
  }
  std::string text = "{";
  for (const auto& [key, value] : head.items()) {
    text += (text.size() == 1 ? "\"" : ",\n \"") + key +
            "\": " + value.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  }
  for (const ResultTable& table : strategy_tables(followings)) {
    text += ",\n \"" + table.name + "\": " + json_rows_of(table, 1);
  }
  return text + "}\n";
}

}  // namespace palpate
