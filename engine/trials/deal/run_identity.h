#pragma once

// The identity of the results of a run: two runs with the same identity have the same rows.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/deal/result_names.h"
#include "engine/trials/deal/unit_part.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/result.h"

namespace palpate {

struct RunIdentity {
  struct SceneHashes {
    std::string name;  // of the object
    std::uint64_t file = 0;
    std::uint64_t geometry = 0;
  };

  RunKind kind = RunKind::kExperiment;
  std::string version;  // of Palpate
  std::string plan_name;
  std::uint64_t plan = 0;  // hash
  std::uint64_t seed = 0;
  int units = 0;  // participants, or what the kind has in their place
  std::string operator_name;
  int operator_version = 0;
  std::uint64_t operator_file = 0;      // hash
  std::vector<SceneHashes> scenes;      // in the order of the plan
  std::vector<std::string> strategies;  // names; empty: a plan with haptic and rotation

  TrialColumns columns() const {
    return strategies.empty() ? TrialColumns::kFactors : TrialColumns::kStrategies;
  }

  // What the parts of the run share. columns: the names of the columns of their rows.
  DealtUnits dealt_units(std::string columns) const;
  // The KeyHash of all of the above.
  std::uint64_t hash() const;
  // As a JSON object with a line end.
  std::string json() const;
};

std::string version_of_palpate();

// The identity of a run of a plan of persons, without scenes and strategies.
template <typename Plan>
RunIdentity identity_of_persons(RunKind kind, const Plan& plan) {
  RunIdentity identity;
  identity.kind = kind;
  identity.version = version_of_palpate();
  identity.plan_name = plan.name;
  identity.plan = plan.hash;
  identity.seed = plan.seed;
  identity.units = plan.participants;
  identity.operator_name = plan.person.name;
  identity.operator_version = plan.person.version;
  identity.operator_file = plan.person.hash;
  return identity;
}

RunIdentity identity_of(const ExperimentPlan& plan, const std::vector<ExperimentScene>& scenes);

// Reads the text of json(). path: for messages.
Result<RunIdentity> parse_identity(const std::string& text, const std::string& path);

// No value if the identities are equal. Otherwise the first difference, as an error: its element is
// the JSON path in json(), and its path is empty. other_path: the path of the file of `other`, for
// the message.
std::optional<Error> find_difference(const RunIdentity& identity, const RunIdentity& other,
                                     const std::string& other_path);

}  // namespace palpate
