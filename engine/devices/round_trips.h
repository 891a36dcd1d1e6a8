#pragma once

// The times between questions and their answers.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

// Counts times in buckets of kBucket_ns; longer times than all buckets count in the last one. One
// thread owns an object. No function allocates or throws.
class RoundTrips {
 public:
  static constexpr std::int64_t kBucket_ns = 20'000;

  void add(std::int64_t time_ns) noexcept {
    const std::int64_t bucket = std::clamp<std::int64_t>(time_ns / kBucket_ns, 0, kBuckets - 1);
    ++buckets_[static_cast<std::size_t>(bucket)];
    ++count_;
    longest_ns_ = std::max(longest_ns_, time_ns);
  }
  // The upper end of the median's bucket, at most the longest time; 0 without times.
  std::int64_t median_ns() const noexcept {
    std::uint64_t below = 0;
    for (std::int64_t k = 0; k < kBuckets && count_ > 0; ++k) {
      below += buckets_[static_cast<std::size_t>(k)];
      if (2 * below >= count_) return std::min((k + 1) * kBucket_ns, longest_ns_);
    }
    return 0;
  }
  std::int64_t longest_ns() const noexcept { return longest_ns_; }

 private:
  static constexpr std::int64_t kBuckets = 512;
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t longest_ns_ = 0;
};

}  // namespace palpate
