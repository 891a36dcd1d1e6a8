#include "engine/trials/deal/result_names.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/strict_json.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::array kAllKinds = {RunKind::kExperiment, RunKind::kCanonical, RunKind::kSweep};

// Whether the run.json of the folder states a run of this kind.
bool states_run(const std::string& folder, RunKind kind) {
  const OwnResultsScope own;
  const auto text = read_settings_text((fs::path(folder) / kRunFile).string());
  if (!text) return false;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("palpate_run")) return false;
  const std::string_view name = words_of(kind).name;
  return name.empty() ? !json.contains("kind") : json.contains("kind") && json["kind"] == name;
}

bool has_results(const std::string& folder, RunKind kind) {
  std::error_code failed;
  return kind == RunKind::kCanonical
             ? fs::is_regular_file(fs::path(folder) / kCanonicalFile, failed)
             : states_run(folder, kind);
}

}  // namespace

std::vector<std::string> page_names(RunKind kind) {
  if (kind == RunKind::kExperiment) return {};
  if (kind == RunKind::kCanonical) return {kCanonicalPage};
  std::vector<std::string> names{kSweepPage, kSweepJson};
  for (const std::string_view name : kSweepTableNames) names.push_back(std::string(name) + ".csv");
  return names;
}

std::vector<std::string> result_names(RunKind kind) {
  constexpr std::array kRowFiles = {kTrialsFile, kCanonicalFile, kSweepFile};
  std::vector<std::string> names{kRowFiles[static_cast<std::size_t>(kind)], kColumnsFile};
  for (std::string& name : page_names(kind)) names.push_back(std::move(name));
  names.emplace_back(kRunFile);
  return names;
}

std::vector<std::string> results_in(const std::string& folder, RunKind kind) {
  if (!has_results(folder, kind)) return {};
  std::vector<std::string> names = result_names(kind);
  std::erase(names, kRunFile);
  return names;
}

std::vector<std::string> results_of_other_kinds_in(const std::string& folder, RunKind kind) {
  const std::vector<std::string> own = result_names(kind);
  std::vector<std::string> others;
  for (const RunKind other : kAllKinds) {
    if (other == kind) continue;
    for (std::string& name : results_in(folder, other)) {
      const bool is_known = std::find(own.begin(), own.end(), name) != own.end() ||
                            std::find(others.begin(), others.end(), name) != others.end();
      if (!is_known) others.push_back(std::move(name));
    }
  }
  return others;
}

}  // namespace palpate
