#pragma once

// Which vector instructions the queries use: chosen once, at run time, from what the processor has.

#include <cstdint>
#include <string_view>

namespace palpate {

enum class SimdLevel : std::uint8_t { kBaseline, kAvx2, kAvx512 };  // baseline on x86-64: SSE2

inline constexpr std::string_view kSimdLevelNames[] = {"sse2", "avx2", "avx512"};

// The widest this processor has and this build knows. Only GCC on x86-64 builds more than the
// baseline.
SimdLevel widest_simd_level() noexcept;

// What queries use: the widest, unless limited. The answers are the same to the bit.
SimdLevel simd_level() noexcept;

// For measurements and tests: nothing wider than this from now on. Not while queries are running.
void limit_simd_level(SimdLevel level) noexcept;

}  // namespace palpate
