#pragma once

// How much memory a piece of work may take, what it has taken, and what it says when there is no
// more.

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

// The most that may be taken, and who says so.
struct MemoryLimit {
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
  std::string origin = {};  // "half of the 3.1 GB that the machine has free"
  std::string option = {};  // names the setting, for the hint
};

// "1.2 GB", of 1000 MB.
std::string bytes_text(std::uint64_t bytes);

// What one piece of work has taken, step by step: each step says what it is about to take. For one
// thread; what it starts others for, it counts before.
class MemoryLedger {
 public:
  MemoryLedger() = default;  // without a limit
  explicit MemoryLedger(MemoryLimit limit) : limit_(std::move(limit)) {}

  // What a user can do to take less, for the hints: a literal.
  void advise(const char* advice) { advice_ = advice; }
  // What is done from now on, and to what: "building the index" of "mesh \"cup\"".
  void begin(const char* step, std::string element = {});

  // Counts what the present step keeps, before it is taken. An Error (kLimitExceeded) that names
  // limit, step and element if the step needs more than is left; nothing is counted then.
  [[nodiscard]] std::optional<Error> take(const MemoryNeed& need);
  [[nodiscard]] std::optional<Error> take(std::uint64_t bytes) { return take({bytes, bytes}); }
  // What the present step needs while it runs, and keeps nothing of.
  [[nodiscard]] std::optional<Error> check(std::uint64_t bytes) { return take({0, bytes}); }
  void give_back(std::uint64_t bytes) { taken_ -= std::min(bytes, taken_); }

  const MemoryLimit& limit() const { return limit_; }
  std::uint64_t taken() const { return taken_; }
  std::uint64_t left() const { return limit_.bytes - std::min(taken_, limit_.bytes); }

  // The system had no more of it in the present step (kOutOfMemory).
  Error out_of_memory() const;

 private:
  std::string with_advice(std::string hint) const;

  MemoryLimit limit_;
  std::uint64_t taken_ = 0;
  std::uint64_t asked_ = 0;  // by the present step, if it has said so
  const char* step_ = "";
  const char* advice_ = "";
  std::string element_;
};

// Whether it is memory, or a thread, that the system did not have.
inline bool is_want_of_memory(const std::system_error& error) {
  return error.code() == std::errc::not_enough_memory ||
         error.code() == std::errc::resource_unavailable_try_again;
}

// What work() returns (a Result, or an optional Error); or, where it throws because there is not
// enough memory, the Error of the step that the ledger was in. The ledger must be older than what
// work() takes, so that all of that has been given back when the Error is made.
template <typename Work>
std::invoke_result_t<const Work&> or_out_of_memory(const MemoryLedger& ledger, const Work& work) {
  try {
    const MemoryReserve reserve;
    return work();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {  // a container was asked for more than there can be
  } catch (const std::system_error& error) {
    if (!is_want_of_memory(error)) throw;
  }
  MemoryReserve::give_up();
  return ledger.out_of_memory();
}

}  // namespace palpate
