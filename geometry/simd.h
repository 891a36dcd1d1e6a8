#pragma once

// Wider SIMD, chosen at run time. A function marked PALPATE_SIMD_CLONES is compiled for SSE2, AVX2
// and AVX-512, and the loader picks the widest that the processor has. Its body must be plain loops
// over lanes: then every width gives the same bits, because no operation is reordered or fused
// (-ffp-contract=off). Left out under sanitizers, whose run-time is not ready when the loader asks,
// and on other processors.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PALPATE_SIMD_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define PALPATE_SIMD_CLONES
#endif
