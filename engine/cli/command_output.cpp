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
#include "engine/report/output_lock.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

// Lines of progress in a log.
constexpr std::chrono::seconds kFirstLine{10};
constexpr std::chrono::seconds kBetweenLines{30};

// Columns of the terminal on stderr, at least 1; 80 if unknown.
std::size_t terminal_columns() {
  constexpr std::size_t kUsual = 80;
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return kUsual;
}

Error lost_output() {
  return {ErrorCode::kFileUnwritable, "standard output", "", "cannot be written",
          "check its target and the free space"};
}

}  // namespace

void warn(const std::string& warning) {
  std::cerr << "palpate: warning: " << printable(with_option_names(warning)) << "\n";
}

int refuse(const Error& error) {
  std::cerr << "palpate: " << printable(with_option_names(error).to_string()) << "\n";
  return kBadInput;
}

void print(const nlohmann::ordered_json& json) {
  // ASCII only: an escape sequence is written as \u001b, so it cannot command a terminal; a JSON
  // parser restores it.
  std::cout << json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

int finish_output(const std::vector<std::string>& warnings) {
  if (!std::cout.flush()) return refuse(lost_output());
  for (const std::string& warning : warnings) warn(warning);
  for (const std::string& warning : unlocked_folders()) warn(warning);
  return 0;
}

std::optional<Error> check_output() {
  // A full device, a closed descriptor and a read-only descriptor refuse even an empty write.
  if (::write(STDOUT_FILENO, "", 0) < 0) return lost_output();
  return std::nullopt;
}

std::string progress_line(const std::string& label, double share, double total_s,
                          std::size_t columns) {
  constexpr std::size_t kMostBar = 40;
  constexpr std::size_t kLeastBar = 5;  // a shorter bar shows no progress
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
  const std::size_t used = label.size() + seconds.size() + percent.size() + kFrame;
  if (used + kLeastBar <= columns) {
    const std::size_t bar = std::min(kMostBar, columns - used);
    const auto full = static_cast<std::size_t>(done * static_cast<double>(bar));
    return label + " [" + std::string(full, '#') + std::string(bar - full, ' ') + "]" + seconds +
           percent;
  }
  // Too narrow for a bar: the most informative part that fits.
  for (const std::string& line : {label + seconds + percent, label + percent, percent}) {
    if (line.size() <= columns) return line;
  }
  return percent.substr(0, columns);
}

std::string duration_text(double seconds) {
  const auto s = static_cast<long long>(seconds + 0.5);
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s % 3600 / 60) + " min";
}

ProgressBar::ProgressBar(std::string label, double total_s)
    : label_(std::move(label)),
      total_s_(total_s),
      has_terminal_(isatty(STDERR_FILENO)),
      next_line_(start_ + kFirstLine) {}

ProgressBar::~ProgressBar() {
  if (shown_.empty()) return;
  // Clears the whole line: a terminal shows "^C" behind the bar.
  std::fprintf(stderr, "\r%s\r", std::string(terminal_columns() - 1, ' ').c_str());
  std::fflush(stderr);
}

// A time left is told from this share on, or after this time.
constexpr double kLeastShare = 0.01;
constexpr double kMostWait_s = 10.0;

std::string ProgressBar::time_left_text(double share, double found) const {
  if (!(share > found)) return {};
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  // The first moments say little of the rest.
  if (share - found < kLeastShare && elapsed_s < kMostWait_s) return {};
  return ", " + duration_text(elapsed_s * std::max(0.0, 1.0 - share) / (share - found)) + " left";
}

void ProgressBar::show(const std::string& label, double share, double found) {
  const auto text_now = [&] {
    return label.substr(0, label.find_last_not_of(' ') + 1) + time_left_text(share, found);
  };
  if (has_terminal_) return show_on_terminal(text_now(), share);
  if (Clock::now() < next_line_) return;
  next_line_ = Clock::now() + kBetweenLines;
  const std::string text = text_now();
  std::fprintf(stderr, "palpate: %s, %.0f %% done\n", text.c_str(),
               100.0 * std::clamp(share, 0.0, 1.0));
  std::fflush(stderr);
}

void ProgressBar::show_on_terminal(const std::string& label, double share) {
  // Writing in the last column makes some terminals wrap.
  const std::string line = progress_line(label, share, total_s_, terminal_columns() - 1);
  if (line == shown_) return;
  // Blanks overwrite the rest of a longer line.
  const std::size_t rest = shown_.size() > line.size() ? shown_.size() - line.size() : 0;
  std::fprintf(stderr, "\r%s%s", line.c_str(), std::string(rest, ' ').c_str());
  std::fflush(stderr);
  shown_ = line;
}

}  // namespace palpate
