#pragma once

// The subcommands of the program, in the order of the help. A new subcommand is declared and listed
// here, and defined in its own file.

#include <memory>
#include <vector>

#include "engine/cli/command.h"

namespace palpate {

std::unique_ptr<Command> make_run_command();
std::unique_ptr<Command> make_replay_command();
std::unique_ptr<Command> make_recording_command();
std::unique_ptr<Command> make_accuracy_command();
std::unique_ptr<Command> make_experiment_command();
std::unique_ptr<Command> make_compare_command();
std::unique_ptr<Command> make_soak_command();
std::unique_ptr<Command> make_info_command();
std::unique_ptr<Command> make_devices_command();
std::unique_ptr<Command> make_view_command();

inline std::vector<std::unique_ptr<Command>> all_commands() {
  std::vector<std::unique_ptr<Command>> commands;
  commands.push_back(make_run_command());
  commands.push_back(make_view_command());
  commands.push_back(make_replay_command());
  commands.push_back(make_recording_command());
  commands.push_back(make_accuracy_command());
  commands.push_back(make_experiment_command());
  commands.push_back(make_compare_command());
  commands.push_back(make_soak_command());
  commands.push_back(make_info_command());
  commands.push_back(make_devices_command());
  return commands;
}

}  // namespace palpate
