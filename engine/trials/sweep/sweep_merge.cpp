#include "engine/trials/sweep/sweep_merge.h"

#include <filesystem>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/sweep/sweep_rows.h"

namespace palpate {
namespace {

SweepCounts counts_of(const std::vector<SweepRow>& rows) {
  SweepCounts counts;
  std::set<int> points;
  for (const SweepRow& row : rows) {
    points.insert(row.point);
    counts.trials += static_cast<std::uint64_t>(row.trials);
    counts.done += static_cast<std::uint64_t>(row.done);
    counts.timeouts += static_cast<std::uint64_t>(row.timeouts);
    counts.faults += static_cast<std::uint64_t>(row.faults);
  }
  counts.points = static_cast<int>(points.size());
  return counts;
}

std::string sweep_run_json(const RunIdentity& identity, const SweepCounts& counts) {
  nlohmann::ordered_json json{{"palpate_run", 1}};
  json.update(nlohmann::ordered_json::parse(identity.json()));
  json["trials"] = counts.trials;
  json["status"] = {{"done", counts.done}, {"timeout", counts.timeouts}, {"fault", counts.faults}};
  return json.dump(2) + "\n";
}

}  // namespace

Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder) {
  const auto joined =
      join_parts(folders, RunKind::kSweep, [](const RunIdentity&) { return sweep_columns(); });
  if (!joined) return joined.error();
  const std::string text = sweep_columns() + "\n" + joined->rows;
  const auto rows =
      parse_sweep_rows(text, (std::filesystem::path(out_folder) / kSweepFile).string());
  if (!rows) return rows.error();
  const SweepCounts counts = counts_of(*rows);
  auto files = stage_results(out_folder, RunKind::kSweep,
                             {{kSweepFile, text},
                              {kColumnsFile, sweep_columns_csv()},
                              {kRunFile, sweep_run_json(joined->identity, counts)}});
  if (!files) return files.error();
  return MergedSweep{counts, std::move(*files)};
}

}  // namespace palpate
