#pragma once

// Contact worlds, built from triangles in the scene frame.

#include <memory>
#include <vector>

#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/proxy/contact_world.h"

namespace palpate::test {

struct Soup {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
  void add_quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    add(a, b, c);
    add(a, c, d);
  }
};

// An axis-aligned box with outward faces.
inline Soup box_soup(const Vec3& half_extent) {
  Soup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 centre = Vec3::Zero();
      Vec3 u = Vec3::Zero();
      Vec3 v = Vec3::Zero();
      centre[axis] = side * half_extent[axis];
      u[(axis + 1) % 3] = half_extent[(axis + 1) % 3];
      v[(axis + 2) % 3] = side * half_extent[(axis + 2) % 3];
      soup.add_quad(centre - u - v, centre + u - v, centre + u + v, centre - u + v);
    }
  }
  return soup;
}

// A world of one body, together with the data it points to. T_scene_body places the soup in the
// scene.
class OwnedWorld {
 public:
  explicit OwnedWorld(const Soup& soup, const RigidTransform& T_scene_body = {},
                      double proxy_radius_m = 0.0)
      : mesh_(SurfaceMesh::build(soup.positions, soup.triangles)) {
    Box box{soup.positions.front(), soup.positions.front()};
    for (const Vec3& p : soup.positions) {
      box.low = box.low.cwiseMin(p);
      box.high = box.high.cwiseMax(p);
    }
    world_.size_m = (box.high - box.low).maxCoeff();
    const SolverScale scale = SolverScale::of(world_.size_m, proxy_radius_m);
    const double sweep = proxy_radius_m > 0.0 ? proxy_radius_m + 2 * scale.stand_off_m : 0.0;
    const Vec3 middle = 0.5 * (box.low + box.high);
    index_ = std::make_unique<SurfaceIndex>(mesh_, AffineMap{Mat3::Identity(), -middle}, sweep);
    world_.anchor_scene_m = T_scene_body.point(middle);
    const RigidTransform T_solver_body{T_scene_body.rotation, Vec3::Zero()};
    const double reach = 0.5 * (box.high - box.low).norm();
    world_.bounds_solver = {Vec3::Constant(-reach), Vec3::Constant(reach)};
    world_.bodies.push_back(
        {index_.get(), T_solver_body, T_scene_body.rotation.coeffs() == Quat::Identity().coeffs()});
  }
  void set_effects(std::shared_ptr<const EffectProgram> effects) { world_.effects = effects; }
  const ContactWorld& world() const { return world_; }
  const SurfaceIndex& index() const { return *index_; }
  const SurfaceMesh& mesh() const { return mesh_; }

 private:
  SurfaceMesh mesh_;
  std::unique_ptr<SurfaceIndex> index_;
  ContactWorld world_;
};

}  // namespace palpate::test
