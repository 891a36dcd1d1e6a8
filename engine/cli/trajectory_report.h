#pragma once

// What `replay` says about the times and units of a trajectory.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/session/path_times.h"
#include "io/trajectory.h"

namespace palpate {

// A trajectory and the ticks in which it is played.
struct PlayedPath {
  std::string file;
  std::vector<std::string> notes;
  std::vector<std::string> comment_warnings;   // what comments say that was not applied
  std::vector<Vec3> positions_m;               // one for each tick
  std::optional<std::vector<double>> ticks_s;  // no value: every tick has the length of --rate
  std::optional<PathTimes> times;              // no value: the file has no times
  std::vector<std::size_t> lines;              // of the file's positions, if it has times
  std::optional<double> at_rate_Hz;            // interpolated at --rate
  std::size_t interpolated = 0;
  // A rate that a comment of a file without times states, if the ticks have another one.
  std::optional<double> other_rate_Hz;
  std::size_t other_rate_line = 0;
  double rate_Hz = 0.0;  // of the ticks of a file without times
};

// Reads a trajectory. rate_Hz: --rate, if the user gave it: the positions of a file with times are
// interpolated at this rate. single_s: the length of the only tick of a file with one time.
// max_memory_bytes: as in path_at_rate().
Result<PlayedPath> read_played_path(const std::string& file, std::optional<double> rate_Hz,
                                    double single_s, std::uint64_t max_memory_bytes);

// After the names of the files: ": 200 rows in 0.398 s, ...". Empty for a file without times.
std::string path_text(const PlayedPath& path);

// The notes, one indented line each.
std::string path_notes_text(const PlayedPath& path);

// Null if the file has no times and there are neither notes nor warnings.
nlohmann::ordered_json path_json(const PlayedPath& path);

// Comments that were not applied, gaps, and rates that devices do not have; one line each.
std::vector<std::string> path_warnings(const PlayedPath& path);

}  // namespace palpate
