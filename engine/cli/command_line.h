#pragma once

// Command lines that the program proposes to the user.

#include <optional>
#include <string>
#include <vector>

namespace palpate {

struct OptionSetting {
  std::string option;
  std::optional<std::string> value;  // no value: the option is removed
};

// Returns the arguments in which each option in `changes` is set to its value, or is removed if it
// has no value. Earlier settings of the option, and of options that exclude it, are removed. Each
// of these options has one value, written as in "--fit 0.2" or "--fit=0.2".
std::vector<std::string> with_options(std::vector<std::string> arguments,
                                      const std::vector<OptionSetting>& changes);

// The first word of a command line that the user can type: the environment variable
// PALPATE_COMMAND, which run.sh sets to the command with which it was started, or "palpate".
std::string program_name();

// program_name() and the arguments, quoted for a POSIX shell where necessary.
std::string shell_line(const std::vector<std::string>& arguments);

}  // namespace palpate
