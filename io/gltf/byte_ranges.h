#pragma once

// Counts the different bytes in ranges that may overlap.

#include <cstdint>
#include <map>

namespace palpate {

// Not thread-safe. add() takes logarithmic time, on average over all calls.
class ByteRanges {
 public:
  // Adds the bytes from begin to before end.
  void add(std::uint64_t begin, std::uint64_t end);

  // The number of bytes in at least one range.
  std::uint64_t total() const { return total_; }

 private:
  std::map<std::uint64_t, std::uint64_t> ends_;  // by begin; apart from each other
  std::uint64_t total_ = 0;
};

}  // namespace palpate
