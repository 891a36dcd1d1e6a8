// Replaces all code that needs CGAL where CGAL is not installed.

#include <cstdlib>

#include "benchmarks/cgal_surface.h"
#include "benchmarks/registration.h"

namespace palpate::bench {

const bool kHaveCgal = false;

struct CgalSurface::Tree {};

CgalSurface::CgalSurface(const TriangleMesh&) {
  std::abort();
}
CgalSurface::~CgalSurface() = default;
CgalSurface::CgalSurface(CgalSurface&&) noexcept = default;
CgalSurface& CgalSurface::operator=(CgalSurface&&) noexcept = default;

Vec3 CgalSurface::closest_point(const Vec3&, const Vec3&) const {
  std::abort();
}

std::optional<double> CgalSurface::any_hit(const Vec3&, const Vec3&) const {
  std::abort();
}

void register_side_test_benchmarks() {}

}  // namespace palpate::bench
