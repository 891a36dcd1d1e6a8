#pragma once

// Worlds of several bodies, each of them a soup with a pose of its own.

#include <memory>
#include <vector>

#include "geometry/index/surface_index.h"
#include "haptics/proxy/contact_world.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

// A world of bodies, together with the data it points to. The solver frame is the scene frame.
class OwnedBodies {
 public:
  struct Placed {
    Soup soup;  // body frame
    RigidTransform T_solver_body;
  };

  explicit OwnedBodies(const std::vector<Placed>& bodies, double proxy_radius_m = 0.0,
                       bool with_tree = false) {
    Box bounds;
    for (const Placed& placed : bodies) {
      for (const Vec3& p : placed.soup.positions) {
        const Vec3 p_solver = placed.T_solver_body.point(p);
        const bool is_first = &placed == &bodies.front() && &p == &placed.soup.positions.front();
        bounds = is_first ? Box{p_solver, p_solver} : bounds.united({p_solver, p_solver});
      }
    }
    world_.bounds_solver = bounds;
    world_.size_m = (bounds.high - bounds.low).maxCoeff();
    const double stand_off = SolverScale::of(world_.size_m, proxy_radius_m).stand_off_m;
    const double sweep = proxy_radius_m > 0.0 ? proxy_radius_m + 2 * stand_off : 0.0;
    std::vector<Box> boxes;
    for (const Placed& placed : bodies) {
      const SurfaceMesh mesh = SurfaceMesh::build(placed.soup.positions, placed.soup.triangles);
      indices_.push_back(std::make_unique<SurfaceIndex>(mesh, AffineMap{}, sweep));
      world_.bodies.push_back({indices_.back().get(), {}, true});
      world_.bodies.back().place(placed.T_solver_body);
      boxes.push_back(world_.bodies.back().box_solver());
    }
    if (with_tree) world_.tree = std::make_shared<BoxTree>(boxes, sweep);
  }

  void set_effects(std::shared_ptr<const EffectProgram> effects) { world_.effects = effects; }
  const ContactWorld& world() const { return world_; }

  // The triangles of a body that the engine uses, in the body frame.
  std::vector<Corners> triangles(std::size_t body) const {
    const SurfaceIndex& index = *indices_[body];
    std::vector<Corners> triangles;
    for (std::uint32_t pack = 0; pack < index.pack_count(); ++pack) {
      for (int lane = 0; lane < index.pack(pack).count; ++lane) {
        const TriangleGeometry& t = index.triangle(SurfaceIndex::slot(pack, lane));
        triangles.push_back({t.a, t.b, t.c});
      }
    }
    return triangles;
  }

 private:
  std::vector<std::unique_ptr<SurfaceIndex>> indices_;
  ContactWorld world_;
};

}  // namespace palpate::test
