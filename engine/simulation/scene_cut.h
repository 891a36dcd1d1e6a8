#pragma once

// The curves in which a plane cuts the surfaces of a scene.

#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/mesh/section.h"

namespace palpate {

// Scene frame, as of plane_section() for each object; longest first, ties in the order of objects.
// Curves end where an object ends. Takes memory for one object at a time, and for what is cut.
// Thread-safe.
std::vector<Polyline> cut_scene(const Scene& scene, const Vec3& plane_normal,
                                double plane_offset_m);

// What that takes at most for the surfaces, without the curves.
std::uint64_t scene_cut_bytes(const Scene& scene);

}  // namespace palpate
