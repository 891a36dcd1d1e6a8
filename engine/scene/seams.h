#pragma once

// Where the nodes of a scene meet: vertices of different nodes that the file puts in one place, and
// that only the rounding of the nodes' transforms keeps apart.

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

// A surface in its place, with what the solver has for its place.
struct SeamSurface {
  const NodeDescription* node;  // its transform; its mesh is an index into the meshes
  Mat3 deformation;             // the linear part of the map to its body, in metres
  Quat rotation;                // of its pose
};

// A surface that meets another one.
struct SeamBody {
  std::uint32_t surface;
  std::vector<JoinedVertex> joined;  // that were moved, in rising order
};

struct Seams {
  std::vector<SeamBody> bodies;  // in rising order
  std::size_t vertices = 0;  // that were joined with those of others, also where none had to move
  std::size_t places = 0;    // that they have now
  // Surfaces that have an open edge near another, or are near one that has, but whose coordinates
  // are too large beside the scene to tell what meets. Nothing of theirs is joined.
  std::vector<std::uint32_t> too_far;
  // Surfaces whose vertices crowd so closely beside the scene that none can be told from another.
  // Nothing of theirs is joined.
  std::vector<std::uint32_t> crowded;
};

// Joins what meets: vertices of different surfaces that are nearer to each other than the bounds on
// the rounding of both (see the .cpp) get the position that the first of them has; of each surface
// one vertex at most, the nearest. A place counts where at least one vertex is on the boundary of
// its mesh: surfaces that are closed, or apart, are left alone.
//
// anchor_scene_m: the origin of the solver frame. size_m: of the scene. Takes next to nothing where
// no mesh has a boundary or there is one surface; else O(n log n) in the surfaces, O(1) for each
// vertex of those that an open one may touch. The ledger is asked for the memory that it takes
// meanwhile: up to 24 bytes for each boundary vertex of those, and some 200 for each vertex that
// others come near to. Deterministic.
Result<Seams> find_seams(const std::vector<WeldedSurface>& meshes,
                         std::span<const SeamSurface> surfaces, const Vec3& anchor_scene_m,
                         double size_m, MemoryLedger& ledger);

}  // namespace palpate
