#pragma once

// Ticks of a session in simulated time.

#include <cstdint>

#include "engine/session/haptic_session.h"

namespace palpate {

// Runs ticks as fast as possible, then commands zero force. The device of the session must be one
// that always starts, as a simulated device does. Ends after `most` ticks, or when is_over(n)
// returns true. is_over(n) is called before tick n (n = 0, 1, ...). Returns the number of ticks.
template <typename IsOver>
std::uint64_t run_simulated(HapticSession& session, double dt_s, std::uint64_t most,
                            const IsOver& is_over) {
  session.start();
  std::uint64_t n = 0;
  for (; n < most && !is_over(n); ++n) session.tick(dt_s);
  session.stop();
  return n;
}

}  // namespace palpate
