#pragma once

// How often what takes long is done: the median counts.

namespace palpate::bench {

inline constexpr int kLoads = 5;

}  // namespace palpate::bench
