#pragma once

// A tree over boxes that finds the boxes near a point or along a segment.

#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/index/ordered_boxes.h"
#include "geometry/index/triangle_pack.h"

namespace palpate {

class EmbreeBoxes;

// An immutable BVH over axis-aligned boxes in one frame, metres. The origin of the frame should be
// near the middle of the boxes. Queries use single precision with conservative rounding: they find
// every box in range, and may also report a box that is out of range by a rounding error. The
// reported boxes do not depend on the instruction set.
//
// Queries: no allocation, lock or exception; thread-safe; safe on the haptic thread. Query points
// must be finite. Queries may be nested: a query of this tree may be started inside a visitor that
// another tree or index is calling.
class BoxTree {
 public:
  // sweep_radius_m: the largest radius allowed in visit_along().
  BoxTree(const std::vector<Box>& boxes, double sweep_radius_m);
  ~BoxTree();
  BoxTree(const BoxTree&) = delete;
  BoxTree& operator=(const BoxTree&) = delete;

  // Receives the index of a box; returns whether the search should continue. Must not throw.
  using Visitor = bool (*)(void* state, std::uint32_t box);
  // Visits the boxes within radius_m of p, in ascending order. Returns the work beside that of the
  // visitor.
  QueryWork visit_near(const Vec3& p, double radius_m, NearSearch search, Visitor visitor,
                       void* state) const noexcept;
  // Visits the boxes within radius_m <= sweep_radius_m of the segment p to p + d, in ascending
  // order, starting at index `first`. A segment of zero length visits no box. Returns the work
  // beside that of the visitor.
  QueryWork visit_along(const Vec3& p, const Vec3& d, double radius_m, std::uint32_t first,
                        Visitor visitor, void* state) const noexcept;

  double sweep_radius_m() const { return sweep_radius_m_; }

  // The memory needed for a tree over this number of boxes.
  static MemoryNeed memory_need(std::uint64_t boxes);
  std::size_t memory_bytes() const;

 private:
  Box bounds_;  // around all boxes, with all margins
  double sweep_radius_m_;
  std::vector<BoxPack> groups_;  // the boxes with rounding margins
  OrderedBoxes ordered_groups_;
  std::unique_ptr<EmbreeBoxes> boxes_;
};

}  // namespace palpate
