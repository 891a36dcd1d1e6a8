#pragma once

// The curves in which a plane cuts the surfaces of a scene.

#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/mesh/section.h"

namespace palpate {

// The curves of plane_section() of all objects, in the scene frame, sorted: longest first, ties in
// the order of the objects. A curve never continues from one object into another. Needs memory for
// one object at a time and for the curves. Thread-safe.
std::vector<Polyline> cut_scene(const Scene& scene, const Vec3& plane_normal,
                                double plane_offset_m);

// An upper bound on the memory for one object in cut_scene(), in bytes.
std::uint64_t scene_cut_bytes(const Scene& scene);

}  // namespace palpate
