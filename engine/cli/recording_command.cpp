// The subcommand `recording`: describes, checks, repairs and exports recordings.

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/run_recording.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_reader.h"
#include "engine/recording/recording_settings.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr int kNotWhole = 1;
constexpr std::size_t kShownEvents = 20;          // as text
constexpr std::size_t kMostShownEvents = 10'000;  // as JSON
constexpr std::size_t kShownText = 100;

std::string meta_text(const MetaValue& value) {
  std::ostringstream text;
  text.precision(17);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    text << *integer;
  } else if (const auto* number = std::get_if<double>(&value)) {
    text << *number;
  } else {
    const std::string shown = printable(std::get<std::string>(value));
    text << (shown.size() <= kShownText ? shown : printable(shown.substr(0, kShownText)) + " ...");
  }
  return text.str();
}

nlohmann::ordered_json meta_json(const MetaValue& value) {
  return std::visit([](const auto& v) { return nlohmann::ordered_json(v); }, value);
}

// What `info` shows of one recording.
struct RecordingDescription {
  RecordingMeta meta;
  std::optional<RecordedEnding> ending;
  std::vector<EventRow> events;
  std::optional<std::int64_t> last_block;
};

Result<RecordingDescription> describe_recording(const RecordingReader& reader) {
  RecordingDescription d;
  auto meta = reader.meta();
  if (!meta) return meta.error();
  d.meta = std::move(*meta);
  auto ending = reader.ending();
  if (!ending) return ending.error();
  d.ending = std::move(*ending);
  auto events = reader.events(kMostShownEvents);
  if (!events) return events.error();
  d.events = std::move(*events);
  const auto last = reader.last_block();
  if (!last) return last.error();
  d.last_block = *last;
  return d;
}

std::string ending_text(const std::optional<RecordedEnding>& ending) {
  if (!ending) return "no ending: the process died\n";
  std::ostringstream text;
  text << "ended with " << ending->ticks << " ticks, " << ending->dropped
       << " dropped: " << ending->why << "\n";
  return text.str();
}

std::string info_text(const RecordingReader& reader, const RecordingDescription& d) {
  std::ostringstream text;
  text << printable(reader.path()) << ": " << reader.bytes() << " bytes"
       << (reader.has_log() ? ", with the log of a process that died" : "") << "\n  "
       << ending_text(d.ending);
  if (d.last_block) text << "  the last block begins with tick " << *d.last_block << "\n";
  for (const auto& [key, value] : d.meta) {
    text << "  " << printable(key.substr(0, kShownText)) << ": " << meta_text(value) << "\n";
  }
  for (std::size_t i = 0; i < std::min(d.events.size(), kShownEvents); ++i) {
    const EventRow& e = d.events[i];
    text << "  tick " << e.tick << ", " << e.time_s << " s: " << e.kind << " " << e.detail << "\n";
  }
  if (d.events.size() > kShownEvents) {
    text << "  " << d.events.size() - kShownEvents
         << (d.events.size() == kMostShownEvents ? " or more" : "")
         << " further events; --json lists them\n";
  }
  return text.str();
}

nlohmann::ordered_json ending_json(const std::optional<RecordedEnding>& ending) {
  if (!ending) return nullptr;
  return {{"ticks", ending->ticks}, {"dropped", ending->dropped}, {"why", ending->why}};
}

nlohmann::ordered_json info_json(const RecordingReader& reader, const RecordingDescription& d) {
  nlohmann::ordered_json json{{"file", reader.path()},
                              {"bytes", reader.bytes()},
                              {"has_log", reader.has_log()},
                              {"ending", ending_json(d.ending)}};
  json["meta"] = nlohmann::ordered_json::object();
  for (const auto& [key, value] : d.meta) json["meta"][key] = meta_json(value);
  json["events"] = nlohmann::ordered_json::array();
  for (const EventRow& e : d.events) {
    json["events"].push_back(
        {{"tick", e.tick}, {"time_s", e.time_s}, {"kind", e.kind}, {"detail", e.detail}});
  }
  return json;
}

std::string check_text(const std::string& path, const RecordingCheck& check) {
  std::ostringstream text;
  text << printable(path) << ": " << check.blocks << " blocks, " << check.ticks << " ticks, "
       << check.inputs << " inputs, whose checksums hold\n  " << ending_text(check.ending);
  for (const TickRange& gap : check.gaps) {
    text << "  ticks " << gap.first << " to " << gap.first + gap.count - 1 << " are missing\n";
  }
  if (check.missing > 0) text << "  " << check.missing << " ticks are missing\n";
  for (const std::string& problem : check.problems) text << "  " << printable(problem) << "\n";
  return text.str();
}

nlohmann::ordered_json check_json(const std::string& path, const RecordingCheck& check) {
  nlohmann::ordered_json json{{"file", path},
                              {"whole", check.is_whole()},
                              {"blocks", check.blocks},
                              {"ticks", check.ticks},
                              {"inputs", check.inputs},
                              {"missing", check.missing},
                              {"ending", ending_json(check.ending)},
                              {"problems", check.problems}};
  json["gaps"] = nlohmann::ordered_json::array();
  for (const TickRange& gap : check.gaps) {
    json["gaps"].push_back({{"first", gap.first}, {"count", gap.count}});
  }
  return json;
}

// What is wrong with the settings; no value if they can be replayed.
std::optional<std::string> settings_problem(const RecordingReader& reader) {
  const auto meta = reader.meta();
  if (!meta) return "settings: " + meta.error().problem;
  const auto session = session_of(*meta);
  if (session) return std::nullopt;
  return "settings: " + session.error().element + " " + session.error().problem;
}

class RecordingCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override;

 private:
  CLI::App& add(const char* name, const char* help, const char* example);
  int info();
  int check();
  int copy(bool repairs);

  CLI::App* app_ = nullptr;
  std::vector<std::string> files_;
  std::string out_;
  std::string csv_;
  bool json_ = false;
};

CLI::App& RecordingCommand::add(const char* name, const char* help, const char* example) {
  CLI::App& app = *app_->add_subcommand(name, help);
  set_help(app, example);
  app.add_option("FILE", files_, "recordings, as --record writes them")->required();
  app.add_flag("--json", json_, "print as JSON");
  return app;
}

CLI::App* RecordingCommand::add_to(CLI::App& program) {
  app_ = program.add_subcommand("recording", "describe, check, repair or export recordings");
  app_->require_subcommand(1);
  const std::string record =
      "  ./run.sh run models/star.glb --virtual --a4 on "
      "--record star.palpate\n";
  set_help(*app_, record + "  ./run.sh recording check star.palpate\n",
           "./run.sh recording COMMAND --help lists the options of a command.\n");
  add("info", "print settings, ending and events",
      (record + "  ./run.sh recording info star.palpate\n").c_str());
  add("check", "prove every checksum and list what is missing; exit code 1 if something is",
      (record + "  ./run.sh recording check star.palpate\n").c_str());
  add("repair", "copy each block that can be read; the original is not changed",
      (record + "  ./run.sh recording repair star.palpate --out copy.palpate\n").c_str())
      .add_option("--out", out_, "the new file")
      ->required();
  add("export", "write the trace that run would have written",
      (record + "  ./run.sh recording export star.palpate --csv trace.csv\n").c_str())
      .add_option("--csv", csv_, "CSV file of the trace")
      ->required();
  return app_;
}

int RecordingCommand::info() {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  std::string text;
  for (const std::string& file : files_) {
    const auto reader = RecordingReader::open(file);
    if (!reader) return refuse(reader.error());
    const auto description = describe_recording(*reader);
    if (!description) return refuse(description.error());
    if (json_) {
      all.push_back(info_json(*reader, *description));
    } else {
      text += info_text(*reader, *description);
    }
  }
  if (json_) {
    print(all);
  } else {
    std::cout << text;
  }
  return finish_output();
}

int RecordingCommand::check() {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  bool is_whole = true;
  for (const std::string& file : files_) {
    const auto reader = RecordingReader::open(file);
    if (!reader) return refuse(reader.error());
    const auto checked = check_recording(*reader);
    if (!checked) return refuse(checked.error());
    RecordingCheck all_checked = *checked;
    if (const auto problem = settings_problem(*reader)) {
      ++all_checked.problem_count;
      all_checked.problems.push_back(*problem);
    }
    is_whole = is_whole && all_checked.is_whole();
    if (json_) {
      all.push_back(check_json(file, all_checked));
    } else {
      std::cout << check_text(file, all_checked);
    }
  }
  if (json_) print(all);
  const int code = finish_output();
  return code == 0 && !is_whole ? kNotWhole : code;
}

// Makes a copy without what is broken.
int RecordingCommand::copy(bool repairs) {
  if (files_.size() != 1) {
    return refuse(invalid_argument(
        "FILE", "is given " + std::to_string(files_.size()) + " times; expected one recording"));
  }
  const auto reader = RecordingReader::open(files_.front());
  if (!reader) return refuse(reader.error());
  if (repairs) {
    if (const auto error = check_recording_names({out_})) return refuse(*error);
  }
  const auto checked = repairs ? repair_recording(*reader, out_) : export_recording(*reader, csv_);
  if (!checked) return refuse(checked.error());
  if (json_) {
    print(check_json(files_.front(), *checked));
  } else {
    std::cout << check_text(files_.front(), *checked);
  }
  const int code = finish_output();
  return code == 0 && !repairs && !checked->is_whole() ? kNotWhole : code;
}

int RecordingCommand::run(const std::vector<std::string>&) {
  if (app_->got_subcommand("info")) return info();
  if (app_->got_subcommand("check")) return check();
  return copy(app_->got_subcommand("repair"));
}

}  // namespace

std::unique_ptr<Command> make_recording_command() {
  return std::make_unique<RecordingCommand>();
}

}  // namespace palpate
