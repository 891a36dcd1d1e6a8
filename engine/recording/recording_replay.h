#pragma once

// Computes a recorded session again.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/recording/recording_reader.h"
#include "engine/recording/recording_settings.h"
#include "engine/scene/scene.h"
#include "engine/session/live_setting.h"
#include "engine/session/run_summary.h"
#include "geometry/base/result.h"

namespace palpate {

// The first number that replay computed with other bits than the recording holds.
struct ReplayDifference {
  std::uint64_t tick = 0;
  std::string column;
  std::string recorded;
  std::string computed;
};

// What a replay does otherwise than the recording: recorded switches of these settings are ignored.
struct ReplayChange {
  std::array<bool, kLiveSettings.size()> ignores = {};  // by the place in kLiveSettings
  bool ignores_effects = false;
  // Every sensed axis has a motor, as with a device for ForceMode::kFull; the recorded motors are
  // ignored.
  bool has_all_motors = false;
};

struct ReplayOutcome {
  std::uint64_t proved = 0;  // ticks that were computed, before a difference or a gap
  std::optional<ReplayDifference> difference;
  // Why replay stopped before the end: the state behind a gap or a broken block is unknown.
  std::optional<std::string> stopped;
  std::optional<RecordedEnding> ending;  // no value after a crash
  std::uint64_t ignored_inputs = 0;      // by ReplayChange
  RunSummary recorded;                   // of the same ticks, without step times
  RunSummary computed;
};

// What a replay may do beside computing.
struct ReplayOptions {
  // No value: the recording is proved, and replay stops at the first difference. Otherwise it runs
  // to the end with `setup` as changed, and compares nothing.
  std::optional<ReplayChange> change = {};
  // Leaves out the inputs of this kind, for tests.
  std::optional<InputKind> left_out = {};
  // Called after each block with the share of the recording that is done; may be empty.
  std::function<void(double)> progress = {};
};

// Runs the samples, times and inputs of a recording through the road of a session, with the
// recorded clock, and compares the computed columns bit for bit.
//
// Returns an error if a setting is refused as it is for any run, or if an input does not fit the
// scene. Only the memory of one block and of the summaries is taken.
Result<ReplayOutcome> replay_recording(const RecordingReader& reader,
                                       const RecordedSession& session, const Scene& scene,
                                       const ReplayOptions& options = {});

// Loads the scene of a recording. moved: where the file is now; empty: where it was. Returns an
// error that names the file if one of the files has changed.
Result<Scene> load_recorded_scene(const RecordedSession& session, const std::string& moved = {});

}  // namespace palpate
