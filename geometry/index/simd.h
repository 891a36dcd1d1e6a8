#pragma once

// The SIMD instruction set of the queries, chosen once at run time for the processor.

#include <cstdint>
#include <string_view>

namespace palpate {

enum class SimdLevel : std::uint8_t { kBaseline, kAvx2, kAvx512 };  // baseline on x86-64: SSE2

inline constexpr std::string_view kSimdLevelNames[] = {"sse2", "avx2", "avx512"};

// The widest instruction set that both the processor and this build support. Only GCC on x86-64
// builds more than the baseline.
SimdLevel widest_simd_level() noexcept;

// The instruction set that queries use: the widest, unless limit_simd_level() sets a lower one. All
// instruction sets give identical results.
SimdLevel simd_level() noexcept;

// Limits the instruction set, for measurements and tests. Must not be called while queries run.
void limit_simd_level(SimdLevel level) noexcept;

}  // namespace palpate
