#include "engine/live/live_folder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "engine/report/write_error.h"
#include "engine/report/write_whole.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/trials_file.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParticipants = "participants";
constexpr const char* kRecordings = "recordings";
constexpr const char* kForgotten = "forgotten.csv";

// Where a file is until it is complete.
std::string part_of(const std::string& path) {
  return path + ".part";
}

std::optional<Error> make_folder(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  if (failed) return write_error(path.string(), failed.value());
  return std::nullopt;
}

// Keeps other programs from the files of the folder that all participants share, as long as an
// object lives, where the file system has locks. It leaves nothing in the folder.
class SharedFiles {
 public:
  explicit SharedFiles(const std::string& folder)
      : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0) return;
    while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~SharedFiles() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  SharedFiles(const SharedFiles&) = delete;
  SharedFiles& operator=(const SharedFiles&) = delete;

 private:
  int descriptor_;
};

// The lines of a trials.csv that are of a participant.
std::string rows_of(const std::string& trials, int participant) {
  const std::string number = std::to_string(participant);
  std::string rows;
  for (std::size_t begin = 0; begin < trials.size();) {
    const std::size_t end = std::min(trials.find('\n', begin), trials.size() - 1) + 1;
    const std::size_t field = trials.find(',', begin) + 1;
    if (field != 0 && trials.compare(field, number.size() + 1, number + ",") == 0) {
      rows += trials.substr(begin, end - begin);
    }
    begin = end;
  }
  return rows;
}

// The answers in a questionnaires.csv that are of a participant.
std::vector<QuestionnaireRow> ratings_of(const std::string& path, int participant) {
  auto rows = read_questionnaires(path);
  if (!rows) return {};
  std::erase_if(*rows, [&](const QuestionnaireRow& row) {
    return row.participant != std::to_string(participant);
  });
  return std::move(*rows);
}

// A folder that has the file has it with this text.
std::optional<Error> check_same(const std::string& path, const std::string& text,
                                const std::string& expected) {
  const auto bytes = read_regular_file(path, kMostTextsFileBytes);
  if (!bytes && bytes.error().code == ErrorCode::kFileNotFound) return write_synced(path, text);
  if (!bytes) return bytes.error();
  const std::string_view found(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (found == text) return std::nullopt;
  return Error{ErrorCode::kInvalidContent, path, "", "is another one; expected " + expected,
               "choose another folder with --out, or continue with what is in the folder"};
}

// What participants read, also where the plan names files.
std::string texts_of(const LivePlan& live) {
  nlohmann::ordered_json json = {{"language", live.language}};
  for (std::size_t i = 0; i < kLiveTextCount; ++i) {
    json[std::string(kLiveTextNames[i])] = live.texts[i];
  }
  json["words"] = live.words;
  return json.dump(1) + "\n";
}

}  // namespace

std::string utc_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  const auto seconds = static_cast<std::time_t>(ms / 1000);
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::array<char, 40> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::string fraction = std::to_string(ms % 1000);
  fraction.insert(0, 3 - fraction.size(), '0');
  return std::string(text.data(), length) + "." + fraction + "Z";
}

std::optional<Error> write_synced(const std::string& path, std::string_view text) {
  const std::string part = part_of(path);
  const int descriptor =
      ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) return write_error(part, errno);
  int reason = write_whole(descriptor, text, 0);
  if (reason == 0 && ::fsync(descriptor) != 0) reason = errno;
  ::close(descriptor);
  if (reason == 0 && ::rename(part.c_str(), path.c_str()) != 0) reason = errno;
  if (reason == 0) return std::nullopt;
  ::unlink(part.c_str());
  return write_error(path, reason);
}

std::string rows_in(const std::vector<JournalEntry>& entries) {
  std::string rows;
  for (const JournalEntry& entry : entries) {
    const auto row = entry.find("row");
    if (row != entry.end() && row->is_string()) rows += row->get<std::string>();
  }
  return rows;
}

std::vector<QuestionnaireRow> ratings_in(int participant,
                                         const std::vector<JournalEntry>& entries) {
  std::vector<QuestionnaireRow> rows;
  for (const JournalEntry& entry : entries) {
    if (entry.value("kind", "") != "rated" || entry.value("pilot", false)) continue;
    const std::string haptic = entry.value("haptic", "");
    const std::string rotation = entry.value("rotation", "");
    const int block = entry.value("block", 1);
    std::erase_if(rows, [&](const QuestionnaireRow& row) {  // rated again
      return row.block == block && row.haptic == haptic && row.rotation == rotation;
    });
    for (const auto& level : kQuestionnaireItemLevels) {
      const int value = entry.at("answers").value(std::string(level.name), 0);
      rows.push_back({std::to_string(participant), block, haptic, rotation, level.value, value});
    }
  }
  return rows;
}

Result<LiveFolder> LiveFolder::existing(const std::string& folder) {
  std::error_code failed;
  if (fs::is_directory(fs::path(folder) / kParticipants, failed)) return LiveFolder(folder);
  return Error{ErrorCode::kFileNotFound, folder, "",
               "is no folder of an experiment with people; expected one with participants/",
               "name the folder of `experiment live --out`"};
}

Result<LiveFolder> LiveFolder::open(const std::string& folder, const ExperimentPlan& plan) {
  LiveFolder live(folder);
  const auto path = [&](const char* name) { return (fs::path(folder) / name).string(); };
  std::error_code failed;
  if (fs::exists(path(kRunFile), failed)) {
    return Error{ErrorCode::kInvalidContent, path(kRunFile), "",
                 "is of trials of simulated persons; expected a folder for people",
                 "choose another folder with --out"};
  }
  if (auto error = make_folder(path(kParticipants))) return *error;
  const SharedFiles alone(folder);
  if (auto error = check_same(path(kPlanFile), plan.text, plan.path + ", byte by byte")) {
    return *error;
  }
  if (auto error =
          check_same(path(kTextsFile), texts_of(*plan.live), "the texts of " + plan.path)) {
    return *error;
  }
  return live;
}

std::string LiveFolder::participant_path(int participant) const {
  std::string number = std::to_string(participant);
  if (number.size() < 2) number.insert(0, "0");
  return (fs::path(folder_) / kParticipants / number).string();
}

std::string LiveFolder::journal_path(int participant) const {
  return (fs::path(participant_path(participant)) / kJournalName).string();
}

std::string LiveFolder::about_path(int participant) const {
  return (fs::path(participant_path(participant)) / "about.json").string();
}

std::string LiveFolder::recording_path(int participant, const std::string& name) const {
  return (fs::path(participant_path(participant)) / kRecordings / name).string();
}

std::optional<Error> LiveFolder::add_participant(int participant) const {
  const fs::path folder = participant_path(participant);
  if (auto error = make_folder(folder / kRecordings)) return error;
  std::error_code failed;
  fs::permissions(folder, fs::perms::owner_all, failed);
  if (failed) return write_error(folder.string(), failed.value());
  return std::nullopt;
}

std::optional<Error> LiveFolder::remove_participant(int participant) const {
  std::error_code failed;
  const std::string path = participant_path(participant);
  fs::remove_all(path, failed);
  if (failed) return write_error(path, failed.value());
  return std::nullopt;
}

// forgotten.csv, or its first line if nobody is forgotten yet.
Result<std::string> LiveFolder::forgotten_text() const {
  const auto found =
      read_regular_file((fs::path(folder_) / kForgotten).string(), kMostSettingsBytes);
  if (found) return std::string(reinterpret_cast<const char*>(found->data()), found->size());
  if (found.error().code != ErrorCode::kFileNotFound) return found.error();
  return std::string("participant,date_utc\n");
}

std::optional<Error> LiveFolder::forget_participant(int participant) const {
  const std::string path = participant_path(participant);
  const SharedFiles alone(folder_);
  auto noted = forgotten_text();
  if (!noted) return noted.error();
  std::string& forgotten = *noted;
  const std::string number = std::to_string(participant) + ",";
  const bool is_noted = forgotten.find("\n" + number) != std::string::npos;
  std::error_code failed;
  if (!is_noted && !fs::exists(path, failed)) {
    return Error{ErrorCode::kFileNotFound, path, "", "does not exist; expected a participant", ""};
  }
  if (Journal::is_in_use(journal_path(participant))) {
    return Error{ErrorCode::kFileUnwritable, path, "",
                 "is in use: an `experiment live` runs for this participant", "end it first"};
  }
  if (!is_noted) {
    forgotten += number + utc_now() + "\n";
    if (auto error = write_synced((fs::path(folder_) / kForgotten).string(), forgotten))
      return error;
  }
  if (auto error = remove_participant(participant)) return error;
  if (auto error = write_rows_alone(participant, {})) return error;
  if (auto error = remove_ratings(participant)) return error;
  return remove_unfinished();
}

// What a program left that was killed while it wrote may have rows of anybody.
std::optional<Error> LiveFolder::remove_unfinished() const {
  for (const char* const name : {kTrialsFile, kQuestionnairesFile}) {
    const std::string path = part_of((fs::path(folder_) / name).string());
    std::error_code failed;
    fs::remove(path, failed);
    if (failed) return write_error(path, failed.value());
  }
  return std::nullopt;
}

// From a questionnaires.csv that no journal explains, too.
std::optional<Error> LiveFolder::remove_ratings(int participant) const {
  const std::string path = (fs::path(folder_) / kQuestionnairesFile).string();
  const auto rows = read_questionnaires(path);
  if (!rows && rows.error().code == ErrorCode::kFileNotFound) return std::nullopt;
  if (!rows) return rows.error();
  CsvLines kept(names_in(questionnaire_table()));
  std::size_t kept_count = 0;
  for (const QuestionnaireRow& row : *rows) {
    if (row.participant == std::to_string(participant)) continue;
    add_questionnaire_row(kept, row);
    ++kept_count;
  }
  if (kept_count == rows->size()) return std::nullopt;
  if (kept_count > 0) return write_synced(path, kept.text());
  std::error_code failed;
  fs::remove(path, failed);
  if (failed) return write_error(path, failed.value());
  return std::nullopt;
}

Result<std::vector<int>> LiveFolder::participants() const {
  std::vector<int> found;
  std::error_code failed;
  const fs::path folder = fs::path(folder_) / kParticipants;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string name = entry.path().filename().string();
    int number = 0;
    const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (problem == std::errc() && end == name.data() + name.size()) found.push_back(number);
  }
  if (failed) return write_error(folder.string(), failed.value());
  std::sort(found.begin(), found.end());
  return found;
}

std::optional<Error> LiveFolder::write_rows(int participant,
                                            const std::vector<JournalEntry>& entries) const {
  const SharedFiles alone(folder_);
  return write_rows_alone(participant, entries);
}

std::optional<Error> LiveFolder::write_rows_alone(int participant,
                                                  const std::vector<JournalEntry>& entries) const {
  const auto bytes =
      read_regular_file((fs::path(folder_) / kTrialsFile).string(), kMostTrialsBytes);
  std::string before;
  if (bytes) before.assign(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::string text = trials_columns(TrialColumns::kLive) + "\n";
  CsvLines ratings(names_in(questionnaire_table()));
  bool has_ratings = false;
  const fs::path folder(folder_);
  const std::string ratings_path = (folder / kQuestionnairesFile).string();
  const auto take = [&](const std::string& rows, const std::vector<QuestionnaireRow>& answers) {
    text += rows;
    for (const QuestionnaireRow& row : answers) add_questionnaire_row(ratings, row);
    has_ratings = has_ratings || !answers.empty();
  };
  const auto numbers = participants();
  if (!numbers) return numbers.error();
  for (const int other : *numbers) {
    if (other == participant) {
      take(rows_in(entries), ratings_in(participant, entries));
      continue;
    }
    const auto read = Journal::read(journal_path(other));
    if (!read && read.error().code == ErrorCode::kFileNotFound) continue;
    if (read) {
      take(rows_in(*read), ratings_in(other, *read));
    } else {  // a journal that is damaged does not take its rows along
      take(rows_of(before, other), ratings_of(ratings_path, other));
    }
  }
  if (auto error = write_synced((folder / kTrialsFile).string(), text)) return error;
  if (has_ratings) {
    if (auto error = write_synced(ratings_path, ratings.text())) return error;
  }
  return write_synced((folder / kColumnsFile).string(), columns_csv(TrialColumns::kLive));
}

}  // namespace palpate
