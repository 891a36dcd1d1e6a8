#pragma once

// Number of repeats of a slow step; the median of its times is reported.

namespace palpate::bench {

inline constexpr int kLoads = 5;

}  // namespace palpate::bench
