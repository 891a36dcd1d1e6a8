#pragma once

// The request of the subcommand `run`.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/cli/run_options.h"
#include "engine/cli/scene_options.h"
#include "engine/simulation/exploration.h"

namespace palpate {

// The runs to make.
enum class A4Runs : std::uint8_t { kOn, kOff, kCompare };

// A device with motors in place of the simulated hand (--device).
struct DeviceRequest {
  std::string text;  // as make_device() reads it; empty: the hand is simulated
  bool no_guard = false;
  bool without_realtime = false;
  std::optional<std::uint64_t> cpu;
  bool stays_inside = false;  // see DeviceRunSettings
  // Why the person allows a stiffness that no damping holds; no value: it is refused.
  std::optional<std::string> allow_unstable;
};

struct RunRequest {
  SceneOptions scene;
  RunOptions options;
  A4Runs a4 = A4Runs::kCompare;
  ExplorationSettings exploration;
  DeviceRequest device;
  std::string out_dir = "out";
  std::string record;  // the file of --record; empty: nothing is recorded
  bool json = false;
  std::vector<std::string> arguments;  // arguments of the program, unchanged

  // Whether the request includes the run with A4, or the run without A4.
  bool wants(bool with_a4) const {
    return a4 == A4Runs::kCompare || (a4 == A4Runs::kOn) == with_a4;
  }
};

}  // namespace palpate
