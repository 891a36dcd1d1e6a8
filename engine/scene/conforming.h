#pragma once

// Makes the surfaces of different nodes conform where they meet: places that the rounding of the
// file's numbers has taken apart get one position, on all surfaces.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "geometry/mesh/surface_changes.h"
#include "geometry/mesh/welded_surface.h"
#include "io/scene_description.h"

namespace palpate {

struct ConformingSettings {
  Vec3 anchor_scene_m;  // origin of the solver frame
  double size_m;        // largest extent of the scene
  // Surfaces at most this far apart conform, too, even if rounding does not explain the distance.
  double close_gaps_m = 0.0;
};

// A surface that meets another one.
struct ConformingSurface {
  std::uint32_t surface;
  SurfaceChanges changes;  // of its mesh, mesh frame; may be empty
  // The vertices that are also vertices of another surface, ascending. Numbers include the added
  // vertices, as in `changes`.
  std::vector<std::uint32_t> met;
};

struct Conforming {
  std::vector<ConformingSurface> surfaces;  // ascending
  std::size_t joined_vertices = 0;          // vertices that lie on vertices of other surfaces
  std::size_t joined_places = 0;            // distinct positions of these vertices
  std::size_t divided_edges = 0;
  // Vertices that are near a vertex or a sharp edge of another surface, and not joined.
  std::size_t apart = 0;
  double least_apart_m = 0.0;
  double most_apart_m = 0.0;
  // False: surfaces overlap too much to be searched, or memory is short. Then none is listed.
  bool is_complete = true;
};

// nodes: the nodes at rest, in ascending order of surfaces. boxes: of the meshes, mesh frame.
// moved_m: how far earlier changes have moved vertices of the meshes, mesh frame. Faces that were
// in one plane before still count as flat; else each round would divide what the last one has bent.
//
// A vertex on a vertex: both get the position of the surface with the lowest number (at each place,
// at most one vertex of a surface is joined, the nearest one). A vertex on a sharp edge (one whose
// faces are not coplanar): it is moved to the nearest point of the edge, and the edge is divided
// there. Two sharp edges that cross: both are divided. A sharp vertex or edge on a flat part of
// another surface: it is moved kOverlapPerStandOff beyond the face, away from its own surface, so
// that the two surfaces overlap instead of leaving a gap.
//
// "On" means: at most the sum of the surfaces' float_rounding_m() apart, or close_gaps_m. Surfaces
// that are farther apart do not change. Deterministic. The cost is that of the search for touching
// boxes, O(n log n), and of FlushSearch for those that touch. The error is that of the ledger.
Result<Conforming> conform(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
                           std::span<const double> moved_m,
                           std::span<const NodeDescription* const> nodes,
                           const ConformingSettings& settings, MemoryLedger& ledger);

}  // namespace palpate
