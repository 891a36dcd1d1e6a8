#include "engine/accuracy/machine_load.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>
#include <unistd.h>

namespace palpate {
namespace {

double clock_s(clockid_t clock) {
  timespec time{};
  return clock_gettime(clock, &time) == 0
             ? static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec)
             : 0.0;
}

}  // namespace

std::optional<double> busy_seconds(std::string_view proc_stat, double clock_ticks_per_s) {
  std::istringstream line{std::string(proc_stat.substr(0, proc_stat.find('\n')))};
  std::string name;
  double user = 0.0, nice = 0.0, system = 0.0, idle = 0.0, disk = 0.0, irq = 0.0, soft_irq = 0.0,
         steal = 0.0;
  line >> name >> user >> nice >> system >> idle >> disk >> irq >> soft_irq >> steal;
  if (!line || name != "cpu" || !(clock_ticks_per_s > 0.0)) return std::nullopt;
  return (user + nice + system + irq + soft_irq + steal) / clock_ticks_per_s;
}

std::optional<CpuTimes> cpu_times_now() {
  std::ifstream file("/proc/stat");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  const auto busy_s = busy_seconds(line, static_cast<double>(::sysconf(_SC_CLK_TCK)));
  if (!busy_s) return std::nullopt;
  return CpuTimes{clock_s(CLOCK_MONOTONIC), *busy_s, clock_s(CLOCK_PROCESS_CPUTIME_ID)};
}

int machine_cores() {
  return static_cast<int>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
}

double cores_of_others(const CpuTimes& before, const CpuTimes& after) {
  const double elapsed_s = after.now_s - before.now_s;
  if (!(elapsed_s > 0.0)) return 0.0;
  const double others_s = (after.busy_s - before.busy_s) - (after.own_s - before.own_s);
  return std::max(0.0, others_s / elapsed_s);
}

}  // namespace palpate
