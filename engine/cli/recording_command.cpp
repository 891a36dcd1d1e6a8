// The subcommand `recording`: describes, checks, repairs and exports recordings.

#include <algorithm>
#include <array>
#include <cstring>
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
#include "engine/cli/start_inside_report.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_overview.h"
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
  RecordingOverview overview;
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
  d.overview = overview_of(reader);
  return d;
}

std::string ending_text(const std::optional<RecordedEnding>& ending) {
  if (!ending) return "no ending: the process died\n";
  std::ostringstream text;
  text << "ended with " << ending->ticks << " ticks, " << ending->dropped
       << " dropped: " << ending->why << "\n";
  return text.str();
}

// How a strategy is named, also where force and A4 describe it.
std::string strategy_words(const HapticSettings& haptics) {
  if (haptics.strategy) return name_of(*haptics.strategy);
  constexpr std::array kForces = {"none", "actuated", "full"};
  return std::string("A4 ") + (haptics.a4.enabled ? "on" : "off") + ", force " +
         kForces[static_cast<std::size_t>(haptics.force)] + ", at the start";
}

// Two columns.
class SummaryLines {
 public:
  void add(const char* name, const std::string& value) {
    text_ += "  " + std::string(name) + std::string(kNames - std::strlen(name), ' ') + value + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  static constexpr std::size_t kNames = 14;
  std::string text_;
};

// dt_s: the length of the last tick.
std::string length_words(const RecordingOverview& o, double dt_s) {
  if (!o.last_time_s) return "0 ticks";
  std::ostringstream text;
  text << *o.last_time_s + dt_s << " s, " << o.ticks << " ticks";
  return text.str();
}

std::string device_words(const RecordedSession& session) {
  const DeviceDescription& device = session.device;
  const int actuators = session.setup.actuation.actuators();
  return printable(device.name) + ", " + std::to_string(device.sensed_axes) + " sensors, " +
         std::to_string(actuators) + (actuators == 1 ? " actuator" : " actuators") +
         (device.moves_motors ? ", with motors" : ", without real motors");
}

std::string gap_words(const RecordingOverview& o) {
  if (o.gaps == 0) return "none";
  return std::to_string(o.missing) + " ticks missing in " + std::to_string(o.gaps) +
         (o.gaps == 1 ? " gap" : " gaps");
}

// The events of a kind, as far as the table has them.
std::string event_words(const RecordingDescription& d, const std::string& kind) {
  const auto count = std::count_if(d.events.begin(), d.events.end(),
                                   [&](const EventRow& e) { return e.kind == kind; });
  const bool are_all = d.events.size() < kMostShownEvents &&
                       std::none_of(d.events.begin(), d.events.end(),
                                    [](const EventRow& e) { return e.kind == "more"; });
  return std::to_string(count) + (are_all ? "" : " or more");
}

// The newest event of a hand that began inside a closed surface; null if there is none.
const EventRow* start_inside_of(const RecordingDescription& d) {
  const auto newest = std::find_if(d.events.rbegin(), d.events.rend(),
                                   [](const EventRow& e) { return e.kind == kInsideEvent; });
  return newest == d.events.rend() ? nullptr : &*newest;
}

// What of the scene's file was loaded, where it is not the default.
void add_loaded_part(const SceneSettings& scene, SummaryLines& lines) {
  if (!scene.listed_scene.empty()) lines.add("listed scene", printable(scene.listed_scene));
  if (!scene.node.empty()) lines.add("node", printable(scene.node));
  if (scene.feels_hidden) lines.add("hidden nodes", "felt");
}

void add_session(const RecordingDescription& d, SummaryLines& lines) {
  const auto session = session_of(d.meta);
  lines.add("length", length_words(d.overview, session ? session->setup.dt_s : 0.0));
  if (!session) {
    lines.add("settings", "cannot be used: " + printable(session.error().element) + " " +
                              printable(session.error().problem));
    return;
  }
  std::ostringstream rate;
  rate << 1.0 / session->setup.dt_s << " Hz, "
       << (session->setup.virtual_time ? "simulated time" : "real time");
  lines.add("rate", rate.str());
  lines.add("scene", printable(session->setup.scene_path));
  add_loaded_part(session->setup.scene, lines);
  lines.add("strategy", strategy_words(session->setup.haptics));
  lines.add("device", device_words(*session));
  lines.add("recorded by", "version " + printable(session->engine));
}

std::string events_text(const RecordingDescription& d) {
  std::ostringstream text;
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

// The reason of --allow-unstable; null: the session did not have it.
const std::string* allowed_unstable(const RecordingDescription& d) {
  const auto found = d.meta.find("allow_unstable");
  return found == d.meta.end() ? nullptr : std::get_if<std::string>(&found->second);
}

// With_keys: also every key of the settings.
std::string info_text(const RecordingReader& reader, const RecordingDescription& d,
                      bool with_keys) {
  std::ostringstream text;
  text << printable(reader.path()) << ": " << reader.bytes() << " bytes"
       << (reader.has_log() ? ", with a log beside it (-wal)" : "") << "\n";
  SummaryLines lines;
  add_session(d, lines);
  if (const EventRow* inside = start_inside_of(d)) lines.add("start", inside->detail);
  if (const std::string* reason = allowed_unstable(d)) {
    lines.add("stiffness", "unstable, and allowed, because: " + printable(*reason));
  }
  lines.add("gaps", gap_words(d.overview));
  lines.add("trips", event_words(d, "trip"));
  const auto session = session_of(d.meta);
  const bool has_deadlines = !session || !session->setup.virtual_time;
  lines.add("late ticks", has_deadlines ? event_words(d, "late") : "-");
  lines.add("ended", d.ending ? printable(d.ending->why) + " (" + std::to_string(d.ending->ticks) +
                                    " ticks, " + std::to_string(d.ending->dropped) + " dropped)"
                              : std::string("no ending: the process died"));
  if (d.overview.is_broken) lines.add("broken", "a block cannot be read; see recording check");
  text << lines.text() << events_text(d);
  if (!with_keys) return text.str();
  for (const auto& [key, value] : d.meta) {
    text << "  " << printable(key.substr(0, kShownText)) << ": " << meta_text(value) << "\n";
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
  json["ticks"] = d.overview.ticks;
  json["gaps"] = d.overview.gaps;
  json["missing"] = d.overview.missing;
  json["last_time_s"] = d.overview.last_time_s ? nlohmann::ordered_json(*d.overview.last_time_s)
                                               : nlohmann::ordered_json();
  const EventRow* const inside = start_inside_of(d);
  json["start_inside"] = inside ? nlohmann::ordered_json(inside->detail) : nlohmann::ordered_json();
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

// Shows the progress of work that takes a RecordingProgress. The line is gone when this returns.
template <typename Work>
Result<RecordingCheck> with_progress(const char* label, const Work& work) {
  ProgressBar bar(label);
  return work([&bar](double share) { bar.show(share); });
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
  bool with_keys_ = false;
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
  add("info", "print a summary: length, scene, strategy, device, gaps, trips, ending and events",
      (record + "  ./run.sh recording info star.palpate\n").c_str())
      .add_flag("--keys", with_keys_, "also print every key of the settings, as --json does");
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
      text += info_text(*reader, *description, with_keys_);
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
    const auto checked = with_progress("recording check", [&](const RecordingProgress& progress) {
      return check_recording(*reader, progress);
    });
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
  const auto checked = with_progress(repairs ? "recording repair" : "recording export",
                                     [&](const RecordingProgress& progress) {
                                       return repairs ? repair_recording(*reader, out_, progress)
                                                      : export_recording(*reader, csv_, progress);
                                     });
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
