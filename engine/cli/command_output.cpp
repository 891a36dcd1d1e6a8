#include "engine/cli/command_output.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <sys/ioctl.h>
#include <unistd.h>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/effects_report.h"
#include "engine/cli/option_names.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr int kBadInput = 2;

// Of the terminal on stderr, one at least.
std::size_t terminal_columns() {
  constexpr std::size_t kUsual = 80;
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return kUsual;
}

Error lost_output() {
  return {ErrorCode::kFileUnwritable, "standard output", "", "cannot be written",
          "check where it goes and the space left"};
}

}  // namespace

int refuse(const Error& error) {
  std::cerr << "palpate: " << printable(with_option_names(error).to_string()) << "\n";
  return kBadInput;
}

void print(const nlohmann::ordered_json& json) {
  // In ASCII: what commands a terminal is written as \u001b, and a program reads it as it was.
  std::cout << json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

int finish_output(const std::vector<std::string>& warnings) {
  if (!std::cout.flush()) return refuse(lost_output());
  for (const std::string& warning : warnings) {
    std::cerr << "palpate: warning: " << printable(with_option_names(warning)) << "\n";
  }
  return 0;
}

std::optional<Error> check_output() {
  // A device that is full, and a descriptor that is none or is for reading, refuse nothing as well.
  if (::write(STDOUT_FILENO, "", 0) < 0) return lost_output();
  return std::nullopt;
}

std::string progress_line(const std::string& label, double share, double total_s,
                          std::size_t columns) {
  constexpr std::size_t kMostBar = 40;
  constexpr std::size_t kLeastBar = 5;  // a shorter one says nothing
  const double done = std::clamp(share, 0.0, 1.0);
  std::array<char, 64> text{};
  std::string seconds;
  if (total_s > 0.0) {
    std::snprintf(text.data(), text.size(), " %.1f of %.1f s", done * total_s, total_s);
    seconds = text.data();
  }
  std::snprintf(text.data(), text.size(), " %3.0f %%", 100 * done);
  const std::string percent = text.data();
  constexpr std::size_t kFrame = 3;  // a blank and the brackets
  const std::size_t taken = label.size() + seconds.size() + percent.size() + kFrame;
  if (taken + kLeastBar <= columns) {
    const std::size_t bar = std::min(kMostBar, columns - taken);
    const auto full = static_cast<std::size_t>(done * static_cast<double>(bar));
    return label + " [" + std::string(full, '#') + std::string(bar - full, ' ') + "]" + seconds +
           percent;
  }
  // Where there is no room for all, the most telling part of it.
  for (const std::string& line : {label + seconds + percent, label + percent, percent}) {
    if (line.size() <= columns) return line;
  }
  return percent.substr(0, columns);
}

ProgressBar::ProgressBar(std::string label, double total_s)
    : label_(std::move(label)), total_s_(total_s), has_terminal_(isatty(STDERR_FILENO)) {}

ProgressBar::~ProgressBar() {
  if (shown_.empty()) return;
  // All of the line: a terminal shows "^C" behind what was there.
  std::fprintf(stderr, "\r%s\r", std::string(terminal_columns() - 1, ' ').c_str());
  std::fflush(stderr);
}

void ProgressBar::show(const std::string& label, double share) {
  if (!has_terminal_) return;
  // In the last column some terminals go on to the next line.
  const std::string line = progress_line(label, share, total_s_, terminal_columns() - 1);
  if (line == shown_) return;
  // Blanks over what the last one has more.
  const std::size_t rest = shown_.size() > line.size() ? shown_.size() - line.size() : 0;
  std::fprintf(stderr, "\r%s%s", line.c_str(), std::string(rest, ' ').c_str());
  std::fflush(stderr);
  shown_ = line;
}

}  // namespace palpate
