#pragma once

// How a user permits real-time scheduling to the program, for messages.

#include <string>

namespace palpate {

// The file of limits. A user has the limits from the next login on.
inline constexpr const char* kLimitsFile = "/etc/security/limits.d/palpate.conf";

// Permits SCHED_FIFO to the haptic thread, the driver's thread and the guard: the number is above
// all their priorities. The site (docs) has the same line.
inline std::string fifo_remedy() {
  return std::string("write `* - rtprio 90` to ") + kLimitsFile + " and log in again";
}

}  // namespace palpate
