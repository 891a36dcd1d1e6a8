#pragma once

// The extent of a scene, and the limits within which the computations are safe.

#include <optional>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/result.h"
#include "geometry/mesh/welded_surface.h"
#include "io/scene_description.h"

namespace palpate {

// The bounding box of each mesh, in the frame of the mesh.
std::vector<Box> bounding_boxes(const std::vector<WeldedSurface>& meshes);

// The bounding box of all nodes in the scene frame, in metres. The vertices of each node determine
// the box, with two exceptions. First, a node is skipped if its own box lies inside the bounds
// found so far; most of ten thousand instances, for example, are skipped. Second, the box of a node
// is used instead of its vertices if the vertices would raise the number of all examined vertices
// above kMostExactVertices.
Box bounds_in_scene(const std::vector<WeldedSurface>& meshes, const std::vector<Box>& boxes,
                    const std::vector<NodeDescription>& nodes);

// Returns an error if the vertices of a node are too far from the origin of their mesh. The extent
// of the scene does not show this: a node can move a distant mesh back to the other nodes by a
// large translation, but the rounding errors of the large coordinates remain.
std::optional<Error> refuse_beyond_limits(const std::vector<Box>& boxes,
                                          const std::vector<NodeDescription>& nodes);

// Returns an error if the scene is too large or too small.
std::optional<Error> refuse_extent(const Vec3& extents_m);

}  // namespace palpate
