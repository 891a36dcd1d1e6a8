#include "engine/command_output.h"

#include <cstdio>
#include <iostream>
#include <unistd.h>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/effects_report.h"

namespace palpate {
namespace {

constexpr int kBadInput = 2;

}  // namespace

int refuse(const Error& error) {
  std::cerr << "palpate: " << error.to_string() << "\n";
  return kBadInput;
}

void print(const nlohmann::ordered_json& json) {
  std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

int finish_output() {
  if (std::cout.flush()) return 0;
  return refuse({ErrorCode::kFileUnwritable, "standard output", "", "cannot be written",
                 "check where it goes and the space left"});
}

void tell_what_was_not_understood(const Scene& scene) {
  for (const std::string& line : not_understood_lines(scene)) {
    std::cerr << "palpate: " << line << "\n";
  }
}

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), shown_(isatty(STDERR_FILENO)) {}

ProgressBar::~ProgressBar() {
  if (shown_) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(const std::string& label, double share) const {
  if (!shown_) return;
  constexpr int kWidth = 40;
  const int full = static_cast<int>(share * kWidth);
  std::fprintf(stderr, "\r%s [%s%s] %3.0f %%\033[K", label.c_str(), std::string(full, '#').c_str(),
               std::string(kWidth - full, ' ').c_str(), 100 * share);
  std::fflush(stderr);
}

}  // namespace palpate
