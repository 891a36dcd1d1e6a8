#include "engine/trials/deal/experiment_merge.h"

#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/deal/run_identity.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string run_json(const RunIdentity& identity, const std::vector<TrialRow>& rows) {
  OrderedJson by_following = OrderedJson::object();
  for (const TrialRow& row : rows) {
    OrderedJson& counts = by_following[row.following];
    for (std::size_t i = 0; i < kSimulatedStatusCount; ++i) {
      OrderedJson& count = counts[std::string(kTrialStatusNames[i])];
      if (count.is_null()) count = 0;
    }
    OrderedJson& count =
        counts[std::string(kTrialStatusNames[static_cast<std::size_t>(row.status)])];
    count = count.get<std::uint64_t>() + 1;
  }
  OrderedJson json{{"palpate_run", 1}};
  json.update(OrderedJson::parse(identity.json()));
  json["trials"] = rows.size();
  json["status"] = by_following;
  return json.dump(2) + "\n";
}

}  // namespace

Result<MergedExperiment> merge_experiment(const std::vector<std::string>& folders,
                                          const std::string& out_folder) {
  const auto joined = join_parts(folders, RunKind::kExperiment, [](const RunIdentity& identity) {
    return trials_columns(identity.columns());
  });
  if (!joined) return joined.error();
  const RunIdentity& identity = joined->identity;
  const std::string trials = trials_columns(identity.columns()) + "\n" + joined->rows;
  const auto rows =
      parse_trials(trials, (std::filesystem::path(out_folder) / kTrialsFile).string());
  if (!rows) return rows.error();
  auto files = stage_results(out_folder, identity.kind,
                             {{kTrialsFile, trials},
                              {kColumnsFile, columns_csv(identity.columns())},
                              {kRunFile, run_json(identity, *rows)}});
  if (!files) return files.error();
  if (auto error = files->move_into_place()) return *error;
  MergedExperiment merged{identity.units, rows->size(), {}};
  for (const TrialRow& row : *rows) ++merged.by_status[static_cast<std::size_t>(row.status)];
  return merged;
}

}  // namespace palpate
