#pragma once

// Command lines that the program proposes.

#include <optional>
#include <string>
#include <vector>

namespace palpate {

struct OptionSetting {
  std::string option;
  std::optional<std::string> value;  // nothing: the command line goes without the option
};

// The arguments with each option set to its value, or left out, in place of what was given for it
// and for what excludes it. Every option named in changes takes one value, as "--fit 0.2" or
// "--fit=0.2".
std::vector<std::string> with_options(std::vector<std::string> arguments,
                                      const std::vector<OptionSetting>& changes);

// "palpate" and the arguments, quoted for a POSIX shell where they need it.
std::string shell_line(const std::vector<std::string>& arguments);

}  // namespace palpate
