#pragma once

// The memory ledger: counts the memory of one task against a limit and reports when memory is
// short.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/memory_reserve.h"
#include "geometry/base/result.h"

namespace palpate {

// The largest amount of memory that a task may use, and the source of this limit.
struct MemoryLimit {
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
  std::string origin = {};  // "half of the 3.1 GB that the machine has free"
  std::string option = {};  // the name of the setting, for the hint
};

// The amount as text, for example "1.2 GB". Units are decimal: 1 GB = 1000 MB.
std::string bytes_text(std::uint64_t bytes);

// Counts the memory of one task step by step. Each step declares its memory before allocating it.
// Not thread-safe: one thread declares the memory of all threads that it starts, before it starts
// them.
class MemoryLedger {
 public:
  MemoryLedger() = default;  // without a limit
  explicit MemoryLedger(MemoryLimit limit) : limit_(std::move(limit)) {}

  // Sets the hint that explains how a user can reduce the memory. Requires a string literal.
  void advise(const char* advice) { advice_ = advice; }
  // Begins a step on an element, for example "building the index" on "mesh \"cup\"". Throws
  // std::bad_alloc if memory was short in the step before.
  void begin(const char* step, std::string element = {});

  // Counts need.kept for the present step, before the step allocates it. Returns an Error
  // (kLimitExceeded) with limit, step and element, and counts nothing, if the step needs more than
  // is left.
  [[nodiscard]] std::optional<Error> take(const MemoryNeed& need);
  [[nodiscard]] std::optional<Error> take(std::uint64_t bytes) { return take({bytes, bytes}); }
  // Checks memory that the present step needs temporarily. Counts nothing.
  [[nodiscard]] std::optional<Error> check(std::uint64_t bytes) { return take({0, bytes}); }
  void give_back(std::uint64_t bytes) { taken_ -= std::min(bytes, taken_); }

  const MemoryLimit& limit() const { return limit_; }
  std::uint64_t taken() const { return taken_; }
  std::uint64_t left() const { return limit_.bytes - std::min(taken_, limit_.bytes); }

  // The Error (kOutOfMemory) for a failed allocation in the present step.
  Error out_of_memory() const;

 private:
  std::string with_advice(std::string hint) const;

  MemoryLimit limit_;
  std::uint64_t taken_ = 0;
  std::uint64_t declared_ = 0;  // bytes declared by the present step; 0 if undeclared
  const char* step_ = "";
  const char* advice_ = "";
  std::string element_;
};

// Whether the system was short of memory or threads.
inline bool is_memory_shortage(const std::system_error& error) {
  return error.code() == std::errc::not_enough_memory ||
         error.code() == std::errc::resource_unavailable_try_again;
}

// Calls work(), which returns a Result or an optional Error, and returns its value. Instead returns
// the Error of the ledger's present step if work() throws because memory is short. The ledger must
// be constructed before the objects of work(), so that their memory is free when the Error is made.
template <typename Work>
std::invoke_result_t<const Work&> or_out_of_memory(const MemoryLedger& ledger, const Work& work) {
  try {
    const MemoryReserve reserve;
    return work();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {  // a size beyond a container's max_size()
  } catch (const std::system_error& error) {
    if (!is_memory_shortage(error)) throw;
  }
  MemoryReserve::give_up();
  return ledger.out_of_memory();
}

}  // namespace palpate
