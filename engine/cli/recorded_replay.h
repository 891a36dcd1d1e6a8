#pragma once

// `replay FILE`: proves a recording, or answers what the same path gives under other settings.

#include <optional>
#include <string>
#include <vector>

#include "haptics/haptic_loop.h"

namespace palpate {

// The settings that are given differ from those of the recording.
struct RecordedReplayRequest {
  std::string recording;
  std::string scene;  // where the scene is now; empty: where it was
  bool json = false;
  std::vector<std::string> materials;  // "NAME.key=value" each
  std::optional<Strategy> strategy = {};
  // Either ends the strategy of the recording, if it has one that is more than force and A4.
  std::optional<bool> a4 = {};
  std::optional<Alignment> align = {};
  std::optional<ForceMode> force = {};
  std::optional<Accuracy> accuracy = {};
  std::optional<double> stiffness_N_per_m = {};
  std::optional<double> damping_Ns_per_m = {};

  bool asks_what_if() const {
    return !materials.empty() || strategy || a4 || align || force || accuracy ||
           stiffness_N_per_m || damping_Ns_per_m;
  }
};

// Returns the exit code: 0: every bit was the same, or the question was answered; 1: a bit
// differed, or the replay could not go on; 2: refused.
int replay_recorded(const RecordedReplayRequest& request);

}  // namespace palpate
