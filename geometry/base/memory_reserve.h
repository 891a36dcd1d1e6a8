#pragma once

// Memory reserved for handling an out-of-memory error.

#include <cstddef>

namespace palpate {

// Holds two blocks of memory in reserve. While an object of this class lives, a failing operator
// new frees one block and tries again. One block is for failures during stack unwinding, the other
// for failures at any other time. Failures during unwinding need a block of their own, because
// destructors, for example those of JSON values, may allocate but must not throw. Once the matching
// block is used, the previous handler is called; without a previous handler, operator new throws.
// The mechanism is std::set_new_handler, which affects the whole process; the last object restores
// the previous handler. Thread-safe. Objects that live at the same time share the two blocks, which
// have the largest requested size.
class MemoryReserve {
 public:
  // bytes: minimum size of each block. Throws std::bad_alloc.
  explicit MemoryReserve(std::size_t bytes = kEnoughForAnError);
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  // Frees the remaining blocks, so that an error can be reported after memory was short.
  static void give_up() noexcept;
  // Whether a block was used while an object of this class lives.
  static bool has_helped_out() noexcept;

 private:
  // Small enough for the C library to reuse a freed block for smaller allocations.
  static constexpr std::size_t kEnoughForAnError = std::size_t{1} << 16;
};

// Throws std::bad_alloc if memory has been short in this process while the present MemoryReserve
// lives. Call it after steps of work: a step that needed
// the reserve succeeds, but the next shortage might end the process, in a destructor outside of
// unwinding. Some libraries also report a shortage only as a general failure.
void expect_no_shortage();

// Throws std::bad_alloc if one allocation of this size fails. Call it before code that needs this
// memory and would otherwise end the process.
void expect_available(std::size_t bytes);

}  // namespace palpate
