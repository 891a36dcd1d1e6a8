#pragma once

// On which side of a line an edge passes: three ways to be sure of the sign.
//
// The question behind "does a segment meet a triangle" (geometry/exact/segment_triangle.h): the sign of
// d . ((from - p) x (to - p)), positive if the edge passes the line on its left. Each way starts
// with a filter in double; they differ in what follows when it cannot tell.

#include <memory>
#include <span>

#include "geometry/base/types.h"

namespace palpate::bench {

// A line through p along d, which is not zero, and an edge. p + d is a double to the bit, so that
// the line is the same whether it is given by a direction or by two points.
struct SideInput {
  Vec3 p, d, from, to;
};

// Whether the filter that the first two ways share settles it.
bool filter_decides(const SideInput& input);

// 113-bit arithmetic in software. 0 also when that cannot tell.
int side_float128(const SideInput& input);

// What the engine uses (geometry/exact/orientation.h): pairs of doubles, then expansions. Exact, for
// coordinates whose products neither overflow nor underflow.
int side_adaptive(const SideInput& input);

// The orientation predicate of CGAL's Exact_predicates_inexact_constructions_kernel. Exact.
class CgalSideTest {
 public:
  explicit CgalSideTest(std::span<const SideInput> inputs);
  ~CgalSideTest();

  int side(std::size_t n) const;  // of inputs[n]

 private:
  struct Inputs;
  std::unique_ptr<Inputs> inputs_;
};

}  // namespace palpate::bench
