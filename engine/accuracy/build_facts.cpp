#include "engine/accuracy/build_facts.h"

#include <ctime>
#include <fstream>
#include <thread>

namespace palpate {

std::string compiler_name() {
  return PALPATE_COMPILER;
}

std::string compiler_flags() {
  return PALPATE_COMPILE_FLAGS;
}

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

unsigned processor_cores() {
  return std::thread::hardware_concurrency();
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[16] = "unknown";
  if (gmtime_r(&now, &utc)) std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

std::vector<std::pair<std::string, std::string>> build_facts() {
  return {{"Program", "palpate " PALPATE_VERSION},
          {"Processor", processor_name() + ", " + std::to_string(processor_cores()) + " cores"},
          {"Compiler", compiler_name()},
          {"Flags", compiler_flags()},
          {"Date", today()}};
}

}  // namespace palpate
