#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <array>
#include <vector>

#include "benchmarks/side_tests.h"

namespace palpate::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 to_cgal(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

struct CgalSideTest::Inputs {
  std::vector<std::array<Kernel::Point_3, 4>> points;
};

CgalSideTest::CgalSideTest(std::span<const SideInput> inputs)
    : inputs_(std::make_unique<Inputs>()) {
  for (const SideInput& in : inputs) {
    inputs_->points.push_back(
        {to_cgal(in.p), to_cgal(in.p + in.d), to_cgal(in.from), to_cgal(in.to)});
  }
}

CgalSideTest::~CgalSideTest() = default;

int CgalSideTest::side(std::size_t n) const {
  const auto& [p, q, from, to] = inputs_->points[n];
  return CGAL::orientation(p, q, from, to);
}

}  // namespace palpate::bench
