#pragma once

// The closed surfaces of a scene, and which of them enclose a point.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/mesh/closed_parts.h"

namespace palpate {

// Immutable after construction; any thread may read it. Refers to no part of the scene.
class ClosedSurfaces {
 public:
  // O(n log n) in the number of triangles.
  explicit ClosedSurfaces(const Scene& scene) : ClosedSurfaces(scene, std::nullopt) {}
  // Only surfaces whose boxes contain a point of the scene at the initial poses of the nodes; the
  // others count as open.
  ClosedSurfaces(const Scene& scene, const std::optional<Vec3>& p_scene_m);

  // One per object of the scene, which are the bodies of its world.
  std::span<const ClosedParts* const> of_objects() const { return of_objects_; }
  // No surface is closed.
  bool are_none() const { return are_none_; }

 private:
  std::vector<ClosedParts> of_meshes_;
  std::vector<const ClosedParts*> of_objects_;
  bool are_none_ = true;
};

// The first object that encloses a point of the scene at the initial poses of the nodes; no value
// if none does, or if the point lies on a surface. Not for the haptic thread.
std::optional<std::size_t> enclosing_object(const Scene& scene, const Vec3& p_scene_m);

// "node \"room\"", as printable text.
std::string object_text(const Scene& scene, std::size_t object);

}  // namespace palpate
