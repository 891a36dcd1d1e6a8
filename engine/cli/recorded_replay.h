#pragma once

// `replay FILE`: proves a recording, or answers what the same path gives under other settings.

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/run_setting.h"

namespace palpate {

// Options of settings (run_setting.h) of which a recording can be replayed with another value.
inline constexpr std::array<std::string_view, 5> kChangedByReplay = {
    "--align", "--force", "--accuracy", "--stiffness", "--damping"};

// The settings that are given differ from those of the recording.
struct RecordedReplayRequest {
  std::string recording;
  std::string scene;  // where the scene is now; empty: where it was
  bool json = false;
  std::vector<std::string> materials;  // "NAME.key=value" each
  std::optional<Strategy> strategy = {};
  // This, or --force, ends the strategy of the recording, if it has one that is more than force and
  // A4.
  std::optional<bool> a4 = {};
  std::vector<std::string> changed = {};  // the given options of kChangedByReplay
  RunSettings settings = {};              // with their values

  bool changes(std::string_view option) const {
    return std::find(changed.begin(), changed.end(), option) != changed.end();
  }
  bool asks_what_if() const { return !materials.empty() || strategy || a4 || !changed.empty(); }
};

// Returns the exit code: 0: every bit was the same, or the question was answered; 1: a bit
// differed, or the replay could not go on; 2: refused.
int replay_recorded(const RecordedReplayRequest& request);

}  // namespace palpate
