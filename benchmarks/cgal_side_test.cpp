#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <array>
#include <vector>

#include "benchmarks/side_tests.h"

namespace palpate::bench {
namespace {

using ExactKernel = CGAL::Exact_predicates_inexact_constructions_kernel;

ExactKernel::Point_3 to_exact(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

struct CgalSideTest::Inputs {
  std::vector<std::array<ExactKernel::Point_3, 4>> points;
};

CgalSideTest::CgalSideTest(std::span<const SideInput> inputs)
    : inputs_(std::make_unique<Inputs>()) {
  for (const SideInput& in : inputs) {
    inputs_->points.push_back(
        {to_exact(in.p), to_exact(in.p + in.d), to_exact(in.from), to_exact(in.to)});
  }
}

CgalSideTest::~CgalSideTest() = default;

int CgalSideTest::side(std::size_t n) const {
  const auto& [p, q, from, to] = inputs_->points[n];
  return CGAL::orientation(p, q, from, to);
}

}  // namespace palpate::bench
