#include "engine/cli/command_line.h"

#include <algorithm>
#include <utility>

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

std::string shell_line(const std::vector<std::string>& arguments) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=@%+,-";
  std::string line = "palpate";
  for (const std::string& argument : arguments) {
    line += ' ';
    if (!argument.empty() && argument.find_first_not_of(kPlain) == std::string::npos) {
      line += argument;
      continue;
    }
    line += '\'';
    for (const char c : argument) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace palpate
