#include "engine/analysis/canonical_merge.h"

#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/analysis/canonical_report.h"
#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/deal/dealt_merge.h"

namespace palpate {
namespace {

std::string canonical_run_json(const RunIdentity& identity, const MergedCanonical& merged) {
  nlohmann::ordered_json json{{"palpate_run", 1}};
  json.update(nlohmann::ordered_json::parse(identity.json()));
  json["trials"] = merged.trials;
  json["trials_without_result"] = merged.without_result;
  return json.dump(2) + "\n";
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
                                 results_of_other_kinds_in(out_folder, identity.kind))) {
    return *error;
  }
  return merged;
}

}  // namespace palpate
