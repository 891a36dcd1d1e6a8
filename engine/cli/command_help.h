#pragma once

// Parts of the help that several commands share.

#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

namespace palpate {

// Headings of groups of options in the help, in the order in which the groups are added.
inline constexpr const char* kSceneGroup = "Scene";
inline constexpr const char* kDeviceGroup = "Device";
inline constexpr const char* kMotorGroup = "A device with motors, in place of the simulated hand";
inline constexpr const char* kTouchGroup = "Touch";
inline constexpr const char* kHandGroup = "Hand";
inline constexpr const char* kA4Group = "A4, which turns the scene";
inline constexpr const char* kOutputGroup = "Output";

// The help text of CLI11, below an example.
class HelpWithExample final : public CLI::Formatter {
 public:
  explicit HelpWithExample(std::string example) : example_(std::move(example)) {}

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    return "Example:\n" + example_ + "\n" + CLI::Formatter::make_help(app, std::move(name), mode);
  }

 private:
  std::string example_;
};

// Sets the example, the last lines and the exit codes of a help text. example: command lines that
// work unchanged in the project's folder; each is indented by two spaces and ends with a newline.
// examples_test.py runs them. last_lines: empty, or ends with a newline.
inline void set_help(CLI::App& app, const std::string& example,
                     const std::string& last_lines = "") {
  app.formatter(std::make_shared<HelpWithExample>(example));
  app.footer(last_lines +
             "Exit codes: 0; 1 for a fault of the program; 2 for bad arguments or bad input, "
             "reported in one\nline; 3 for a run that is not comparable or that a trip of the "
             "device has ended; 129 after\nSIGHUP, 130 after Ctrl-C, 143 after SIGTERM.");
}

}  // namespace palpate
