#include "benchmarks/caches.h"

#include <bit>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

namespace palpate::bench {
namespace {

constexpr std::size_t kLineBytes = 64;

// Used if the system does not report the size; no desktop core has had a larger L2 so far.
constexpr std::size_t kAssumedL2Bytes = std::size_t{4} << 20;

std::size_t l2_bytes() {
  for (int index = 0; index < 8; ++index) {
    const std::string cache = "/sys/devices/system/cpu/cpu0/cache/index" + std::to_string(index);
    int level = 0;
    std::size_t kibibytes = 0;  // the file says "1024K"
    if (std::ifstream(cache + "/level") >> level && level == 2 &&
        std::ifstream(cache + "/size") >> kibibytes && kibibytes > 0) {
      return kibibytes << 10;
    }
  }
  return kAssumedL2Bytes;
}

}  // namespace

void evict_l1_and_l2() {
  static const std::vector<unsigned char> buffer(2 * std::bit_ceil(l2_bytes()), 1);
  // Reads every cache line once, in the order of a linear congruential generator of full period.
  // Caches detect a sequential read and keep most of their data (on a Zen 5, two thirds).
  const std::size_t lines = buffer.size() / kLineBytes;
  std::size_t line = 0;
  unsigned sum = 0;
  for (std::size_t i = 0; i < lines; ++i) {
    line = (1664525 * line + 1013904223) & (lines - 1);
    sum += buffer[kLineBytes * line];
  }
  benchmark::DoNotOptimize(sum);
}

}  // namespace palpate::bench
