#pragma once

// How much memory a piece of code holds at most, and what it does when there is none, for tests.
// The executable's operator new and delete are replaced.

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

// While it lives, operator new finds nothing beyond so many bytes more than are held when it is
// made. As the standard has it, it asks the new-handler before it throws. One at a time.
class BoundedMemory {
 public:
  explicit BoundedMemory(std::size_t bytes);
  ~BoundedMemory();
};

// While it lives, from the n-th call of operator new on there are 4 KiB more than are held then, in
// which an error can be told; n from 0. One at a time.
class FailingMemory {
 public:
  explicit FailingMemory(std::size_t n);
  ~FailingMemory();
  // Calls so far.
  static std::size_t calls();
};

// Bytes that are held now.
std::size_t held_memory();

}  // namespace palpate::test
