#pragma once

// Parts of the help that several commands share.

#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

namespace palpate {

// Headings of the help, in the order in which options are added.
inline constexpr const char* kSceneGroup = "Scene";
inline constexpr const char* kDeviceGroup = "Device";
inline constexpr const char* kTouchGroup = "Touch";
inline constexpr const char* kHandGroup = "Hand";
inline constexpr const char* kA4Group = "A4, which turns the scene";
inline constexpr const char* kOutputGroup = "Output";

// CLI11's help below an example.
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

// Sets the example, the last lines and the exit codes of a help. example: command lines that work
// as they stand in the project's folder, each indented by two spaces and ended by a newline;
// examples_test.py runs them. last_lines: ended by a newline, or empty.
inline void set_help(CLI::App& app, const std::string& example,
                     const std::string& last_lines = "") {
  app.formatter(std::make_shared<HelpWithExample>(example));
  app.footer(last_lines +
             "Exit codes: 0; 1 for a fault of the program; 2 for bad arguments or bad input, "
             "reported in one\nline; 3 for a run that is not comparable; 129 after SIGHUP, 130 "
             "after Ctrl-C, 143 after SIGTERM.");
}

}  // namespace palpate
