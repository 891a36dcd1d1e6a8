#pragma once

// Memory that is set aside for when there is none left.

#include <cstddef>

namespace palpate {

// While an object of this class lives, operator new that fails is helped out twice in the process:
// once where it is an error that frees things (destructors may take memory, as those of JSON
// do, and must not throw), and once where it is not, for the same reason. The third time it throws.
// It is done by std::set_new_handler, for the whole process; the handler that was there before is
// put back in the end. Any thread. Several add up to the largest.
class MemoryReserve {
 public:
  // bytes: of each of the two parts, at least. Throws std::bad_alloc.
  explicit MemoryReserve(std::size_t bytes = kEnoughForAnError);
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  // Gives up what is left of it: memory was short, and an error is to be told.
  static void give_up() noexcept;
  // Whether memory has been short. Some libraries keep that to themselves and say that they failed.
  static bool has_helped_out() noexcept;

 private:
  // Small enough for the C library to hand it out again in parts.
  static constexpr std::size_t kEnoughForAnError = std::size_t{1} << 16;
};

// Throws std::bad_alloc if so many bytes cannot be had at once: before what cannot do with less,
// and would end the process.
void expect_available(std::size_t bytes);

}  // namespace palpate
