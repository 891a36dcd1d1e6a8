#include "engine/trials/deal/run_log.h"

#include <array>
#include <cstdio>
#include <ctime>

#include "engine/report/human_units.h"

namespace palpate {

void RunLog::add(const std::string& line) {
  const std::lock_guard lock(mutex_);
  std::FILE* const file = std::fopen(path_.c_str(), "ab");
  if (!file) return;
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  std::array<char, 32> day{};
  if (::gmtime_r(&now, &utc)) std::strftime(day.data(), day.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  std::fprintf(file, "%s %s\n", day.data(), line.c_str());
  std::fclose(file);
}

std::string computing_text(std::uint64_t trials, std::uint64_t ticks, double seconds,
                           std::int64_t loop_ns) {
  std::string text = std::to_string(trials) + " trials, " + std::to_string(ticks) + " ticks in " +
                     short_number(seconds) + " s";
  if (ticks == 0) return text;
  const auto per_tick = [&](double time_s) {
    return short_number(1e6 * time_s / static_cast<double>(ticks)) + " us";
  };
  return text + ": " + per_tick(seconds) + " a tick, " +
         per_tick(1e-9 * static_cast<double>(loop_ns)) + " of them in the haptic loop";
}

}  // namespace palpate
