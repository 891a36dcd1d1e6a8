#include "tests/helpers/peak_memory.h"

#include <atomic>
#include <cstdlib>
#include <limits>
#include <malloc.h>
#include <new>

namespace {

std::atomic<std::size_t> g_held{0};
std::atomic<std::size_t> g_peak{0};

constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kLeft = 4096;
std::atomic<std::size_t> g_most{kNever};
std::atomic<std::size_t> g_calls{0};
std::atomic<std::size_t> g_failing{kNever};

bool is_beyond_bound(std::size_t size) {
  const std::size_t most = g_most;
  return most != kNever && (size > most || g_held > most - size);
}

void* counted(void* block) {
  const std::size_t held = g_held += malloc_usable_size(block);
  std::size_t peak = g_peak;
  while (held > peak && !g_peak.compare_exchange_weak(peak, held)) {
  }
  return block;
}

template <typename Allocate>
void* allocate(std::size_t size, const Allocate& from_library) {
  if (g_calls++ == g_failing) g_most = g_held + kLeft;
  while (true) {
    if (!is_beyond_bound(size)) {
      if (void* const block = from_library()) return counted(block);
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void release(void* block) noexcept {
  if (!block) return;
  g_held -= malloc_usable_size(block);
  std::free(block);
}

void* allocate_plain(std::size_t size) {
  return allocate(size, [size] { return std::malloc(size); });
}

void* allocate_aligned(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  if (size > static_cast<std::size_t>(-1) - step) throw std::bad_alloc();
  return allocate(size, [&] { return std::aligned_alloc(step, (size + step - 1) / step * step); });
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate_plain(size);
}
void* operator new[](std::size_t size) {
  return allocate_plain(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate_aligned(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate_aligned(size, alignment);
}
// The non-throwing forms are replaced, too: a sanitizer's own would not be counted at allocation,
// but at release.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return allocate_plain(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void operator delete(void* block) noexcept {
  release(block);
}
void operator delete[](void* block) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}

namespace palpate::test {

PeakMemory::PeakMemory() : start_(g_held) {
  g_peak = start_;
}

std::size_t PeakMemory::bytes() const {
  return g_peak - start_;
}

BoundedMemory::BoundedMemory(std::size_t bytes) {
  g_most = g_held + bytes;
}

BoundedMemory::~BoundedMemory() {
  g_most = kNever;
}

FailingMemory::FailingMemory(std::size_t n) {
  g_calls = 0;
  g_failing = n;
}

FailingMemory::~FailingMemory() {
  g_failing = kNever;
  g_most = kNever;
}

std::size_t FailingMemory::calls() {
  return g_calls;
}

std::size_t held_memory() {
  return g_held;
}

}  // namespace palpate::test
