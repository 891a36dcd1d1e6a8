#include "engine/cli/experiment_export.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/live/live_folder.h"
#include "engine/report/csv.h"
#include "engine/report/whole_file.h"
#include "engine/trials/csv_cells.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/live_plan.h"
#include "engine/trials/psych_ds.h"
#include "engine/trials/questionnaire_file.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::array<std::string_view, 3> kExportParts = {"recordings", "notes", "about"};
// Of the columns kAboutNames.
constexpr std::array<std::string_view, kAboutNames.size()> kAboutMeanings = {
    "age in years, as the participant stated it", "gender, as the participant stated it",
    "hand used, as the participant stated it",
    "experience with such devices, as the participant stated it"};

// What a folder of an experiment holds.
struct Exported {
  std::string name;                             // of the plan
  std::map<int, std::vector<TrialRow>> trials;  // by participant, in the order of the file
  std::map<int, std::vector<QuestionnaireRow>> answers;
  std::map<int, fs::path> folders;  // of participants
  std::map<int, std::array<std::string, kAboutNames.size()>> about;
  TrialColumns columns = TrialColumns::kFactors;
  std::string plan, texts;  // empty: the folder has none
};

Error in_file(const fs::path& path, std::string element, std::string problem,
              std::string hint = {}) {
  return {ErrorCode::kInvalidContent, path.string(), std::move(element), std::move(problem),
          std::move(hint)};
}

// Participants are numbers, so that no file has a name of a person.
std::optional<int> number_of(const std::string& participant) {
  int number = 0;
  if (read_whole(participant, {0}, number)) return std::nullopt;
  if (std::to_string(number) != participant) return std::nullopt;  // leading zeros
  return number;
}

template <class Row>
std::optional<Error> add_by_participant(std::vector<Row> rows, const fs::path& path,
                                        std::map<int, std::vector<Row>>& found) {
  for (Row& row : rows) {
    const std::optional<int> number = number_of(row.participant);
    if (!number) {
      return in_file(path, "column participant",
                     "is \"" + row.participant + "\"; expected a number without leading zeros",
                     "an export has no names of people");
    }
    found[*number].push_back(std::move(row));
  }
  return std::nullopt;
}

bool is_there(const fs::path& path) {
  std::error_code failed;
  return fs::exists(fs::symlink_status(path, failed));
}

bool is_inside(const fs::path& place, const fs::path& folder) {
  std::error_code failed;
  const fs::path from = fs::weakly_canonical(folder, failed);
  const fs::path way = fs::weakly_canonical(place, failed).lexically_relative(from);
  return !failed && !way.empty() && *way.begin() != "..";
}

std::optional<Error> read_rows(const fs::path& folder, Exported& found) {
  const fs::path trials = folder / kTrialsFile;
  auto rows = read_trials(trials.string());
  if (!rows) return rows.error();
  for (const TrialRow& row : *rows) {
    if (row.live) found.columns = TrialColumns::kLive;
    if (row.strategy.empty()) continue;
    return in_file(trials, "column strategy",
                   "is " + row.strategy + "; expected trials with haptic and rotation");
  }
  if (auto error = add_by_participant(std::move(*rows), trials, found.trials)) return error;
  const fs::path answers = folder / kQuestionnairesFile;
  if (!is_there(answers)) return std::nullopt;
  auto answered = read_questionnaires(answers.string());
  if (!answered) return answered.error();
  return add_by_participant(std::move(*answered), answers, found.answers);
}

// The plan of a live experiment is a file; that of a run stands in run.json.
std::optional<Error> read_plan(const fs::path& folder, Exported& found) {
  const fs::path plan = folder / kPlanFile;
  const fs::path path = is_there(plan) ? plan : folder / kRunFile;
  const auto text = read_settings_text(path.string());
  if (!text) return text.error();
  const auto json = parse_strict_json(*text, path.string());
  if (!json) return json.error();
  if (path == plan) found.plan = *text;
  const std::string element = path == plan ? "/name" : "/plan/name";
  const Json::json_pointer name(element);
  if (!json->contains(name) || !json->at(name).is_string()) {
    return in_file(path, element, "is missing; expected a text");
  }
  found.name = json->at(name).get<std::string>();
  if (!is_there(folder / kTextsFile)) return std::nullopt;
  const auto texts = read_settings_text((folder / kTextsFile).string(), kMostTextsFileBytes);
  if (!texts) return texts.error();
  found.texts = *texts;
  return std::nullopt;
}

// The folders of participants: "01" is of participant 1.
void find_folders(const fs::path& folder, Exported& found) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder / "participants", failed)) {
    std::string name = entry.path().filename().string();
    name.erase(0, std::min(name.find_first_not_of('0'), name.size() - 1));
    const std::optional<int> number = number_of(name);
    if (number && found.trials.contains(*number)) found.folders[*number] = entry.path();
  }
}

std::optional<Error> read_about(Exported& found) {
  for (const auto& [number, folder] : found.folders) {
    const fs::path path = folder / "about.json";
    if (!is_there(path)) continue;
    const auto text = read_settings_text(path.string());
    if (!text) return text.error();
    const auto json = parse_strict_json(*text, path.string());
    if (!json) return json.error();
    if (!json->is_object()) return in_file(path, "", "is no object; expected the answers");
    for (const auto& [key, value] : json->items()) {
      const auto item = std::find(kAboutNames.begin(), kAboutNames.end(), key);
      if (item == kAboutNames.end() || !value.is_string()) {
        return in_file(path, "/" + key,
                       "is unknown or no text; expected texts of age, gender, "
                       "hand and experience");
      }
      found.about[number][static_cast<std::size_t>(item - kAboutNames.begin())] =
          value.get<std::string>();
    }
  }
  return std::nullopt;
}

bool has(const ExperimentExportRequest& request, std::string_view part) {
  return std::find(request.with.begin(), request.with.end(), part) != request.with.end();
}

Result<Exported> read_folder(const ExperimentExportRequest& request) {
  Exported found;
  const fs::path folder = request.folder;
  for (const auto& error : {read_rows(folder, found), read_plan(folder, found)}) {
    if (error) return *error;
  }
  find_folders(folder, found);
  if (has(request, "about")) {
    if (auto error = read_about(found)) return *error;
  }
  return found;
}

// The texts of people.

std::vector<DescribedColumn> about_columns() {
  std::vector<DescribedColumn> columns = {{"participant", "", "the person", "whole 0.."}};
  for (std::size_t i = 0; i < kAboutNames.size(); ++i) {
    columns.push_back(
        {std::string(kAboutNames[i]), "", std::string(kAboutMeanings[i]), "text or empty"});
  }
  return columns;
}

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string description_of(const Exported& exported) {
  const bool is_simulated =
      std::any_of(exported.trials.begin(), exported.trials.end(), [](const auto& of_participant) {
        return std::any_of(of_participant.second.begin(), of_participant.second.end(),
                           [](const TrialRow& row) { return !row.following.empty(); });
      });
  return "Trials in which " + counted(exported.trials.size(), "participant") +
         " followed the contours of objects, recorded by Palpate " PALPATE_VERSION
         ". Each row is one attempt at a trial." +
         (is_simulated ? " Rows in which the column following is not empty are of simulated "
                         "operators, not of people."
                       : "");
}

std::string readme_of(const Exported& exported) {
  std::string text = "# " + exported.name + "\n\n" + description_of(exported) +
                     "\n\nThis folder follows Psych-DS " + std::string(kPsychDsVersion) +
                     " (https://psych-ds.github.io). `dataset_description.json` states the unit, "
                     "range, levels and meaning\nof each column.\n\n"
                     "## Files\n\n| file | content |\n|---|---|\n"
                     "| `data/subject-NN_task-contour_data.csv` | the trials of participant NN |\n";
  if (!exported.answers.empty()) {
    text +=
        "| `data/subject-NN_task-questionnaire_data.csv` | what this participant answered after "
        "each condition |\n";
  }
  if (!exported.about.empty()) {
    text += "| `data/task-about_data.csv` | what participants stated about themselves |\n";
  }
  if (!exported.plan.empty()) text += "| `materials/plan.json` | the plan of the experiment |\n";
  if (!exported.texts.empty()) {
    text += "| `materials/texts.json` | the texts that participants read |\n";
  }
  const bool has_pilots = exported.columns == TrialColumns::kLive;
  text +=
      "| `documentation/columns.csv` | the columns of the trials |\n\n"
      "## Rows\n\n"
      "participant, block, haptic, rotation, object, attempt, following, view, align, "
      "start_orientation_deg";
  text += has_pilots ? ", scale and\npilot" : " and\nscale";
  text +=
      " identify a row. An empty field has no value. Block 0 is practice. Of several attempts at a "
      "trial the last one with\nthe status done counts.";
  text += has_pilots ? " Rows with pilot 1 are of a pilot run.\n\n" : "\n\n";
  text +=
      "## What is missing here\n\n"
      "Whoever publishes this folder adds author, citation, license, funder, url, identifier "
      "and privacyPolicy to\n`dataset_description.json`, as far as they exist, and is "
      "responsible for consent and for ethics approval.\nPsych-DS also recommends the folders "
      "`analysis` and `results`, and `.psychds-ignore` for files that its validator should not "
      "read.\n";
  return text;
}

// Writing.

class Folder {
 public:
  explicit Folder(fs::path root) : root_(std::move(root)) {}

  // Does nothing after the first error.
  void add(const fs::path& name, const std::string& text) {
    if (error_ || !make_parent(name)) return;
    auto file = WholeFile::create((root_ / name).string());
    if (!file) {
      error_ = file.error();
      return;
    }
    file->add(text);
    error_ = file->finish();
  }

  void copy(const fs::path& from, const fs::path& name) {
    if (error_ || !make_parent(name)) return;
    std::error_code failed;
    fs::copy_file(from, root_ / name, failed);
    if (failed) error_ = unwritable(root_ / name, failed);
  }

  const std::optional<Error>& error() const { return error_; }

  static Error unwritable(const fs::path& path, const std::error_code& failed) {
    return {ErrorCode::kFileUnwritable, path.string(), "", "cannot be written: " + failed.message(),
            ""};
  }

 private:
  bool make_parent(const fs::path& name) {
    std::error_code failed;
    fs::create_directories((root_ / name).parent_path(), failed);
    if (failed) error_ = unwritable((root_ / name).parent_path(), failed);
    return !error_;
  }

  fs::path root_;
  std::optional<Error> error_;
};

void add_tables(const Exported& exported, Folder& folder) {
  const CsvTable<TrialRow>& table = written_trials_table(exported.columns);
  for (const auto& [number, rows] : exported.trials) {
    CsvLines lines(names_in(table));
    for (const TrialRow& row : rows) write_row(table, row, lines);
    folder.add(fs::path("data") / psych_ds_file(number, "contour"), lines.text());
  }
  for (const auto& [number, rows] : exported.answers) {
    CsvLines lines(names_in(questionnaire_table()));
    for (const QuestionnaireRow& row : rows) add_questionnaire_row(lines, row);
    folder.add(fs::path("data") / psych_ds_file(number, "questionnaire"), lines.text());
  }
  if (exported.about.empty()) return;
  std::string names;
  for (const DescribedColumn& column : about_columns()) {
    names += (names.empty() ? "" : ",") + column.name;
  }
  CsvLines lines(names);
  for (const auto& [number, answers] : exported.about) {
    lines.add(number);
    for (const std::string& answer : answers) lines.add(answer);
    lines.end_line();
  }
  folder.add("data/task-about_data.csv", lines.text());
}

std::vector<DescribedColumn> columns_of(const Exported& exported) {
  std::vector<DescribedColumn> columns = described_columns(written_trials_table(exported.columns));
  const auto add = [&](const std::vector<DescribedColumn>& more) {
    columns.insert(columns.end(), more.begin(), more.end());
  };
  if (!exported.answers.empty()) add(described_columns(questionnaire_table()));
  if (!exported.about.empty()) add(about_columns());
  return columns;
}

// The complete recordings in a folder, sorted. Those that are being written have ".part" in their
// names.
std::vector<fs::path> recordings_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const bool is_complete = entry.path().filename().string().find(".part") == std::string::npos;
    if (is_complete && entry.is_regular_file(failed)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void add_requested(const ExperimentExportRequest& request, const Exported& exported,
                   Folder& folder) {
  for (const auto& [number, of_participant] : exported.folders) {
    const std::string subject = psych_ds_subject(number);
    if (has(request, "recordings")) {
      for (const fs::path& file : recordings_in(of_participant / "recordings")) {
        folder.copy(file, fs::path("data/recordings") / subject / file.filename());
      }
    }
    if (has(request, "notes") && is_there(of_participant / kJournalName)) {
      folder.copy(of_participant / kJournalName,
                  fs::path("documentation/journals") / (subject + ".txt"));
    }
  }
  if (has(request, "recordings")) folder.add(".psychds-ignore", "data/recordings/\n");
}

std::optional<Error> write_folder(const ExperimentExportRequest& request, const Exported& exported,
                                  const fs::path& root) {
  Folder folder(root);
  folder.add("dataset_description.json",
             dataset_description(exported.name, description_of(exported), columns_of(exported)));
  folder.add("README.md", readme_of(exported));
  folder.add("CHANGES.md", "# Changes\n\n## 1.0.0\n\n- Exported.\n");
  folder.add("documentation/columns.csv", columns_csv(exported.columns));
  if (!exported.plan.empty()) folder.add("materials/plan.json", exported.plan);
  if (!exported.texts.empty()) folder.add("materials/texts.json", exported.texts);
  add_tables(exported, folder);
  add_requested(request, exported, folder);
  return folder.error();
}

// Writes into a hidden folder beside the place, and renames it when it is complete. A killed
// process leaves the hidden folder; the next export to the same place removes it.
std::optional<Error> place(const ExperimentExportRequest& request, const Exported& exported) {
  fs::path out = fs::path(request.out_dir).lexically_normal();
  if (!out.has_filename()) out = out.parent_path();
  if (is_there(out)) {
    return Error{ErrorCode::kFileUnwritable, out.string(), "",
                 "exists already; expected a new folder",
                 "choose another name with --out, or remove the folder"};
  }
  if (is_inside(out, request.folder)) {
    return Error{ErrorCode::kFileUnwritable, out.string(), "",
                 "is inside of the folder of the experiment, where `experiment forget` would not "
                 "find it",
                 "choose a folder beside it with --out"};
  }
  const fs::path hidden = out.parent_path() / ("." + out.filename().string() + ".part");
  std::error_code failed;
  fs::remove_all(hidden, failed);
  fs::create_directories(hidden, failed);
  if (failed) return Folder::unwritable(hidden, failed);
  std::optional<Error> error = write_folder(request, exported, hidden);
  if (!error) {
    fs::rename(hidden, out, failed);
    if (failed) error = Folder::unwritable(out, failed);
  }
  if (error) fs::remove_all(hidden, failed);
  return error;
}

}  // namespace

void add_export(CLI::App& experiment, ExperimentExportRequest& request) {
  CLI::App& app = *experiment.add_subcommand(
      "export", "write the trials of an experiment as a folder of Psych-DS, to publish them");
  set_help(app,
           "  ./run.sh experiment plan paper --out plan.json\n"
           "  ./run.sh experiment run plan.json --out experiment\n"
           "  ./run.sh experiment export experiment --out dataset\n",
           "The folder has a table of trials for each participant, questionnaires, the plan, the "
           "texts that\nparticipants read, and dataset_description.json with the unit, range, "
           "levels and meaning of each\ncolumn (Psych-DS 1.5.0). Participants must be numbers. "
           "--with adds what may tell more about people:\nrecordings (their motion), notes (the "
           "journals, with the experimenter's notes and all times) and\nabout (age, gender, hand, "
           "experience). Add author and license before you publish the folder.\n");
  app.add_option("DIR", request.folder, "folder of results, with trials.csv")->required();
  app.add_option("--out", request.out_dir, "folder to write; it must not exist")->required();
  app.add_option("--with", request.with, "recordings, notes, about")
      ->delimiter(',')
      ->type_name("LIST")
      ->check(CLI::IsMember(std::vector<std::string>(kExportParts.begin(), kExportParts.end())));
}

int run_export(const ExperimentExportRequest& request) {
  if (const auto error = check_output()) return refuse(*error);
  const auto exported = read_folder(request);
  if (!exported) return refuse(exported.error());
  if (const auto error = place(request, *exported)) return refuse(*error);
  std::size_t rows = 0;
  for (const auto& [number, of_participant] : exported->trials) rows += of_participant.size();
  std::cout << counted(rows, "row") << " of " << counted(exported->trials.size(), "participant")
            << "\n"
            << request.out_dir << "/ is a folder of Psych-DS " << kPsychDsVersion
            << "; add author and license to dataset_description.json\n";
  return finish_output();
}

}  // namespace palpate
