#include "benchmarks/cgal_surface.h"

#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/version.h>
#include <vector>

#if CGAL_VERSION_MAJOR >= 6  // Debian 13; 12 has CGAL 5
#include <CGAL/AABB_traits_3.h>
#include <CGAL/AABB_triangle_primitive_3.h>
#include <variant>
#else
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <boost/variant/get.hpp>
#endif

namespace palpate::bench {
namespace {

// The kernel without exact predicates: the fastest that CGAL offers for distances.
using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
#if CGAL_VERSION_MAJOR >= 6
using Primitive = CGAL::AABB_triangle_primitive_3<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits_3<Kernel, Primitive>>;
using std::get_if;
#else
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
template <typename Held, typename Variant>
const Held* get_if(const Variant* variant) {
  return boost::get<Held>(variant);
}
#endif

Point to_cgal(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}
Vec3 from_cgal(const Point& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

const bool kHaveCgal = true;

struct CgalSurface::Tree {
  Triangles triangles;
  AabbTree tree;
};

CgalSurface::CgalSurface(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>()) {
  tree_->triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    tree_->triangles.emplace_back(to_cgal(mesh.positions_m[t[0]]), to_cgal(mesh.positions_m[t[1]]),
                                  to_cgal(mesh.positions_m[t[2]]));
  }
  // Every query passes a hint, so the tree of hints would never be used.
  tree_->tree.do_not_accelerate_distance_queries();
  tree_->tree.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
  tree_->tree.build();
}

CgalSurface::~CgalSurface() = default;
CgalSurface::CgalSurface(CgalSurface&&) noexcept = default;
CgalSurface& CgalSurface::operator=(CgalSurface&&) noexcept = default;

Vec3 CgalSurface::closest_point(const Vec3& p, const Vec3& hint) const {
  return from_cgal(tree_->tree.closest_point(to_cgal(p), to_cgal(hint)));
}

std::optional<double> CgalSurface::any_hit(const Vec3& p, const Vec3& d) const {
  const auto hit = tree_->tree.any_intersection(Kernel::Segment_3(to_cgal(p), to_cgal(p + d)));
  if (!hit) return std::nullopt;
  const Point* point = get_if<Point>(&hit->first);
  if (!point) return std::nullopt;  // a segment in the plane of a triangle meets it in a segment
  return (from_cgal(*point) - p).dot(d) / d.squaredNorm();
}

}  // namespace palpate::bench
