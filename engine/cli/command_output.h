#pragma once

// What the subcommands of the program have in common when they talk to a user.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

// One line on stderr. Returns the exit code for bad input.
int refuse(const Error& error);

// JSON for programs; a name in a file need not be UTF-8, and is then told with replacements.
void print(const nlohmann::ordered_json& json);

// The exit code once everything is told: output that got lost (a full disk) is no success. Whoever
// is refused reads one line, the error: warnings, a line each on stderr, come when nothing can be
// refused any more.
int finish_output(const std::vector<std::string>& warnings = {});

// What keeps stdout from being written to, as far as that shows before: it was closed, is open for
// reading alone, or is a device that is full. A disk may still become full.
std::optional<Error> check_output();

// What a line of progress says: the label, a bar, of a whole of total_s seconds those that are
// done, and the share in percent; in `columns`, less of that, and in the end the share alone.
std::string progress_line(const std::string& label, double share, double total_s,
                          std::size_t columns);

// A line of progress on a terminal, nothing elsewhere. It asks nothing of the terminal but a
// carriage return, and goes away with the object.
class ProgressBar {
 public:
  // total_s: how long it is what progresses, in its own time; 0 tells no seconds.
  explicit ProgressBar(std::string label, double total_s = 0.0);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // share: of the work, 0 to 1.
  void show(double share) { show(label_, share); }
  void show(const std::string& label, double share);

 private:
  std::string label_;
  double total_s_;
  bool has_terminal_;
  std::string shown_;
};

}  // namespace palpate
