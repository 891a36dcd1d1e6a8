#include "engine/trials/canonical/canonical_merge.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/deal/dealt_merge.h"

namespace palpate {
namespace {

std::string canonical_run_json(const RunIdentity& identity, std::uint64_t trials,
                               std::uint64_t without_result) {
  nlohmann::ordered_json json{{"palpate_run", 1}};
  json.update(nlohmann::ordered_json::parse(identity.json()));
  json["trials"] = trials;
  json["trials_without_result"] = without_result;
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
  const auto without_result = static_cast<std::uint64_t>(std::count_if(
      rows->begin(), rows->end(), [](const CanonicalRow& row) { return !row.share_within_30deg; }));
  auto files =
      stage_results(out_folder, identity.kind,
                    {{kCanonicalFile, text},
                     {kColumnsFile, canonical_columns_csv()},
                     {kRunFile, canonical_run_json(identity, rows->size(), without_result)}});
  if (!files) return files.error();
  return MergedCanonical{identity.units, rows->size(), without_result, std::move(*files)};
}

}  // namespace palpate
