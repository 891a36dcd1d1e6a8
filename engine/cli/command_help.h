#pragma once

// What the help of several commands has in common.

#include <string>

namespace palpate {

// Headings of the help, in the order in which options are added.
inline constexpr const char* kSceneGroup = "Scene";
inline constexpr const char* kDeviceGroup = "Device";
inline constexpr const char* kTouchGroup = "Touch";
inline constexpr const char* kHandGroup = "Hand";
inline constexpr const char* kA4Group = "A4, which turns the scene";
inline constexpr const char* kOutputGroup = "Output";

// A line of the command's own, and what its exit codes mean.
inline std::string help_footer(const std::string& first_line) {
  return first_line +
         "\nExit codes: 0; 1 for a fault of the program; 2 for bad arguments or bad input, told in "
         "one line;\n3 for a run that is not comparable; 129 after SIGHUP, 130 after Ctrl-C, 143 "
         "after SIGTERM.";
}

}  // namespace palpate
