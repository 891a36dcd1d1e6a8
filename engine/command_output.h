#pragma once

// What the subcommands of the program have in common when they talk to a user.

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene.h"
#include "geometry/result.h"

namespace palpate {

// One line on stderr. Returns the exit code for bad input.
int refuse(const Error& error);

// JSON for programs; a name in a file need not be UTF-8, and is then told with replacements.
void print(const nlohmann::ordered_json& json);

// The exit code once everything is told: output that got lost (a full disk) is no success.
int finish_output();

// Nothing that a file or a user meant is lost without a word: a line each on stderr.
void tell_what_was_not_understood(const Scene& scene);

// A bar on a terminal, nothing elsewhere. Goes away with the object.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // share: of the work, 0 to 1.
  void show(double share) const { show(label_, share); }
  void show(const std::string& label, double share) const;

 private:
  std::string label_;
  bool shown_;
};

}  // namespace palpate
