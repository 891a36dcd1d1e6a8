#include "geometry/base/memory_reserve.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <utility>

namespace palpate {
namespace {

// A block that begins with its own size.
struct ReservedBlock {
  std::atomic<std::size_t*> block = nullptr;

  void fill(std::size_t bytes) {
    if (const std::size_t* old = block.load(); old != nullptr && *old >= bytes) return;
    auto* const larger = static_cast<std::size_t*>(::operator new(bytes));
    *larger = bytes;
    ::operator delete(block.exchange(larger));
  }
  bool give_up() noexcept {
    std::size_t* const given = block.exchange(nullptr);
    ::operator delete(given);
    return given != nullptr;
  }
};

ReservedBlock for_unwinding;
ReservedBlock for_going_on;
std::mutex of_reserves;
std::atomic<std::size_t> reserves = 0;  // changed under of_reserves
std::atomic<std::new_handler> handler_before = nullptr;

void help_out() {
  if ((std::uncaught_exceptions() > 0 ? for_unwinding : for_going_on).give_up()) return;
  if (const std::new_handler before = handler_before.load()) return before();
  throw std::bad_alloc();
}

}  // namespace

MemoryReserve::MemoryReserve(std::size_t bytes) {
  bytes = std::max(bytes, kEnoughForAnError);
  const std::lock_guard lock(of_reserves);
  for_unwinding.fill(bytes);
  for_going_on.fill(bytes);
  if (reserves++ == 0) handler_before = std::set_new_handler(help_out);
}

MemoryReserve::~MemoryReserve() {
  const std::lock_guard lock(of_reserves);
  if (--reserves > 0) return;
  std::set_new_handler(handler_before.exchange(nullptr));
  give_up();
}

void MemoryReserve::give_up() noexcept {
  for_unwinding.give_up();
  for_going_on.give_up();
}

bool MemoryReserve::has_helped_out() noexcept {
  return reserves.load() > 0 &&
         (for_unwinding.block.load() == nullptr || for_going_on.block.load() == nullptr);
}

void expect_no_shortage() {
  if (MemoryReserve::has_helped_out()) throw std::bad_alloc();
}

void expect_available(std::size_t bytes) {
  ::operator delete(::operator new(bytes));
}

}  // namespace palpate
