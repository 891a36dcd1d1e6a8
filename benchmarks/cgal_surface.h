#pragma once

// The other peer: the same queries on CGAL's AABB_tree, in double, over triangles it stores itself.

#include <memory>
#include <optional>

#include "models/primitives.h"

namespace palpate::bench {

// Whether CGAL was there when this was built. Without it, nothing below may be called.
extern const bool kHaveCgal;

class CgalSurface {
 public:
  explicit CgalSurface(const TriangleMesh& mesh);
  ~CgalSurface();
  CgalSurface(CgalSurface&&) noexcept;
  CgalSurface& operator=(CgalSurface&&) noexcept;

  // The nearest surface point. hint: a point of the surface, the nearer the faster.
  Vec3 closest_point(const Vec3& p, const Vec3& hint) const;

  // The fraction of the segment p to p + d at which it meets a triangle, any of them.
  std::optional<double> any_hit(const Vec3& p, const Vec3& d) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace palpate::bench
