#include "engine/analysis/compare_results.h"

#include <filesystem>
#include <utility>

#include "engine/trials/compare/compare_run.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

ComparedStrategies compared_strategies(const CompareSettings& settings,
                                       const ExperimentPlan& plan) {
  ComparedStrategies compared;
  for (const Strategy& strategy : settings.strategies) {
    compared.strategies.push_back(name_of(strategy));
  }
  for (const Strategy& level : settings.is_tuned ? tuned_levels() : std::vector<Strategy>{}) {
    compared.levels.push_back(name_of(level));
  }
  for (const PlanObject& object : plan.objects) compared.scenes.push_back(object.name);
  return compared;
}

Result<std::vector<TrialRow>> trial_rows_in(const std::string& folder, CompareHands hands) {
  const OwnResultsScope own;
  return read_trials(
      (std::filesystem::path(compare_trials_folder(folder, hands)) / kTrialsFile).string());
}

}  // namespace

Result<std::vector<FollowingComparison>> compare_results(const CompareSettings& settings,
                                                         const std::string& folder) {
  const auto plan = compare_plan(settings, CompareHands::kCompared);
  if (!plan) return plan.error();
  const auto rows = trial_rows_in(folder, CompareHands::kCompared);
  if (!rows) return rows.error();
  std::vector<TrialRow> tuning_rows;
  if (settings.is_tuned) {
    auto read = trial_rows_in(folder, CompareHands::kTuning);
    if (!read) return read.error();
    tuning_rows = std::move(*read);
  }
  const ComparedStrategies compared = compared_strategies(settings, *plan);
  std::vector<FollowingComparison> followings;
  for (const Following following : plan->followings) {
    const std::string name(kFollowingNames[static_cast<std::size_t>(following)]);
    followings.push_back(compare_strategies(*rows, tuning_rows, compared, name));
  }
  return followings;
}

}  // namespace palpate
