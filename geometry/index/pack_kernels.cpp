#include "geometry/index/pack_kernels.h"

#include <cmath>

#include "geometry/index/simd.h"

// GCC can compile parts of a file for other processors. Other compilers build only the baseline.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PALPATE_WIDER_SIMD 1
#include <immintrin.h>
#else
#define PALPATE_WIDER_SIMD 0
#endif

// Vectors wider than the baseline's registers are passed only between functions of this file.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace palpate::baseline {
using Lanes [[gnu::vector_size(16), gnu::may_alias]] = float;
using Mask [[gnu::vector_size(16)]] = std::int32_t;
inline std::uint32_t greater(const Lanes& x, const Lanes& y) {
  const Mask mask = x > y;
#if defined(__SSE2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps(reinterpret_cast<const Lanes&>(mask)));
#else
  std::uint32_t lanes = 0;
  for (int i = 0; i < 4; ++i) lanes |= static_cast<std::uint32_t>(mask[i] != 0) << i;
  return lanes;
#endif
}
#include "geometry/index/pack_kernels.inl"
}  // namespace palpate::baseline

#if PALPATE_WIDER_SIMD
#pragma GCC push_options
#pragma GCC target("avx2")
namespace palpate::avx2 {
using Lanes [[gnu::vector_size(32), gnu::may_alias]] = float;
using Mask [[gnu::vector_size(32)]] = std::int32_t;
inline std::uint32_t greater(const Lanes& x, const Lanes& y) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(x, y, _CMP_GT_OQ)));
}
#include "geometry/index/pack_kernels.inl"
}  // namespace palpate::avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw")
namespace palpate::avx512 {
using Lanes [[gnu::vector_size(64), gnu::may_alias]] = float;
using Mask [[gnu::vector_size(64)]] = std::int32_t;
inline std::uint32_t greater(const Lanes& x, const Lanes& y) {
  return _mm512_cmp_ps_mask(x, y, _CMP_GT_OQ);
}
#include "geometry/index/pack_kernels.inl"
}  // namespace palpate::avx512
#pragma GCC pop_options
#endif

namespace palpate {
namespace {

SimdLevel limit = SimdLevel::kAvx512;

const PackKernels* chosen() {
#if PALPATE_WIDER_SIMD
  switch (simd_level()) {
    case SimdLevel::kAvx512:
      return &avx512::kKernels;
    case SimdLevel::kAvx2:
      return &avx2::kKernels;
    case SimdLevel::kBaseline:
      break;
  }
#endif
  return &baseline::kKernels;
}

const PackKernels*& current() {
  static const PackKernels* kernels = chosen();
  return kernels;
}

}  // namespace

SimdLevel widest_simd_level() noexcept {
#if PALPATE_WIDER_SIMD
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
    return SimdLevel::kAvx512;
  }
  if (__builtin_cpu_supports("avx2")) return SimdLevel::kAvx2;
#endif
  return SimdLevel::kBaseline;
}

SimdLevel simd_level() noexcept {
  const SimdLevel widest = widest_simd_level();
  return widest < limit ? widest : limit;
}

void limit_simd_level(SimdLevel level) noexcept {
  limit = level;
  current() = chosen();
}

const PackKernels& pack_kernels() noexcept {
  return *current();
}

}  // namespace palpate
