#pragma once

// The work of a tick in counted units: a bound on its time that is the same on every machine.

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/index/ordered_boxes.h"

namespace palpate {

// The meter counts the operations whose number depends on the scene, each with a price in units.
// The count is not a clock: processor load, other threads and the instruction set do not change it.
using WorkUnits = std::int64_t;

// The kinds of operations that are counted.
enum class Work : std::uint8_t {
  kBody,               // search of a body: transform and index query
  kPack,               // visit of a pack and its tests in single precision, for a point
  kSpherePack,         // the same for a sphere
  kNearestPack,        // visit of a pack in a search for the nearest point of a surface, which
                       // finds it in no order of the memory
  kTriangle,           // test of a triangle in double precision
  kNearestPoint,       // nearest point of a triangle to a point
  kSignByPairs,        // sign by pairs of doubles, after double failed
  kSignByZeros,        // sign 0 that pairs decided, since all products in it are 0
  kSignByExpansions,   // sign by expansions, after pairs failed
  kPackListed,         // pack that was listed and kept, or found together with too many others, so
                       // that the search was repeated
  kListed,             // body found together with too many others
  kSorted,             // pack or body that a query found and sorted
  kBodySeen,           // body whose box a query meets, whether it is searched or not
  kBoxes,              // test of sixteen boxes in a search in order of numbers
  kStretchedTriangle,  // triangle of a stretched body, mapped to the body frame; triangle at
                       // corners in the solver frame
  kPlace,              // solver of effects: distance of a magnet or a medium
  kContact,            // solver: contact of the proxy with a known face
  kPlane,              // solver: test of one contact plane or direction
  kStep,               // solver: a step, without the searches in it
};
inline constexpr std::size_t kWorkKinds = 19;

// The price of each kind, in units.
using WorkPrices = std::array<WorkUnits, kWorkKinds>;

// The rule of counting: which operations count, and for how much. The count decides where a capped
// tick ends, so recordings name their rule and are replayed with it. A change of a price needs a
// new rule.
enum class CountingRule : std::uint8_t {
  kFirst = 1,  // of recordings that name no rule: some operations are free, effects have no budget
  kSecond = 2
};

// One unit takes at most 23 ns with any kind of work under the second rule, measured on the machine
// of docs/study/results-ticks.md (work_prices.cpp).
inline constexpr WorkPrices kFirstPrices = {6, 10, 10, 0, 6, 2, 4, 18, 18, 1,
                                            0, 0,  0,  0, 0, 0, 0, 0,  0};
inline constexpr WorkPrices kSecondPrices = {14, 10, 12, 20, 6,  6, 9, 9, 26, 1,
                                             3,  6,  6,  4,  14, 6, 6, 1, 36};

constexpr const WorkPrices& prices_of(CountingRule rule) {
  return rule == CountingRule::kFirst ? kFirstPrices : kSecondPrices;
}

// The price of one operation under the second rule.
constexpr WorkUnits price_of(Work kind) {
  return kSecondPrices[static_cast<std::size_t>(kind)];
}

// Counts the work of a tick against its budget. Safe on the haptic thread: no allocation, lock or
// exception. Not thread-safe: one thread owns a meter.
//
// A step that was cut short is repeated in the next tick: its searches are remembered, the work of
// the solver between them is not. A tick therefore ends only when its searches have used half of
// the budget, so that they proceed in every tick. The solver's work without its searches has a
// bound of its own: the numbers of steps and attempts are constants (god_object_steps.h and
// god_object_escapes.h).
class WorkMeter {
 public:
  explicit WorkMeter(WorkUnits budget, CountingRule rule = CountingRule::kSecond)
      : budget_(budget), prices_(prices_of(rule)) {}

  void begin_tick() { used_ = of_solver_ = 0; }
  void add(Work kind, std::size_t count = 1) { used_ += units_of(kind, count); }
  // For the kinds of the solver.
  void add_of_solver(Work kind, std::size_t count = 1) {
    const WorkUnits units = units_of(kind, count);
    used_ += units;
    of_solver_ += units;
  }
  void add(const QueryWork& query) {
    add(Work::kListed, query.listed);
    add(Work::kSorted, query.sorted);
    add(Work::kBoxes, query.boxes);
  }

  WorkUnits used() const { return used_; }
  WorkUnits budget() const { return budget_; }
  bool is_spent() const { return used_ >= budget_ && 2 * (used_ - of_solver_) >= budget_; }

 private:
  WorkUnits units_of(Work kind, std::size_t count) const {
    return static_cast<WorkUnits>(count) * prices_[static_cast<std::size_t>(kind)];
  }

  WorkUnits budget_;
  WorkUnits used_ = 0;
  WorkUnits of_solver_ = 0;  // part of used_
  WorkPrices prices_;
};

}  // namespace palpate
