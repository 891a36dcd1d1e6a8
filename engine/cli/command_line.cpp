#include "engine/cli/command_line.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "engine/report/shell_word.h"

namespace palpate {
namespace {

// Whether one option replaces another.
bool excludes(const std::string& option, const std::string& other) {
  return option == other || (option == "--fit" && other == "--scale");
}

}  // namespace

std::vector<std::string> with_options(std::vector<std::string> arguments,
                                      const std::vector<OptionSetting>& changes) {
  for (const auto& [option, value] : changes) {
    std::vector<std::string> kept;
    bool may_be_option = true;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      may_be_option = may_be_option && arguments[i] != "--";
      const std::string name = arguments[i].substr(0, arguments[i].find('='));
      if (!may_be_option || !excludes(option, name)) {
        kept.push_back(arguments[i]);
      } else if (name == arguments[i]) {
        ++i;  // skips the value
      }
    }
    const auto end_of_options = std::find(kept.begin(), kept.end(), "--");
    if (value) kept.insert(end_of_options, {option, *value});
    arguments = std::move(kept);
  }
  return arguments;
}

std::string program_name() {
  const char* const name = std::getenv("PALPATE_COMMAND");
  return name && *name ? name : "palpate";
}

std::string shell_line(const std::vector<std::string>& arguments) {
  std::string line = shell_word(program_name());
  for (const std::string& argument : arguments) line += ' ' + shell_word(argument);
  return line;
}

}  // namespace palpate
