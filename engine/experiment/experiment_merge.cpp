#include "engine/experiment/experiment_merge.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <optional>
#include <sys/file.h>
#include <unistd.h>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/experiment/csv_reader.h"
#include "engine/experiment/operator_parameters.h"
#include "engine/experiment/participant_part.h"
#include "engine/experiment/run_identity.h"
#include "engine/experiment/strict_json.h"
#include "engine/experiment/trials_file.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"

namespace palpate {
namespace {

using OrderedJson = nlohmann::ordered_json;

struct FoundPart {
  std::string path;
  std::string rows;
};

// Waits until no other process moves results into the folder: moving replaces several files, and
// two runs of one plan may end at the same time. Where the file system has no locks, it does not
// wait.
class OneAtATime {
 public:
  explicit OneAtATime(const std::string& folder)
      : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    while (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~OneAtATime() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OneAtATime(const OneAtATime&) = delete;
  OneAtATime& operator=(const OneAtATime&) = delete;

 private:
  int descriptor_;
};

Error merge_error(std::string path, std::string element, std::string problem, std::string hint) {
  return {ErrorCode::kInvalidContent, std::move(path), std::move(element), std::move(problem),
          std::move(hint)};
}

Result<RunIdentity> read_identity(const std::string& folder) {
  const std::string path = part_identity_path(folder);
  const auto text = read_settings_text(path);
  if (text) return parse_identity(*text, path);
  if (text.error().code != ErrorCode::kFileNotFound) return text.error();
  return Error{ErrorCode::kFileNotFound, folder, "",
               "has no parts/run.json; expected the folder of `experiment run --out`", ""};
}

Result<RunIdentity> common_identity(const std::vector<std::string>& folders) {
  auto first = read_identity(folders.front());
  if (!first) return first;
  for (std::size_t i = 1; i < folders.size(); ++i) {
    const auto other = read_identity(folders[i]);
    if (!other) return other.error();
    if (auto error = find_difference(*other, *first, part_identity_path(folders.front()))) {
      error->path = part_identity_path(folders[i]);
      return *error;
    }
  }
  return first;
}

// The first line and column at which two parts differ. Both have rows of these columns.
Error difference_of(const FoundPart& part, const FoundPart& other, TrialColumns columns) {
  constexpr std::size_t kLinesBefore = 2;  // of the part: its hash and the names of the columns
  std::vector<std::string> names;
  std::vector<std::string> fields;
  std::vector<std::string> expected;
  [[maybe_unused]] const auto is_read = CsvReader(trials_columns(columns)).next(names);
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
      "one of the machines computes differently; run this participant on both again");
}

// Adds the parts of a folder. A participant may have equal parts in several folders.
std::optional<Error> add_parts(const std::string& folder, const RunIdentity& identity,
                               std::map<int, FoundPart>& parts) {
  for (const int participant : participants_with_parts(folder)) {
    FoundPart part{part_path(folder, participant), {}};
    if (participant > identity.participants) {
      return merge_error(part.path, "",
                         "is of participant " + std::to_string(participant) + "; expected 1 to " +
                             std::to_string(identity.participants),
                         "remove the file");
    }
    auto rows = read_part(part.path, identity.hash(), participant, identity.columns());
    if (!rows) return rows.error();
    part.rows = std::move(*rows);
    const auto [known, is_new] = parts.try_emplace(participant, part);
    if (!is_new && known->second.rows != part.rows) {
      return difference_of(part, known->second, identity.columns());
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
                                    const RunIdentity& identity,
                                    const std::map<int, FoundPart>& parts) {
  std::vector<int> missing;
  for (int participant = 1; participant <= identity.participants; ++participant) {
    if (!parts.contains(participant)) missing.push_back(participant);
  }
  if (missing.empty()) return std::nullopt;
  return Error{ErrorCode::kFileNotFound, folders.front(), "",
               "lacks participant" + std::string(missing.size() > 1 ? "s " : " ") +
                   listed(missing) + " of " + std::to_string(identity.participants) +
                   (folders.size() > 1 ? ", and so do the other folders" : ""),
               "run their shards, or name the folders that have them"};
}

std::string run_json(const RunIdentity& identity, const std::vector<TrialRow>& rows) {
  OrderedJson by_following = OrderedJson::object();
  for (const TrialRow& row : rows) {
    OrderedJson& counts = by_following[row.following];
    for (const std::string_view status : kTrialStatusNames) {
      OrderedJson& count = counts[std::string(status)];
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

std::optional<Error> write_results(const std::string& out_folder, const std::string& trials,
                                   TrialColumns columns, const std::string& run) {
  auto files = OutputFiles::create(out_folder, {kTrialsFile, kColumnsFile, kRunFile});
  if (!files) return files.error();
  const std::array<std::pair<const char*, std::string>, 3> texts = {
      {{kTrialsFile, trials}, {kColumnsFile, columns_csv(columns)}, {kRunFile, run}}};
  for (const auto& [name, text] : texts) {
    const auto written = write_text_file(files->path(name), text);
    if (!written) return files->in_place(written.error());
  }
  const OneAtATime lock(out_folder);
  return files->move_into_place();
}

}  // namespace

Result<MergedExperiment> merge_experiment(const std::vector<std::string>& folders,
                                          const std::string& out_folder) {
  const auto identity = common_identity(folders);
  if (!identity) return identity.error();
  std::map<int, FoundPart> parts;
  for (const std::string& folder : folders) {
    if (auto error = add_parts(folder, *identity, parts)) return *error;
  }
  if (auto error = check_complete(folders, *identity, parts)) return *error;
  std::string trials = trials_columns(identity->columns()) + "\n";
  for (const auto& [participant, part] : parts) trials += part.rows;
  const auto rows =
      parse_trials(trials, (std::filesystem::path(out_folder) / kTrialsFile).string());
  if (!rows) return rows.error();
  if (auto error =
          write_results(out_folder, trials, identity->columns(), run_json(*identity, *rows))) {
    return *error;
  }
  MergedExperiment merged{identity->participants, rows->size(), {}};
  for (const TrialRow& row : *rows) ++merged.by_status[static_cast<std::size_t>(row.status)];
  return merged;
}

}  // namespace palpate
