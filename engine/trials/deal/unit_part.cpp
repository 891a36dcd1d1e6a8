#include "engine/trials/deal/unit_part.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "engine/report/whole_file.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/file_roles.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartEnd = ".csv";

// The first line: what the rows belong to, and their hash.
std::string line_of_run(const DealtUnits& units, int unit) {
  return "palpate part 1, run " + hash_text(units.identity) + ", " + units.noun + " " +
         std::to_string(unit) + ", rows ";
}

std::string first_lines(const DealtUnits& units, int unit, std::string_view rows) {
  return line_of_run(units, unit) + hash_text(KeyHash().add(rows).value()) + "\n" + units.columns +
         "\n";
}

Error part_error(const std::string& path, std::string element, std::string problem) {
  return {ErrorCode::kInvalidContent, path, std::move(element), std::move(problem),
          "remove the file and run its shard again"};
}

}  // namespace

std::string parts_folder(const std::string& folder) {
  return (fs::path(folder) / "parts").string();
}

std::string part_identity_path(const std::string& folder) {
  return (fs::path(parts_folder(folder)) / "run.json").string();
}

std::string unit_file_path(const std::string& folder, std::string_view noun, int unit,
                           std::string_view ending) {
  std::string name(noun);
  name.append("-").append(std::to_string(unit)).append(ending);
  return (fs::path(parts_folder(folder)) / name).string();
}

std::string part_path(const std::string& folder, std::string_view noun, int unit) {
  return unit_file_path(folder, noun, unit, kPartEnd);
}

std::vector<int> units_with_files(const std::string& folder, std::string_view noun,
                                  std::string_view ending) {
  const std::string begin_of_names = std::string(noun) + "-";
  std::vector<int> units;
  std::error_code failed;
  for (fs::directory_iterator entry(parts_folder(folder), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin_of_names) || !name.ends_with(ending)) continue;
    const char* const begin = name.data() + begin_of_names.size();
    const char* const stop = name.data() + name.size() - ending.size();
    int unit = 0;
    const auto [rest, problem] = std::from_chars(begin, stop, unit);
    const bool is_number = problem == std::errc() && rest == stop && unit > 0;
    if (is_number &&
        fs::path(unit_file_path(folder, noun, unit, ending)).filename() == name) {  // not 007
      units.push_back(unit);
    }
  }
  std::sort(units.begin(), units.end());
  return units;
}

std::vector<int> units_with_parts(const std::string& folder, std::string_view noun) {
  return units_with_files(folder, noun, kPartEnd);
}

std::optional<Error> write_part(const std::string& path, const DealtUnits& units, int unit,
                                std::string_view rows) {
  auto file = WholeFile::create(path);
  if (!file) return file.error();
  file->add(first_lines(units, unit, rows));
  file->add(rows);
  return file->finish();
}

Result<std::string> read_part(const std::string& path, const DealtUnits& units, int unit) {
  const OwnResultsScope own;
  const auto bytes = read_regular_file(path, kMostTrialsBytes);
  if (!bytes) return bytes.error();
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const std::string begin = line_of_run(units, unit);
  if (!text.starts_with(begin)) {
    const std::string found(text.substr(0, std::min(text.find('\n'), begin.size())));
    return part_error(path, "line 1", "begins with \"" + found + "\"; expected \"" + begin + "\"");
  }
  const std::size_t head_bytes = first_lines(units, unit, "").size();
  const std::string_view rows = text.substr(std::min(head_bytes, text.size()));
  const std::size_t second_line = text.find('\n') + 1;
  const std::string_view columns =
      text.substr(second_line, text.find('\n', second_line) - second_line);
  if (second_line > 0 && columns != units.columns) {
    return part_error(path, "line 2", "has other columns than this version of Palpate writes");
  }
  if (text.substr(0, text.size() - rows.size()) != first_lines(units, unit, rows)) {
    return part_error(path, "line 1", "does not have the hash of the rows; the file was changed");
  }
  return std::string(rows);
}

}  // namespace palpate
