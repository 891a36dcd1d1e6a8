#pragma once

// Measures the peak memory of a piece of code and lets memory run out, for tests. Replaces the
// executable's operator new and delete.

#include <cstddef>

namespace palpate::test {

// Measures the peak memory from the construction of the object on. Only one object may exist at a
// time. Allocations of other threads count, too.
class PeakMemory {
 public:
  PeakMemory();

  // The largest number of bytes held at any time, minus those held at the start.
  std::size_t bytes() const;

 private:
  std::size_t start_;
};

// During the lifetime of the object, operator new fails if the memory held would exceed that at the
// construction by more than `bytes`. As the standard requires, operator new calls the new-handler
// before it throws. Only one object may exist at a time.
class BoundedMemory {
 public:
  explicit BoundedMemory(std::size_t bytes);
  ~BoundedMemory();
};

// During the lifetime of the object, memory runs out at the n-th call of operator new (calls are
// counted from 0). From then on, only 4 KiB more memory than at that call is available, which is
// enough to report an error. Only one object may exist at a time.
class FailingMemory {
 public:
  explicit FailingMemory(std::size_t n);
  ~FailingMemory();
  // The number of calls of operator new so far.
  static std::size_t calls();
};

// The number of bytes held now.
std::size_t held_memory();

}  // namespace palpate::test
