#pragma once

// Output that the subcommands share: errors, warnings, JSON and progress.

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr int kBadInput = 2;  // the exit code of bad arguments and bad input

// Prints the error as one line on stderr. Returns kBadInput.
int refuse(const Error& error);

// Prints the warning as one line on stderr, at once. The caller has no output that may still fail.
void warn(const std::string& warning);

// Prints JSON on stdout. Bytes of a name that are not UTF-8 become replacement characters.
void print(const nlohmann::ordered_json& json);

// Flushes stdout and prints the warnings on stderr, one per line. Returns the exit code. Lost
// output (for example because of a full disk) counts as an error. Call this function last, because
// a command that fails prints only one line on stderr, and this line is the error.
int finish_output(const std::vector<std::string>& warnings = {});

// Returns an error if stdout is closed, is open for reading only, or is a full device. A disk may
// still become full later.
std::optional<Error> check_output();

// A line of progress: label, bar, seconds done of total_s, and the completed share in percent. If
// the line does not fit into `columns`, parts are left out, and the completed share is left out
// last.
std::string progress_line(const std::string& label, double share, double total_s,
                          std::size_t columns);

// "12 s", "3 min 20 s", "2 h 5 min"
std::string duration_text(double seconds);

// The progress of a long command on stderr, with the time left, which is estimated from the share
// that is done. On a terminal it is one line, whose only control character is the carriage return;
// the destructor removes it. Elsewhere, such as in a log, it is a line after 10 s and then every
// 30 s.
class ProgressBar {
 public:
  // total_s: simulated or real duration of the whole work, which a terminal shows in place of the
  // time left; 0: unknown.
  explicit ProgressBar(std::string label, double total_s = 0.0);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // share: completed part of the work, 0 to 1. found: the part of it that was completed before.
  void show(double share, double found = 0.0) { show(label_, share, found); }
  void show(const std::string& label, double share, double found = 0.0);

 private:
  using Clock = std::chrono::steady_clock;

  void show_on_terminal(const std::string& label, double share);
  // "; 3 min 20 s left", or nothing as long as it is unknown.
  std::string time_left_text(double share, double found) const;

  std::string label_;
  double total_s_;
  bool has_terminal_;
  std::string shown_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_line_;
};

}  // namespace palpate
