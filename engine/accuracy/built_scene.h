#pragma once

// Scenes that the measurements build.

#include <functional>
#include <memory>
#include <string>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "models/primitives.h"

namespace palpate {

// Compiles a scene of one node with this mesh, without effects, in the same way as the scene of a
// file.
// place_m: translation of the node.
Result<std::shared_ptr<const Scene>> compile_mesh(TriangleMesh mesh, double proxy_radius_m = 0.0,
                                                  const Vec3& place_m = Vec3::Zero());

// compile_mesh() for a mesh that is known to compile. If it does not compile, the program ends.
std::shared_ptr<const Scene> mesh_scene(TriangleMesh mesh, double proxy_radius_m = 0.0,
                                        const Vec3& place_m = Vec3::Zero());

// A scene that is compiled on first use and then kept. Copies of this object share the scene.
class LazyScene {
 public:
  explicit LazyScene(std::function<std::shared_ptr<const Scene>()> make)
      : held_(std::make_shared<Held>(Held{std::move(make), nullptr})) {}

  const Scene& get() const {
    if (!held_->scene) held_->scene = held_->make();
    return *held_->scene;
  }
  const ContactWorld& world() const { return get().world(); }

 private:
  struct Held {
    std::function<std::shared_ptr<const Scene>()> make;
    std::shared_ptr<const Scene> scene;
  };
  std::shared_ptr<Held> held_;
};

// The error, in metres and in the scene frame, that the rounding of the numbers in the scene's file
// causes in positions on surfaces. The result is float_floor_m() of the largest absolute coordinate
// of any mesh, in the frame of the mesh and at the scale of its node; the translations of nodes
// lose no digits.
double file_floor_m(const Scene& scene);

// "320 triangles", "1.3k triangles", "82k triangles", "1.3M triangles".
std::string triangles_label(std::size_t triangles);

// Mean length of the edges of the triangles, in metres.
double mean_edge_m(const TriangleMesh& mesh);

}  // namespace palpate
