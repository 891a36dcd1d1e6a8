#pragma once

// Repeats of a slow step; its median is reported.

namespace palpate::bench {

inline constexpr int kLoads = 5;

}  // namespace palpate::bench
