#pragma once

// Which of many boxes are near a point or on the way of a segment.

#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/index/ordered_boxes.h"
#include "geometry/index/triangle_pack.h"

namespace palpate {

class EmbreeBoxes;

// An immutable BVH over axis-aligned boxes in one frame, metres, which should have its origin near
// their middle. Answers in single precision, on the safe side: a box may be reported that is a
// rounding too far away, none is missed. Which ones are does not depend on the instruction set.
//
// Queries: no allocation, lock or exception; thread-safe; safe on the haptic thread; they may be
// made from inside a visitor of another tree or index. Query points must be finite.
class BoxTree {
 public:
  // sweep_radius_m: the largest radius that visit_along() will be asked for.
  BoxTree(const std::vector<Box>& boxes, double sweep_radius_m);
  ~BoxTree();
  BoxTree(const BoxTree&) = delete;
  BoxTree& operator=(const BoxTree&) = delete;

  // Told of a box by its index; returns whether more are wanted. Must not throw.
  using Visitor = bool (*)(void* state, std::uint32_t box);
  // Visits the boxes that come within radius_m of p, in ascending order.
  void visit_near(const Vec3& p, double radius_m, NearSearch search, Visitor visitor,
                  void* state) const noexcept;
  // Visits the boxes that come within radius_m <= sweep_radius_m of the segment p to p + d, in
  // ascending order, from number `first` on. A segment of no length visits nothing.
  void visit_along(const Vec3& p, const Vec3& d, double radius_m, std::uint32_t first,
                   Visitor visitor, void* state) const noexcept;

  double sweep_radius_m() const { return sweep_radius_m_; }

  // What a tree over so many boxes takes.
  static MemoryNeed memory_need(std::uint64_t boxes);
  std::size_t memory_bytes() const;

 private:
  Box bounds_;  // around all boxes, with all margins
  double sweep_radius_m_;
  std::vector<BoxPack> groups_;  // the boxes with the margins of rounding
  OrderedBoxes ordered_groups_;
  std::unique_ptr<EmbreeBoxes> boxes_;
};

}  // namespace palpate
