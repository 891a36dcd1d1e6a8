#pragma once

// The time between two ticks of a loop that runs at 1 kHz.

namespace palpate::test {

inline constexpr double kTick_s = 1e-3;

}  // namespace palpate::test
