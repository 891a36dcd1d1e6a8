#include "engine/cli/recorded_replay.h"

#include <cstdio>
#include <iostream>
#include <sstream>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/option_names.h"
#include "engine/cli/run_report.h"
#include "engine/cli/setting_texts.h"
#include "engine/cli/strategy_option.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_replay.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr int kDiffers = 1;

// The governor would drop what the recorded motors cannot push. The simulated hand's device gets a
// motor on every axis for `full`, as in `run`; the motors of other devices are what they are.
std::optional<Error> apply_strategy(const Strategy& strategy, RecordedSession& session) {
  DeviceDescription& device = session.device;
  if (strategy.type->force == ForceMode::kFull && !device.moves_motors) {
    give_all_motors(device, device.sensed_axes);
  }
  if (auto error = check_motors(strategy, device)) return error;
  set_strategy(strategy, session.setup.haptics);
  return std::nullopt;
}

// Requires a setting of HapticSettings that is no OwnSetting.
void copy_value(const RunSetting& setting, HapticSettings& from, HapticSettings& to) {
  std::visit(
      [&](const auto& place) {
        using Place = std::decay_t<decltype(place)>;
        if constexpr (std::is_same_v<Place, SettingChoice>) {
          place.put(to, place.get(from));
        } else if constexpr (!std::is_same_v<Place, OwnSetting>) {
          place.in_haptics(to) = place.in_haptics(from);
        }
      },
      setting.value);
}

// Changes the settings of the recording as the request states.
std::optional<Error> apply_request(const RecordedReplayRequest& request, RecordedSession& session) {
  HapticSettings& haptics = session.setup.haptics;
  if (request.a4 || request.changes("--force")) haptics.strategy.reset();
  if (request.strategy) {
    if (auto error = apply_strategy(*request.strategy, session)) return error;
  }
  if (request.a4) haptics.a4.enabled = *request.a4;
  if (request.changes("--align")) {
    const int actuators = session.setup.actuation.actuators();
    const Alignment align = request.settings.haptics.a4.align;
    if (auto error = check_align(align, haptics.a4.table1, actuators)) {
      error->path = request.recording;
      error->hint = "a recording keeps its motors and its Table 1";
      return error;
    }
  }
  RunSettings wanted = request.settings;
  for (const std::string& option : request.changed) {
    copy_value(run_setting(option), wanted.haptics, haptics);
  }
  auto overrides = parse_overrides(request.materials);
  if (!overrides) return overrides.error();
  auto& all = session.setup.scene.overrides;
  all.insert(all.end(), overrides->begin(), overrides->end());
  return std::nullopt;
}

ReplayChange change_of(const RecordedReplayRequest& request) {
  ReplayChange change;
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    change.ignores[i] = request.changes(kLiveSettings[i].of_run().option) ||
                        (kLiveSettings[i].is_of_strategy && request.strategy);
  }
  if (request.a4) change.ignores[live_setting("a4")] = true;
  change.has_all_motors =
      (request.changes("--force") && request.settings.haptics.force == ForceMode::kFull) ||
      (request.strategy && request.strategy->type->force == ForceMode::kFull);
  change.ignores_effects = !request.materials.empty();
  return change;
}

std::string version_line(const RecordedSession& session) {
  if (session.engine == engine_version()) return {};
  return "recorded by version " + printable(session.engine) + "; this is version " +
         engine_version() + "\n";
}

// What replay proved, and what it did not.
std::string proof_text(const ReplayOutcome& outcome) {
  std::ostringstream text;
  text << outcome.proved << " ticks computed again, each with the same bits\n";
  if (outcome.difference) {
    const ReplayDifference& d = *outcome.difference;
    text << "tick " << d.tick << ", " << d.column << ": recorded " << d.recorded << ", computed "
         << d.computed << "\n";
  }
  if (outcome.stopped) text << "replay stops: " << *outcome.stopped << "\n";
  if (!outcome.ending) text << "the recording has no ending: its process died\n";
  if (outcome.ending && outcome.ending->why == kDiskFull) {
    text << "the recording ended before its session: " << kDiskFull << "\n";
  }
  return text.str();
}

nlohmann::ordered_json outcome_json(const ReplayOutcome& outcome, const RecordedSession& session) {
  nlohmann::ordered_json json{{"recorded_by", session.engine},
                              {"replayed_by", engine_version()},
                              {"proved_ticks", outcome.proved},
                              {"difference", nullptr},
                              {"stopped", nullptr},
                              {"ending", nullptr}};
  if (const auto& d = outcome.difference) {
    json["difference"] = {{"tick", d->tick},
                          {"column", d->column},
                          {"recorded", d->recorded},
                          {"computed", d->computed}};
  }
  if (outcome.stopped) json["stopped"] = *outcome.stopped;
  if (const auto& e = outcome.ending) {
    json["ending"] = {{"ticks", e->ticks}, {"dropped", e->dropped}, {"why", e->why}};
  }
  return json;
}

// One line of the table: its name, and its value in both summaries.
struct SummaryRow {
  const char* name;
  std::string (*value)(const RunSummary&);
};

std::string four_digits(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", number);
  return text;
}

std::string digits_or_dash(const RunSummary& s, double number) {
  return s.has_contact() ? four_digits(number) : "-";
}

std::uint64_t fault_count(const RunSummary& s) {
  std::uint64_t count = 0;
  for (const std::uint64_t ticks : s.faults) count += ticks;
  return count;
}

constexpr SummaryRow kSummaryRows[] = {
    {"ticks", [](const RunSummary& s) { return std::to_string(s.ticks); }},
    {"ticks in contact", [](const RunSummary& s) { return std::to_string(s.contact_ticks); }},
    {"losses of contact", [](const RunSummary& s) { return std::to_string(s.losses_of_contact); }},
    {"mean penetration, mm",
     [](const RunSummary& s) { return digits_or_dash(s, 1e3 * s.mean_penetration_m); }},
    {"largest penetration, mm",
     [](const RunSummary& s) { return digits_or_dash(s, 1e3 * s.max_penetration_m); }},
    {"mean contact angle, deg",
     [](const RunSummary& s) { return digits_or_dash(s, s.mean_contact_angle_deg); }},
    {"within 30 deg, %",
     [](const RunSummary& s) { return digits_or_dash(s, 100 * s.share_within_30deg); }},
    {"work of missing motors, mJ",
     [](const RunSummary& s) { return four_digits(1e3 * s.work_lost_J); }},
    {"energy returned, mJ", [](const RunSummary& s) { return four_digits(1e3 * s.port_work_J); }},
    {"ticks turned by A4", [](const RunSummary& s) { return std::to_string(s.a4_ticks); }},
    {"faults", [](const RunSummary& s) { return std::to_string(fault_count(s)); }},
};

std::string what_if_text(const ReplayOutcome& outcome) {
  std::ostringstream text;
  const auto line = [&](const std::string& name, const std::string& a, const std::string& b) {
    char buffer[128];
    std::snprintf(buffer, sizeof buffer, "%-29s  %18s  %18s\n", name.c_str(), a.c_str(), b.c_str());
    text << buffer;
  };
  line("", "recorded", "what if");
  for (const SummaryRow& row : kSummaryRows)
    line(row.name, row.value(outcome.recorded), row.value(outcome.computed));
  text << "open loop: the hand follows its recorded path; a hand that felt the other force would "
          "have moved differently\n";
  if (outcome.ignored_inputs > 0) {
    text << outcome.ignored_inputs << " recorded switches of these settings were ignored\n";
  }
  if (outcome.stopped) text << "replay stops: " << *outcome.stopped << "\n";
  return text.str();
}

int report_what_if(const RecordedReplayRequest& request, const RecordedSession& session,
                   const ReplayOutcome& outcome, const Scene& scene) {
  if (request.json) {
    nlohmann::ordered_json json{{"recorded_by", session.engine},
                                {"replayed_by", engine_version()},
                                {"open_loop", true},
                                {"ignored_inputs", outcome.ignored_inputs}};
    json["recorded"] = summary_json(outcome.recorded, scene);
    json["what_if"] = summary_json(outcome.computed, scene);
    json["stopped"] =
        outcome.stopped ? nlohmann::ordered_json(*outcome.stopped) : nlohmann::ordered_json();
    print(json);
  } else {
    std::cout << version_line(session) << what_if_text(outcome);
  }
  const int code = finish_output();
  return code == 0 && outcome.stopped ? kDiffers : code;
}

}  // namespace

int replay_recorded(const RecordedReplayRequest& request) {
  const auto reader = RecordingReader::open(request.recording);
  if (!reader) return refuse(reader.error());
  const auto meta = reader->meta();
  if (!meta) return refuse(meta.error());
  auto session = session_of(*meta);
  if (!session) {
    Error error = session.error();
    error.path = request.recording;
    return refuse(error);
  }
  if (const auto error = apply_request(request, *session)) return refuse(*error);
  const auto scene = load_recorded_scene(*session, request.scene);
  if (!scene) return refuse(scene.error());
  ReplayOptions options;
  if (request.asks_what_if()) options.change = change_of(request);
  const auto outcome = [&] {
    ProgressBar bar("replay");
    options.progress = [&bar](double share) { bar.show(share); };
    return replay_recording(*reader, *session, *scene, options);
  }();
  if (!outcome) return refuse(outcome.error());
  if (request.asks_what_if()) return report_what_if(request, *session, *outcome, *scene);
  if (request.json) {
    print(outcome_json(*outcome, *session));
  } else {
    std::cout << version_line(*session) << proof_text(*outcome);
  }
  const int code = finish_output();
  return code == 0 && (outcome->difference || outcome->stopped) ? kDiffers : code;
}

}  // namespace palpate
