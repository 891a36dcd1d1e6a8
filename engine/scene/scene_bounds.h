#pragma once

// How large a scene is, and whether that is within what can be computed with.

#include <optional>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/result.h"
#include "geometry/mesh/welded_surface.h"
#include "io/scene_description.h"

namespace palpate {

// Of each mesh, in its own frame.
std::vector<Box> bounding_boxes(const std::vector<WeldedSurface>& meshes);

// Around all vertices in their places. A node whose box lies inside what has been found already is
// not looked at any closer: of ten thousand instances only the outermost are. What is left when
// kMostExactVertices have been looked at counts with its boxes.
Box bounds_in_scene(const std::vector<WeldedSurface>& meshes, const std::vector<Box>& boxes,
                    const std::vector<NodeDescription>& nodes);

// A mesh can be larger than the scene: its node takes it back to the others by a translation as
// large, and leaves rounding errors of it.
std::optional<Error> refuse_beyond_limits(const std::vector<Box>& boxes,
                                          const std::vector<NodeDescription>& nodes);

// Of the scene itself: neither too large nor too small.
std::optional<Error> refuse_extent(const Vec3& extents_m);

}  // namespace palpate
