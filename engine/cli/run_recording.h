#pragma once

// `--record`: the recordings of the runs of a command.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include "engine/recording/recorder.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

struct SceneOptions;

// Adds --record. file: empty without the option.
void add_record(CLI::App& app, std::string& file);

// The file of one of two runs: NAME-off.palpate or NAME-on.palpate for NAME or NAME.palpate.
std::string recording_name_of(const std::string& file, bool a4);

// An error if one of the files exists, or one that SQLite would write beside it.
std::optional<Error> check_recording_names(const std::vector<std::string>& files);

// An error if the recording would be one of the files that the command itself writes.
std::optional<Error> check_recording_place(const std::string& file, const std::string& out_dir,
                                           const std::vector<std::string>& names);

// A recorder for a session with this scene and setup. Null if file is empty. allow_unstable: see
// DeviceRequest.
Result<std::unique_ptr<Recorder>> make_recorder(const std::string& file,
                                                const SceneOptions& options, const Scene& scene,
                                                const RunSetup& setup, bool virtual_time,
                                                const std::string& allow_unstable = {});

// Ends a recording; no value for null. why: "end", "interrupted" or "trip". A recording without a
// tick is removed, because its session has not begun.
std::optional<RecordingResult> finish_recording(std::unique_ptr<Recorder> recorder,
                                                const std::string& why);

// One line on the recording, with its end.
std::string recording_text(const RecordingResult& recording);
nlohmann::ordered_json recording_json(const std::vector<RecordingResult>& recordings);
// One line for each recording that ended before its session.
std::vector<std::string> recording_warnings(const std::vector<RecordingResult>& recordings);

}  // namespace palpate
