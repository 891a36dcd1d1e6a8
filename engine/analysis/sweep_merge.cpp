#include "engine/analysis/sweep_merge.h"

#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/analysis/sweep_analysis.h"
#include "engine/analysis/sweep_report.h"
#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/sweep/sweep_rows.h"

namespace palpate {
namespace {

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

Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder) {
  const auto joined =
      join_parts(folders, RunKind::kSweep, [](const RunIdentity&) { return sweep_columns(); });
  if (!joined) return joined.error();
  const std::string text = sweep_columns() + "\n" + joined->rows;
  auto rows = parse_sweep_rows(text, (std::filesystem::path(out_folder) / kSweepFile).string());
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
  const auto obsolete = results_of_other_kinds_in(out_folder, joined->identity.kind);
  if (auto error = write_results(out_folder, texts, obsolete)) return *error;
  return merged;
}

}  // namespace palpate
