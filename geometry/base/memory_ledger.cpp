#include "geometry/base/memory_ledger.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace palpate {
std::string bytes_text(std::uint64_t bytes) {
  constexpr std::array<const char*, 4> kUnits = {"kB", "MB", "GB", "TB"};
  constexpr double kStep = 1000.0;
  if (bytes < 1000) return std::to_string(bytes) + " bytes";
  double amount = static_cast<double>(bytes) / kStep;
  std::size_t unit = 0;
  // A number that rounds to 1000 is printed as 1.00 of the next unit.
  for (; amount >= 999.5 && unit + 1 < kUnits.size(); ++unit) amount /= kStep;
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(),
                amount < 9.995   ? "%.2f"
                : amount < 99.95 ? "%.1f"
                                 : "%.0f",
                amount);
  return std::string(text.data()) + " " + kUnits[unit];
}

void MemoryLedger::begin(const char* step, std::string element) {
  expect_no_shortage();
  step_ = step;
  element_ = std::move(element);
  declared_ = 0;
}

std::optional<Error> MemoryLedger::take(const MemoryNeed& need) {
  declared_ = std::max(need.kept, need.peak);
  if (declared_ <= left()) {
    taken_ += need.kept;
    return std::nullopt;
  }
  std::string problem = std::string(step_) + " needs " + bytes_text(declared_);
  if (taken_ > 0) problem += " in addition to the " + bytes_text(taken_) + " already in use";
  problem += "; the limit is " + bytes_text(limit_.bytes) + ", " + limit_.origin;
  return Error{
      ErrorCode::kLimitExceeded, "", element_, std::move(problem),
      with_advice(limit_.option.empty() ? "free memory" : "raise the limit with " + limit_.option)};
}

Error MemoryLedger::out_of_memory() const {
  std::string problem = std::string("the system has not enough memory for ") + step_;
  if (declared_ > 0) problem += ", which needs " + bytes_text(declared_);
  return Error{ErrorCode::kOutOfMemory, "", element_, std::move(problem),
               with_advice("free memory, or raise the limit of the process (ulimit -v)")};
}

std::string MemoryLedger::with_advice(std::string hint) const {
  return *advice_ != 0 ? hint + ", or " + advice_ : hint;
}

}  // namespace palpate
