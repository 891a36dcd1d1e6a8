#pragma once

// The results of one participant, kept until all participants are complete: one file per
// participant in the folder `parts` of an experiment.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/experiment/trials_file.h"
#include "geometry/base/result.h"

namespace palpate {

// Paths in the folder of an experiment.
std::string parts_folder(const std::string& folder);
std::string part_identity_path(const std::string& folder);  // RunIdentity::json() of the run
std::string part_path(const std::string& folder, int participant);

// The participants that have a file in the folder, in ascending order.
std::vector<int> participants_with_parts(const std::string& folder);

// Writes the part, whole or not at all. rows: the lines of trials.csv without the line of names.
// run: RunIdentity::hash(). columns: of the rows.
std::optional<Error> write_part(const std::string& path, std::uint64_t run, int participant,
                                std::string_view rows,
                                TrialColumns columns = TrialColumns::kFactors);

// The rows of a part. Errors: the file is not a part, the part belongs to another run or
// participant, or its rows do not have the hash that its first line states.
Result<std::string> read_part(const std::string& path, std::uint64_t run, int participant,
                              TrialColumns columns = TrialColumns::kFactors);

}  // namespace palpate
