#pragma once

// The work of a tick in counted units: a bound on its time that is the same on every machine.

#include <cstdint>

namespace palpate {

// The meter counts the operations whose number depends on the scene, weighted by their cost. One
// unit takes 10 to 20 ns on a processor at 2 to 3 GHz with no scene data in its first two cache
// levels. The weights make this time about the same for all inputs of
// benchmarks/worst_benchmark.cpp. The count is not a clock: processor load, other threads and the
// instruction set do not change it.
using WorkUnits = std::int64_t;

namespace work {

inline constexpr WorkUnits kBody = 6;          // search of a body: transform and index query
inline constexpr WorkUnits kPack = 10;         // visit of a pack and its tests in single precision
inline constexpr WorkUnits kTriangle = 6;      // test of a triangle in double precision
inline constexpr WorkUnits kNearestPoint = 2;  // nearest point of a triangle to a point
inline constexpr WorkUnits kSignByPairs = 4;   // sign by pairs of doubles, after double failed
inline constexpr WorkUnits kSignByExpansions = 18;  // sign by expansions, after pairs failed
inline constexpr WorkUnits kPackNamed = 1;          // pack listed by a query but not yet tested

}  // namespace work

// Counts the work of a tick against its budget. Safe on the haptic thread: no allocation, lock or
// exception. Not thread-safe: one thread owns a meter.
class WorkMeter {
 public:
  explicit WorkMeter(WorkUnits budget) : budget_(budget) {}

  void begin_tick() { used_ = 0; }
  void add(WorkUnits units) { used_ += units; }

  WorkUnits used() const { return used_; }
  WorkUnits budget() const { return budget_; }
  bool is_spent() const { return used_ >= budget_; }

 private:
  WorkUnits budget_;
  WorkUnits used_ = 0;
};

}  // namespace palpate
