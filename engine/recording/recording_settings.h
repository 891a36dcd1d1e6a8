#pragma once

// The settings of a recorded session as keys and values, and back.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/recording/recording_meta.h"
#include "engine/recording/recording_schema.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setting.h"
#include "engine/session/tick_sink.h"
#include "geometry/base/result.h"

namespace palpate {

// A file that loading the scene read.
struct RecordedFile {
  std::string name;  // relative to the folder of the scene's file
  std::uint64_t bytes = 0;
  std::string sha256;
};

// What a session computes with, apart from the device.
struct RecordedSetup {
  std::string scene_path;  // as the user stated it
  SceneSettings scene;     // with the applied scale
  ActuationModel actuation = *ActuationModel::from_counts(3, 3);
  HapticSettings haptics;
  double dt_s = 1e-3;
  bool virtual_time = false;
  // Why the person allowed a stiffness that is not stable on the device; empty: nobody did.
  std::string allow_unstable = {};
};

// All that a recording states about its session.
struct RecordedSession {
  std::string engine;               // version
  int version = kRecordingVersion;  // of the format, as the table of columns has it
  std::string build;
  RecordedSetup setup;
  std::string scene_place;  // absolute path of the scene's file when it was recorded
  std::vector<RecordedFile> files;
  DeviceDescription device;
  std::optional<double> max_force_N;
  bool takes_motors = true;
  GovernorSettings governor;
};

// The version of this engine, as recordings state it.
const char* engine_version();

// The length and the SHA-256 of each file that loading this scene read. Returns an error if one of
// them cannot be read any more.
Result<std::vector<RecordedFile>> files_of(const Scene& scene, const std::string& path);

// The meta of a recording that begins. setup.scene.scale: see scene.statistics().scale.
Result<RecordingMeta> meta_of(const Scene& scene, const RecordedSetup& setup,
                              RunSettingTable table = run_settings());
// What the start of the session adds.
RecordingMeta meta_of(const SessionFacts& facts);

// Reads the meta of a file that may be hostile: every value must be there, of its type, and in its
// range; the caller still checks the settings as those of any run. Error::element is the key.
Result<RecordedSession> session_of(const RecordingMeta& meta,
                                   RunSettingTable table = run_settings());

}  // namespace palpate
