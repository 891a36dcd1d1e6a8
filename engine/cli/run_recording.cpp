#include "engine/cli/run_recording.h"

#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/command_help.h"
#include "engine/cli/scene_options.h"
#include "engine/recording/recording_settings.h"

namespace palpate {
namespace {

constexpr std::string_view kEnding = ".palpate";

}  // namespace

void add_record(CLI::App& app, std::string& file) {
  app.add_option("--record", file,
                 "record every tick into this new file while the session runs, for `palpate replay "
                 "FILE`; two runs of `run` write NAME-off.palpate and NAME-on.palpate")
      ->type_name("FILE")
      ->group(kOutputGroup);
}

std::string recording_name_of(const std::string& file, bool a4) {
  std::string name = file;
  if (name.ends_with(kEnding)) name.resize(name.size() - kEnding.size());
  return name + (a4 ? "-on" : "-off") + std::string(kEnding);
}

std::optional<Error> check_recording_names(const std::vector<std::string>& files) {
  std::error_code ignored;
  for (const std::string& file : files) {
    if (file.empty()) continue;
    // SQLite writes and removes the files with these endings beside the recording.
    for (const char* const ending : {"", "-wal", "-journal"}) {
      const std::string name = file + ending;
      if (!std::filesystem::exists(std::filesystem::symlink_status(name, ignored))) continue;
      return Error{ErrorCode::kFileUnwritable, name, "", "exists; expected the name of a new file",
                   "remove the file or choose another name"};
    }
  }
  return std::nullopt;
}

std::optional<Error> check_recording_place(const std::string& file, const std::string& out_dir,
                                           const std::vector<std::string>& names) {
  namespace fs = std::filesystem;
  if (file.empty()) return std::nullopt;
  std::error_code failed;
  const fs::path place = fs::weakly_canonical(fs::absolute(file, failed), failed);
  for (const std::string& name : names) {
    if (fs::weakly_canonical(fs::absolute(fs::path(out_dir) / name, failed), failed) != place) {
      continue;
    }
    return invalid_argument("--record", "is \"" + file +
                                            "\", which the run itself writes; expected "
                                            "another file");
  }
  return std::nullopt;
}

Result<std::unique_ptr<Recorder>> make_recorder(const std::string& file,
                                                const SceneOptions& options, const Scene& scene,
                                                const RunSetup& setup, bool virtual_time,
                                                const std::string& allow_unstable) {
  if (file.empty()) return std::unique_ptr<Recorder>();
  RecordedSetup recorded;
  recorded.scene_path = options.path;
  SceneOptions scaled = options;  // its --fit auto has become a scale
  scaled.fits_workspace = false;
  auto scene_settings = scene_settings_of(scaled, setup.haptics.god_object.radius_m);
  if (!scene_settings) return scene_settings.error();
  recorded.scene = std::move(*scene_settings);
  recorded.scene.scale = scene.statistics().scale;
  recorded.scene.fit_size_m = 0.0;
  recorded.actuation = setup.actuation;
  recorded.haptics = setup.haptics;
  recorded.dt_s = setup.dt_s;
  recorded.virtual_time = virtual_time;
  recorded.allow_unstable = allow_unstable;
  const auto meta = meta_of(scene, recorded);
  if (!meta) return meta.error();
  RecorderSettings settings;
  settings.rate_Hz = 1.0 / setup.dt_s;
  settings.virtual_time = virtual_time;
  return Recorder::create(file, *meta, settings);
}

std::optional<RecordingResult> finish_recording(std::unique_ptr<Recorder> recorder,
                                                const std::string& why) {
  if (!recorder) return std::nullopt;
  RecordingResult result = recorder->finish(why);
  if (result.ticks > 0 || result.error) return result;
  std::error_code ignored;
  std::filesystem::remove(result.path, ignored);
  return std::nullopt;
}

std::string recording_text(const RecordingResult& recording) {
  std::ostringstream text;
  text << "recording in " << recording.path << ": " << recording.ticks << " ticks, "
       << recording.bytes << " bytes";
  if (recording.dropped > 0) text << ", " << recording.dropped << " ticks dropped";
  if (recording.error) text << "; it ended before the session: " << recording.error->problem;
  if (recording.has_log) {
    text << "; the log " << recording.path << "-wal is a part of it, because the disk has no space "
         << "for one file";
  }
  return text.str() + "\n";
}

nlohmann::ordered_json recording_json(const std::vector<RecordingResult>& recordings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RecordingResult& r : recordings) {
    json.push_back(
        {{"file", r.path},
         {"ticks", r.ticks},
         {"dropped", r.dropped},
         {"bytes", r.bytes},
         {"log", r.has_log ? nlohmann::ordered_json(r.path + "-wal") : nlohmann::ordered_json()},
         {"problem",
          r.error ? nlohmann::ordered_json(r.error->to_string()) : nlohmann::ordered_json()}});
  }
  return json;
}

std::vector<std::string> recording_warnings(const std::vector<RecordingResult>& recordings) {
  std::vector<std::string> warnings;
  for (const RecordingResult& r : recordings) {
    if (r.error) warnings.push_back("the recording ended: " + r.error->to_string());
    if (r.dropped > 0) {
      warnings.push_back(r.path + ": " + std::to_string(r.dropped) +
                         " ticks were dropped, because the disk did not keep up");
    }
  }
  return warnings;
}

}  // namespace palpate
