#pragma once

// Three methods to compute the sign that tells on which side of a line an edge passes.
//
// The test whether a segment meets a triangle (geometry/exact/segment_triangle.h) needs the sign of
// d . ((from - p) x (to - p)), which is positive if the edge passes on the left of the line. Each
// method begins with a filter in double. The methods differ in the arithmetic that they use when
// the filter is undecided.

#include <memory>
#include <span>

#include "geometry/base/types.h"

namespace palpate::bench {

// An edge, and a line through p along d. d is not zero. p + d is exact in double, so that a
// direction and a second point describe the same line.
struct SideInput {
  Vec3 p, d, from, to;
};

// Whether the filter shared by the first two methods decides the sign.
bool filter_decides(const SideInput& input);

// 113-bit arithmetic in software. Also returns 0 if 113 bits do not decide the sign.
int side_float128(const SideInput& input);

// The method of the engine (geometry/exact/orientation.h): pairs of doubles, then expansions. Exact
// for coordinates whose products neither overflow nor underflow.
int side_adaptive(const SideInput& input);

// The orientation predicate of CGAL's Exact_predicates_inexact_constructions_kernel. Exact.
class CgalSideTest {
 public:
  explicit CgalSideTest(std::span<const SideInput> inputs);
  ~CgalSideTest();

  int side(std::size_t n) const;  // side for inputs[n]

 private:
  struct Inputs;
  std::unique_ptr<Inputs> inputs_;
};

}  // namespace palpate::bench
