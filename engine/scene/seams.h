#pragma once

// Seams between nodes: vertices of different nodes that coincide in the file, and are separated
// only by the rounding of the nodes' transforms.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/proxy/solver_corners.h"
#include "io/scene_description.h"

namespace palpate {

// A surface with the transform of its node, and with the transform that the solver uses for it.
struct SeamSurface {
  const NodeDescription* node;  // has the transform, and the index of the mesh among the meshes
  Mat3 deformation;             // linear part of the map from mesh frame to body frame, metres
  Quat rotation;                // rotation of T_scene_body
  // Further vertices that meet those of other surfaces (conforming.h). They are joined like
  // vertices of the boundary. Ascending.
  std::span<const std::uint32_t> met = {};
};

// A surface that shares a seam with another surface.
struct SeamBody {
  std::uint32_t surface;
  std::vector<JoinedVertex> joined;  // the vertices that were moved, in ascending order
};

struct Seams {
  std::vector<SeamBody> bodies;  // in ascending order
  std::size_t vertices = 0;      // joined vertices, including those that did not have to move
  std::size_t places = 0;        // distinct positions of the joined vertices
  // Surfaces whose coordinates are too large, relative to the scene, to decide which vertices
  // coincide. The list contains only surfaces with an open edge near another surface, and surfaces
  // near such an edge. None of their vertices is joined.
  std::vector<std::uint32_t> too_far;
  // Surfaces whose vertices are too close together, relative to the size of the scene, to be
  // distinguished. None of their vertices is joined.
  std::vector<std::uint32_t> crowded;
  // Not searched, because they and those before them have too many vertices together.
  std::vector<std::uint32_t> unsearched;
};

// Joins coinciding vertices of different surfaces. Two vertices coincide if their distance is at
// most the sum of the bounds on their rounding errors (see the .cpp). Joined vertices get the
// position of the vertex whose surface has the lowest number. At each place, at most one vertex of
// a surface is joined, namely the vertex nearest to the place. At least one of the joined vertices
// must lie on the boundary of its mesh or be listed in SeamSurface::met; other closed surfaces and
// separate surfaces are left alone.
//
// anchor_scene_m: the origin of the solver frame. size_m: the largest extent of the scene.
//
// The search costs almost nothing if no surface has such vertices or if there is only one surface.
// Otherwise its cost is O(n log n) in the number of surfaces, plus O(1) for each vertex of the
// surfaces that may touch an open surface. The ledger checks the temporary memory: up to 27 bytes
// for each boundary vertex of these surfaces, and about 200 bytes for each vertex near another
// surface. Deterministic.
Result<Seams> find_seams(const std::vector<WeldedSurface>& meshes,
                         std::span<const SeamSurface> surfaces, const Vec3& anchor_scene_m,
                         double size_m, MemoryLedger& ledger);

}  // namespace palpate
