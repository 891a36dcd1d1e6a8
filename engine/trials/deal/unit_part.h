#pragma once

// The rows of one unit of a dealt run (dealt_run.h), such as a participant, kept until all units
// are complete: one file per unit in the folder `parts` of the run.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// What all parts of one run share.
struct DealtUnits {
  std::string noun;            // of a unit: "participant"
  int count = 0;               // units are numbered from 1
  std::uint64_t identity = 0;  // RunIdentity::hash() of the run
  std::string columns;         // the names of the columns of the rows, as in the results
};

// Paths in the folder of a run.
std::string parts_folder(const std::string& folder);
std::string part_identity_path(const std::string& folder);  // RunIdentity::json() of the run
std::string part_path(const std::string& folder, std::string_view noun, int unit);

// The path of another file of a unit beside its part, and the units that have such a file, in
// ascending order. ending: of the name, such as ".csv".
std::string unit_file_path(const std::string& folder, std::string_view noun, int unit,
                           std::string_view ending);
std::vector<int> units_with_files(const std::string& folder, std::string_view noun,
                                  std::string_view ending);

// The units that have a part in the folder, in ascending order.
std::vector<int> units_with_parts(const std::string& folder, std::string_view noun);

// Writes the part, whole or not at all. rows: lines without the line of names.
std::optional<Error> write_part(const std::string& path, const DealtUnits& units, int unit,
                                std::string_view rows);

// The rows of a part. Errors: the file is not a part, the part belongs to another run or unit, or
// its rows do not have the hash that its first line states.
Result<std::string> read_part(const std::string& path, const DealtUnits& units, int unit);

}  // namespace palpate
