#pragma once

// How much memory a piece of code holds at most, for tests. The executable's operator new and
// delete are replaced.

#include <cstddef>

namespace palpate::test {

// Measures from its construction on. One at a time; what other threads allocate is counted too.
class PeakMemory {
 public:
  PeakMemory();

  // The most bytes that were held at any time, beyond those held at the start.
  std::size_t bytes() const;

 private:
  std::size_t start_;
};

}  // namespace palpate::test
