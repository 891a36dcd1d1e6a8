#pragma once

// Cold caches, as a haptic loop finds them that shares its core with other work.

#include <cstdint>

namespace palpate::bench {

enum class Caches : std::uint8_t {
  kWarm,    // as the last sample left them
  kEvicted  // L1 and L2 hold nothing of it; L3 does
};

// Reads a buffer twice the size of this machine's L2, which leaves next to nothing else in L1 and
// L2. The L3, several times as large, keeps what the L2 gives up. Takes some 40 us.
void evict_l1_and_l2();

}  // namespace palpate::bench
