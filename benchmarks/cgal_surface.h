#pragma once

// CGAL is the second peer, that is, the second library with which Palpate is compared. It answers
// the same queries as Palpate with its AABB_tree, in double, on its own copy of the triangles.

#include <memory>
#include <optional>

#include "models/primitives.h"

namespace palpate::bench {

// Whether this program was built with CGAL. Without CGAL, no function below may be called.
extern const bool kHaveCgal;

class CgalSurface {
 public:
  explicit CgalSurface(const TriangleMesh& mesh);
  ~CgalSurface();
  CgalSurface(CgalSurface&&) noexcept;
  CgalSurface& operator=(CgalSurface&&) noexcept;

  // The nearest surface point. hint: any point of the surface; the nearer it is to p, the faster
  // the query is.
  Vec3 closest_point(const Vec3& p, const Vec3& hint) const;

  // The fraction of the segment p to p + d at which it meets some triangle, not necessarily
  // the first.
  std::optional<double> any_hit(const Vec3& p, const Vec3& d) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace palpate::bench
