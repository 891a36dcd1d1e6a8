#pragma once

// How much a tick does, counted: what bounds it in time, and is the same on every machine.

#include <cstdint>

namespace palpate {

// What is counted is all whose number the scene decides, each weighed by what it takes. A unit is
// 10 to 20 ns of a processor at 2 to 3 GHz that has nothing of the scene in its first two caches;
// the weights are such that it is about the same on all inputs of benchmarks/worst_benchmark.cpp.
// Not a clock: load, threads and the instruction set change nothing.
using WorkUnits = std::int64_t;

namespace work {

inline constexpr WorkUnits kBody = 6;          // entered: a transform, a query that finds little
inline constexpr WorkUnits kPack = 10;         // asked whether one of its triangles is in the way
inline constexpr WorkUnits kTriangle = 6;      // examined in double
inline constexpr WorkUnits kNearestPoint = 2;  // of a triangle to a point
inline constexpr WorkUnits kSignByPairs = 4;   // that double could not tell
inline constexpr WorkUnits kSignByExpansions = 18;  // that pairs of doubles could not tell either
inline constexpr WorkUnits kPackNamed = 1;          // found near a point, and kept

}  // namespace work

// Counts the work of a tick against its budget. One thread owns it.
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
