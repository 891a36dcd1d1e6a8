#pragma once

// The folder of an experiment with people: DIR of `palpate experiment live`.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/live/journal.h"
#include "engine/trials/plan.h"
#include "engine/trials/questionnaire_file.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr std::string_view kJournalName = "journal.txt";
inline constexpr const char* kPlanFile = "plan.json";
inline constexpr const char* kTextsFile = "texts.json";
inline constexpr const char* kQuestionnairesFile = "questionnaires.csv";

// DIR/plan.json          the plan, as it was given; DIR/texts.json: what participants read
// DIR/trials.csv         the rows of all participants; DIR/columns.csv explains the columns
// DIR/questionnaires.csv what they answered after each condition, if the plan asks them
// DIR/participants/03/   what belongs to participant 3 and to nobody else: journal.txt, about.json
//                        and recordings/
// The rows stand in the journals; trials.csv is made from them. Several programs may use one folder
// for different participants.
class LiveFolder {
 public:
  // plan: with a `live`. Creates what is missing. Errors: the folder has another plan or other
  // texts, or cannot be written.
  static Result<LiveFolder> open(const std::string& folder, const ExperimentPlan& plan);
  // Error: the folder is none of an experiment with people.
  static Result<LiveFolder> existing(const std::string& folder);

  const std::string& path() const { return folder_; }
  std::string participant_path(int participant) const;
  std::string journal_path(int participant) const;
  std::string about_path(int participant) const;
  std::string recording_path(int participant, const std::string& name) const;

  // Creates the folder of a participant.
  std::optional<Error> add_participant(int participant) const;
  // Removes it with all that is in it.
  std::optional<Error> remove_participant(int participant) const;
  // Removes all but the number and the date, which stay in forgotten.csv, and writes the rows of
  // the others. Backups of the folder are out of reach. If the program is killed, another call
  // removes the rest. Errors: the folder has nothing of this participant; a program leads them just
  // now.
  std::optional<Error> forget_participant(int participant) const;
  // Writes trials.csv, columns.csv and questionnaires.csv from the journals. participant: whose
  // entries are given; the others' are read. Without an answer questionnaires.csv stays as it is.
  std::optional<Error> write_rows(int participant, const std::vector<JournalEntry>& entries) const;

 private:
  explicit LiveFolder(std::string folder) : folder_(std::move(folder)) {}
  Result<std::vector<int>> participants() const;
  std::optional<Error> remove_ratings(int participant) const;
  std::optional<Error> remove_unfinished() const;
  Result<std::string> forgotten_text() const;
  std::optional<Error> write_rows_alone(int participant,
                                        const std::vector<JournalEntry>& entries) const;

  std::string folder_;
};

// The rows of trials.csv in the entries of a journal, in their order.
std::string rows_in(const std::vector<JournalEntry>& entries);

// The answers to questionnaires in the entries of a journal. A condition that was rated in several
// blocks has the newest answers. Those of a pilot are left out.
std::vector<QuestionnaireRow> ratings_in(int participant, const std::vector<JournalEntry>& entries);

// ISO 8601 with milliseconds.
std::string utc_now();

// Writes a file that appears under its name when it is complete and on the disk, and that only its
// owner reads. WholeFile does neither of the last two, and keeps other commands out of the folder.
std::optional<Error> write_synced(const std::string& path, std::string_view text);

}  // namespace palpate
