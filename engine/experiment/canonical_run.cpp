#include "engine/experiment/canonical_run.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/experiment/canonical_report.h"
#include "engine/experiment/canonical_rows.h"
#include "engine/experiment/canonical_trial.h"
#include "engine/experiment/canonical_wall.h"
#include "engine/experiment/dealt_merge.h"
#include "engine/experiment/experiment_merge.h"
#include "engine/experiment/key_hash.h"
#include "engine/experiment/plan_device.h"
#include "engine/experiment/run_identity.h"
#include "engine/experiment/strict_json.h"
#include "engine/experiment/sweep_run.h"
#include "engine/experiment/trial.h"
#include "engine/experiment/trials_file.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

std::uint64_t canonical_noise_seed(std::uint64_t seed, int participant, const CanonicalCell& cell) {
  return KeyHash()
      .add("canonical noise")
      .add(seed)
      .add(static_cast<std::uint64_t>(participant))
      .add(cell.angle_deg)
      .add(kCanonicalMotionNames[static_cast<std::size_t>(cell.motion)])
      .add(kRotationNames[cell.rotates ? 1 : 0])
      .value();
}

Error canonical_device_error(const Error& error, const CanonicalPlan& plan) {
  Error of_plan = as_plan_error(error, "/device");
  of_plan.path = plan.path;
  return of_plan;
}

// The errors of run_canonical_trial(), which depend on the person and on nothing else of a trial.
std::optional<Error> check_canonical_trials(const CanonicalPlan& plan, const Scene& wall,
                                            const RunSetup& device) {
  for (const CanonicalCell& cell : plan.cells()) {
    const RunSetup setup = canonical_setup(device, cell.angle_deg, cell.rotates);
    if (auto error = check_setup(wall, setup)) return canonical_device_error(*error, plan);
  }
  for (int participant = 1; participant <= plan.participants; ++participant) {
    const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
    if (auto error = check_plant(plant_of(device, person, 0), device.dt_s)) {
      return canonical_device_error(*error, plan);
    }
  }
  return std::nullopt;
}

Result<std::optional<UnitRun>> run_canonical_participant(const CanonicalPlan& plan,
                                                         const Scene& wall, const RunSetup& device,
                                                         int participant, UnitTrials& trials) {
  const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
  CsvLines lines("");
  UnitRun run;
  for (const CanonicalCell& cell : plan.cells()) {
    if (const std::string* const finished = trials.next()) {
      run.rows += *finished;
      continue;
    }
    const auto outcome =
        run_canonical_trial(wall, device, plan.display_Hz, person,
                            {cell, canonical_noise_seed(plan.seed, participant, cell)});
    if (!outcome) return outcome.error();
    lines.clear();
    add_canonical_row(lines,
                      {participant, cell, outcome->along_over_into, outcome->share_within_30deg});
    run.rows += lines.text();
    run.ticks += outcome->ticks;
    run.loop_ns += outcome->loop_ns;
    const auto goes_on = trials.add(lines.text());
    if (!goes_on) return goes_on.error();
    if (!*goes_on) return std::optional<UnitRun>();
  }
  return std::optional<UnitRun>(std::move(run));
}

// All arguments must outlive the result.
DealtRun dealt_canonical(const CanonicalPlan& plan, const Scene& wall, const RunSetup& device) {
  const RunIdentity identity = identity_of(plan);
  DealtRun run;
  run.units = identity.dealt_units(canonical_columns());
  run.identity_json = identity.json();
  run.result_names = {kCanonicalFile, kColumnsFile, kCanonicalPage, kRunFile};
  run.trials = [&plan](int) { return std::uint64_t{plan.cells().size()}; };
  run.compute = [&](int participant, UnitTrials& trials) {
    return run_canonical_participant(plan, wall, device, participant, trials);
  };
  return run;
}

std::string canonical_run_json(const RunIdentity& identity, const MergedCanonical& merged) {
  nlohmann::ordered_json json{{"palpate_run", 1}};
  json.update(nlohmann::ordered_json::parse(identity.json()));
  json["trials"] = merged.trials;
  json["trials_without_result"] = merged.without_result;
  return json.dump(2) + "\n";
}

// The results of other kinds in the folder that those of a canonical run do not overwrite.
std::vector<std::string> other_results_in(const std::string& folder) {
  std::vector<std::string> names = experiment_results_in(folder);
  for (std::string& name : sweep_result_names_in(folder)) names.push_back(std::move(name));
  return names;
}

}  // namespace

Result<MergedCanonical> merge_canonical(const std::vector<std::string>& folders,
                                        const std::string& out_folder) {
  const auto joined = join_parts(folders, RunKind::kCanonical,
                                 [](const RunIdentity&) { return canonical_columns(); });
  if (!joined) return joined.error();
  const RunIdentity& identity = joined->identity;
  const std::string text = canonical_columns() + "\n" + joined->rows;
  const auto rows =
      parse_canonical_rows(text, (std::filesystem::path(out_folder) / kCanonicalFile).string());
  if (!rows) return rows.error();
  MergedCanonical merged{identity.units, rows->size(), 0, {}};
  for (const CanonicalRow& row : *rows) merged.without_result += row.share_within_30deg ? 0 : 1;
  const std::string page = canonical_report_html(
      *rows, {identity.plan_name, identity.seed, identity.units, identity.operator_name},
      merged.warnings);
  if (auto error = write_results(out_folder,
                                 {{kCanonicalFile, text},
                                  {kColumnsFile, canonical_columns_csv()},
                                  {kCanonicalPage, page},
                                  {kRunFile, canonical_run_json(identity, merged)}},
                                 other_results_in(out_folder))) {
    return *error;
  }
  return merged;
}

std::vector<std::string> canonical_results_in(const std::string& folder) {
  std::error_code failed;
  const auto path = std::filesystem::path(folder) / kCanonicalFile;
  if (!std::filesystem::is_regular_file(path, failed)) return {};
  return {kCanonicalFile, kCanonicalPage};
}

std::vector<std::string> experiment_results_in(const std::string& folder) {
  const OwnResultsScope own;
  const auto text = read_settings_text((std::filesystem::path(folder) / kRunFile).string());
  if (!text) return {};
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("palpate_run") || json.contains("kind")) return {};
  return {kTrialsFile};
}

Result<CanonicalRunOutcome> run_canonical(const CanonicalPlan& plan, const DealtSettings& settings,
                                          const std::function<void(const RunProgress&)>& progress,
                                          const StopFlag* stop) {
  const auto device = make_setup(plan.device);
  if (!device) return canonical_device_error(device.error(), plan);
  const auto wall = canonical_wall(plan.device.radius_m);
  if (!wall) return canonical_device_error(wall.error(), plan);
  if (auto error = check_canonical_trials(plan, *wall, *device)) return *error;
  auto done = run_dealt(dealt_canonical(plan, *wall, *device), settings, progress, stop);
  if (!done) return done.error();
  CanonicalRunOutcome outcome{std::move(*done), std::nullopt};
  if (settings.shard || !outcome.not_done.empty()) return outcome;
  auto merged = merge_canonical({settings.out_folder}, settings.out_folder);
  if (!merged) return merged.error();
  outcome.merged = std::move(*merged);
  return outcome;
}

}  // namespace palpate
