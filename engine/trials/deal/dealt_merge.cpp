#include "engine/trials/deal/dealt_merge.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "engine/report/text_file.h"
#include "engine/trials/csv_reader.h"
#include "engine/trials/strict_json.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

struct FoundPart {
  std::string path;
  std::string rows;
};

Error merge_error(std::string path, std::string element, std::string problem, std::string hint) {
  return {ErrorCode::kInvalidContent, std::move(path), std::move(element), std::move(problem),
          std::move(hint)};
}

Result<RunIdentity> read_identity(const std::string& folder) {
  const std::string path = part_identity_path(folder);
  const OwnResultsScope own;
  const auto text = read_settings_text(path);
  if (text) return parse_identity(*text, path);
  if (text.error().code != ErrorCode::kFileNotFound) return text.error();
  return Error{ErrorCode::kFileNotFound, folder, "",
               "has no parts/run.json; expected the folder of `experiment run --out` or of "
               "`experiment sweep --out`",
               ""};
}

std::string kind_text(RunKind kind) {
  if (kind == RunKind::kExperiment) return "an experiment";
  if (kind == RunKind::kCanonical) return "a canonical wall";
  return "a " + std::string(words_of(kind).name);
}

// expected: of the kind, with where it comes from.
Error wrong_kind(const std::string& folder, RunKind kind, const std::string& expected,
                 std::string hint) {
  return merge_error(part_identity_path(folder), "/kind",
                     "is of " + kind_text(kind) + "; expected " + expected, std::move(hint));
}

Result<RunIdentity> common_identity(const std::vector<std::string>& folders) {
  auto first = read_identity(folders.front());
  if (!first) return first;
  for (std::size_t i = 1; i < folders.size(); ++i) {
    const auto other = read_identity(folders[i]);
    if (!other) return other.error();
    if (other->kind != first->kind) {
      return wrong_kind(folders[i], other->kind,
                        kind_text(first->kind) + ", as in " + part_identity_path(folders.front()),
                        "merge the shards of one plan");
    }
    if (auto error = find_difference(*other, *first, part_identity_path(folders.front()))) {
      error->path = part_identity_path(folders[i]);
      return *error;
    }
  }
  return first;
}

// The first line and column at which two parts differ. Both have rows of these columns.
Error difference_of(const FoundPart& part, const FoundPart& other, const DealtUnits& units) {
  constexpr std::size_t kLinesBefore = 2;  // of the part: its hash and the names of the columns
  std::vector<std::string> names;
  std::vector<std::string> fields;
  std::vector<std::string> expected;
  [[maybe_unused]] const auto is_read = CsvReader(units.columns).next(names);
  CsvReader mine(part.rows);
  CsvReader theirs(other.rows);
  std::string element = "line " + std::to_string(kLinesBefore);
  std::string problem = "differs";
  while (true) {
    const auto has_mine = mine.next(fields);
    const auto has_theirs = theirs.next(expected);
    if (!has_mine || !has_theirs || !*has_mine || !*has_theirs) break;
    element = "line " + std::to_string(mine.line() + kLinesBefore);
    const auto [field, other_field] =
        std::mismatch(fields.begin(), fields.end(), expected.begin(), expected.end());
    if (field == fields.end() || other_field == expected.end()) continue;
    const auto column = static_cast<std::size_t>(field - fields.begin());
    if (column < names.size()) element += ", column " + names[column];
    problem = "is " + (field->empty() ? "empty" : *field) + "; expected " +
              (other_field->empty() ? "an empty field" : *other_field);
    break;
  }
  return merge_error(
      part.path, element, problem + ", as in " + other.path,
      "one of the machines computes differently; run this " + units.noun + " on both again");
}

// Adds the parts of a folder. A unit may have equal parts in several folders.
std::optional<Error> add_parts(const std::string& folder, const DealtUnits& units,
                               std::map<int, FoundPart>& parts) {
  for (const int unit : units_with_parts(folder, units.noun)) {
    FoundPart part{part_path(folder, units.noun, unit), {}};
    if (unit > units.count) {
      return merge_error(part.path, "",
                         "is of " + units.noun + " " + std::to_string(unit) + "; expected 1 to " +
                             std::to_string(units.count),
                         "remove the file");
    }
    auto rows = read_part(part.path, units, unit);
    if (!rows) return rows.error();
    part.rows = std::move(*rows);
    const auto [known, is_new] = parts.try_emplace(unit, part);
    if (!is_new && known->second.rows != part.rows) {
      return difference_of(part, known->second, units);
    }
  }
  return std::nullopt;
}

// "1, 2 and 5", at most ten of them.
std::string listed(const std::vector<int>& numbers) {
  constexpr std::size_t kMost = 10;
  const std::size_t count = std::min(numbers.size(), kMost);
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_last = i + 1 == numbers.size();
    if (i > 0) text += is_last ? " and " : ", ";
    text += std::to_string(numbers[i]);
  }
  if (numbers.size() > kMost) text += " and " + std::to_string(numbers.size() - kMost) + " more";
  return text;
}

std::optional<Error> check_complete(const std::vector<std::string>& folders,
                                    const DealtUnits& units,
                                    const std::map<int, FoundPart>& parts) {
  std::vector<int> missing;
  for (int unit = 1; unit <= units.count; ++unit) {
    if (!parts.contains(unit)) missing.push_back(unit);
  }
  if (missing.empty()) return std::nullopt;
  return Error{ErrorCode::kFileNotFound, folders.front(), "",
               "lacks " + units.noun + (missing.size() > 1 ? "s " : " ") + listed(missing) +
                   " of " + std::to_string(units.count) +
                   (folders.size() > 1 ? ", and so do the other folders" : ""),
               "run their shards, or name the folders that have them"};
}

}  // namespace

Result<RunKind> kind_of_run_in(const std::string& folder) {
  const auto identity = read_identity(folder);
  if (!identity) return identity.error();
  return identity->kind;
}

Result<JoinedParts> join_parts(const std::vector<std::string>& folders, RunKind kind,
                               const std::function<std::string(const RunIdentity&)>& columns_of) {
  auto identity = common_identity(folders);
  if (!identity) return identity.error();
  if (identity->kind != kind) {
    return wrong_kind(folders.front(), identity->kind, kind_text(kind),
                      "merge it with `experiment merge`");
  }
  const DealtUnits units = identity->dealt_units(columns_of(*identity));
  std::map<int, FoundPart> parts;
  for (const std::string& folder : folders) {
    if (auto error = add_parts(folder, units, parts)) return *error;
  }
  if (auto error = check_complete(folders, units, parts)) return *error;
  JoinedParts joined{std::move(*identity), {}};
  for (const auto& [unit, part] : parts) joined.rows += part.rows;
  return joined;
}

Result<OutputFiles> stage_results(const std::string& folder, RunKind kind,
                                  const std::vector<std::pair<std::string, std::string>>& texts) {
  std::vector<std::string> names;
  for (const std::string& name : results_of_other_kinds_in(folder, kind)) {
    std::error_code failed;
    const auto path = std::filesystem::path(folder) / name;
    if (std::filesystem::is_regular_file(path, failed)) names.push_back(name);
  }
  for (std::string& name : result_names(kind)) names.push_back(std::move(name));
  auto files = OutputFiles::create(folder, names);
  if (!files) return files;
  for (const auto& [name, text] : texts) {
    const auto written = write_text_file(files->path(name), text);
    if (!written) return files->in_place(written.error());
  }
  return files;
}

}  // namespace palpate
