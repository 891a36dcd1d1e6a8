#pragma once

// How many processor cores other programs use while something is measured.

#include <optional>
#include <string_view>

namespace palpate {

// Seconds since an arbitrary origin.
struct CpuTimes {
  double now_s = 0.0;   // of the clock
  double busy_s = 0.0;  // of all cores together, by all programs
  double own_s = 0.0;   // by all threads of this program
};

// From this many cores on, used by other programs on average, a machine is called busy. A choice:
// the background programs of an idle desktop stay below it.
inline constexpr double kBusyCores = 0.25;

// The busy seconds in the text of /proc/stat: everything but idling and waiting for disks, and with
// what a hypervisor gave to other machines. No value if the text is something else.
std::optional<double> busy_seconds(std::string_view proc_stat, double clock_ticks_per_s);

// No value if the system does not state its times. Not for the haptic thread, because it does I/O.
std::optional<CpuTimes> cpu_times_now();

// The cores that CpuTimes::busy_s covers, at least 1; this program may be confined to fewer.
int machine_cores();

// The cores that other programs used on average between two instants; 0 if none.
double cores_of_others(const CpuTimes& before, const CpuTimes& after);

}  // namespace palpate
