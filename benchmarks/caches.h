#pragma once

// Eviction of data from the caches, as it happens when a haptic loop shares its core with other
// work.

#include <cstdint>

namespace palpate::bench {

enum class Caches : std::uint8_t {
  kWarm,    // as the last sample left them
  kEvicted  // the data of the sample are in L3 only
};

// Reads a buffer that is twice as large as this machine's L2. This evicts nearly all other data
// from L1 and L2. The L3 is several times as large and keeps the evicted data. Takes about 40 us.
void evict_l1_and_l2();

}  // namespace palpate::bench
