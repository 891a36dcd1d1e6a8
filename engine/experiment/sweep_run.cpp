#include "engine/experiment/sweep_run.h"

#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/experiment/canonical_run.h"
#include "engine/experiment/dealt_merge.h"
#include "engine/experiment/experiment_merge.h"
#include "engine/experiment/key_hash.h"
#include "engine/experiment/participant_run.h"
#include "engine/experiment/run_identity.h"
#include "engine/experiment/strict_json.h"
#include "engine/experiment/sweep_analysis.h"
#include "engine/experiment/sweep_report.h"
#include "engine/experiment/sweep_rows.h"
#include "engine/experiment/sweep_scenes.h"
#include "engine/experiment/trials_file.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The hash of a scene's geometry covers all scales.
RunIdentity identity_of_sweep(const Sweep& sweep, const SweepScenes& scenes, std::size_t points) {
  RunIdentity identity = identity_of(sweep.plan, scenes.begin()->second);
  identity.kind = RunKind::kSweep;
  identity.plan_name = sweep.name;
  identity.plan = sweep.hash;
  identity.units = static_cast<int>(points);
  for (auto scale = std::next(scenes.begin()); scale != scenes.end(); ++scale) {
    for (std::size_t i = 0; i < identity.scenes.size(); ++i) {
      std::uint64_t& geometry = identity.scenes[i].geometry;
      geometry = KeyHash().add(geometry).add(scale->second[i].geometry_hash).value();
    }
  }
  return identity;
}

Result<std::optional<UnitRun>> run_point(const Sweep& sweep, int number, const SweepPoint& point,
                                         const SweepScenes& scenes, const TrialFunctions& functions,
                                         UnitTrials& trials) {
  const ExperimentPlan plan = plan_at(sweep, point);
  const TrialFunctions with_device = with_device_of(plan, functions);
  UnitRun run;
  std::string table = trials_columns() + "\n";
  for (int participant = 1; participant <= plan.participants; ++participant) {
    const auto done = run_participant(plan, scenes.at(*point.values[kScale]), with_device,
                                      participant, "", trials);
    if (!done) return done.error();
    if (!*done) return std::optional<UnitRun>();
    table += (*done)->rows;
    run.ticks += (*done)->ticks;
    run.loop_ns += (*done)->loop_ns;
  }
  const auto rows = parse_trials(table, kTrialsFile);
  if (!rows) return rows.error();
  CsvLines lines("");
  lines.clear();
  for (const SweepRow& row : sweep_rows(number, point, *rows, plan.trial.limit_s))
    add_sweep_row(lines, row);
  run.rows = lines.text();
  return std::optional<UnitRun>(std::move(run));
}

// All arguments but the identity must outlive the result.
DealtRun dealt_sweep(const Sweep& sweep, const std::vector<SweepPoint>& points,
                     const SweepScenes& scenes, const TrialFunctions& functions) {
  const RunIdentity identity = identity_of_sweep(sweep, scenes, points.size());
  const auto point_of = [&points](int number) -> const SweepPoint& {
    return points[static_cast<std::size_t>(number) - 1];
  };
  DealtRun run;
  run.units = identity.dealt_units(sweep_columns());
  run.identity_json = identity.json();
  run.result_names = sweep_result_names();
  run.trials = [&sweep, point_of](int number) {
    return static_cast<std::uint64_t>(point_of(number).participants) *
           sweep.plan.trials_per_participant();
  };
  run.compute = [&, point_of](int number, UnitTrials& trials) {
    return run_point(sweep, number, point_of(number), scenes, functions, trials);
  };
  return run;
}

// The results of other kinds in the folder that those of a sweep do not overwrite.
std::vector<std::string> results_of_other_kinds_in(const std::string& folder) {
  std::vector<std::string> names = experiment_results_in(folder);
  for (std::string& name : canonical_results_in(folder)) names.push_back(std::move(name));
  if (!names.empty()) names.emplace_back(kColumnsFile);
  return names;
}

MergedSweep counts_of(const SweepAnalysis& analysis) {
  MergedSweep merged;
  merged.points = static_cast<int>(analysis.points.size());
  for (const SweepRow& row : analysis.rows) {
    merged.trials += static_cast<std::uint64_t>(row.trials);
    merged.done += static_cast<std::uint64_t>(row.done);
    merged.timeouts += static_cast<std::uint64_t>(row.timeouts);
    merged.faults += static_cast<std::uint64_t>(row.faults);
  }
  return merged;
}

std::string sweep_run_json(const RunIdentity& identity, const MergedSweep& merged) {
  nlohmann::ordered_json json{{"palpate_run", 1}};
  json.update(nlohmann::ordered_json::parse(identity.json()));
  json["trials"] = merged.trials;
  json["status"] = {{"done", merged.done}, {"timeout", merged.timeouts}, {"fault", merged.faults}};
  return json.dump(2) + "\n";
}

}  // namespace

Result<SweepOutcome> run_sweep(const Sweep& sweep, const DealtSettings& settings,
                               const TrialFunctions& functions,
                               const std::function<void(const RunProgress&)>& progress,
                               const StopFlag* stop) {
  const std::vector<SweepPoint> points = sweep_points(sweep);
  const auto scenes = load_sweep_scenes(sweep, points, functions);
  if (!scenes) return scenes.error();
  auto done = run_dealt(dealt_sweep(sweep, points, *scenes, functions), settings, progress, stop);
  if (!done) return done.error();
  SweepOutcome outcome{std::move(*done), std::nullopt,
                       scene_warnings(sweep.plan, scenes->begin()->second)};
  if (settings.shard || !outcome.not_done.empty()) return outcome;
  auto merged = merge_sweep({settings.out_folder}, settings.out_folder);
  if (!merged) return merged.error();
  outcome.merged = std::move(*merged);
  return outcome;
}

std::vector<std::string> sweep_result_names_in(const std::string& folder) {
  const OwnResultsScope own;
  const auto text = read_settings_text((fs::path(folder) / kRunFile).string());
  if (!text) return {};
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const bool is_run = json.is_object() && json.contains("palpate_run") && json.contains("kind");
  if (!is_run || json["kind"] != "sweep") return {};
  std::vector<std::string> names = sweep_result_names();
  std::erase(names, kRunFile);
  return names;
}

Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder) {
  const auto joined =
      join_parts(folders, RunKind::kSweep, [](const RunIdentity&) { return sweep_columns(); });
  if (!joined) return joined.error();
  const std::string text = sweep_columns() + "\n" + joined->rows;
  auto rows = parse_sweep_rows(text, (fs::path(out_folder) / kSweepFile).string());
  if (!rows) return rows.error();
  const SweepAnalysis analysis = analyse_sweep(std::move(*rows));
  MergedSweep merged = counts_of(analysis);
  merged.text = sweep_text(analysis);
  if (merged.done == 0) {
    merged.warnings.emplace_back(
        "no trial ended at the red sphere, so that no ranking is testable");
  }
  std::vector<std::pair<std::string, std::string>> texts{{kSweepFile, text}};
  for (auto& file : sweep_report(analysis, joined->identity, merged.warnings)) {
    texts.push_back(std::move(file));
  }
  texts.emplace_back(kRunFile, sweep_run_json(joined->identity, merged));
  const auto obsolete = results_of_other_kinds_in(out_folder);
  if (auto error = write_results(out_folder, texts, obsolete)) return *error;
  return merged;
}

}  // namespace palpate
