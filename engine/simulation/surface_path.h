#pragma once

// A path over the surfaces of a scene, for a hand that senses three axes.

#include <cstdint>
#include <optional>

#include "engine/scene/scene.h"
#include "engine/simulation/hand_path.h"

namespace palpate {

struct SurfacePathSettings {
  double length_m = 1.0;  // length of the whole path; each sharp edge shortens the path
  double leg_m = 0.12;    // length after which the path takes a new heading
  // The clearance required above the path. At the start of the path, twice this clearance is
  // required.
  double room_m = 4e-3;
  std::uint64_t seed = 1;
};

struct SurfacePath {
  // The walls are touched from their front; the path has a point at every edge that it crosses.
  HandPath path;
  // The distance from the start, along the normal, to the next surface; infinity if there is none.
  double free_m = 0.0;
  bool is_open = false;  // the surface has a boundary, so that the hand can move behind it
};

// Plans a path that begins at a random point (uniform by area), preferably with no surface in front
// of it. The path follows a geodesic: it is a straight line if the faces are unfolded at the edges
// that it crosses. The path takes a random heading after every leg_m and wherever it cannot
// continue:
// - at a boundary of the surface;
// - at an edge of three or more faces, or of two faces with opposite orientations;
// - where a probe slightly above the surface would hit a surface of the scene;
// - where the clearance is less than room_m.
//
// If the path cannot continue along any heading, it returns along its last leg. A path may
// therefore cover a place twice.
//
// Scene frame, in the rest pose of the nodes. At most the 8 best of 64 random points are tried as
// the start. Returns no value if no path starts at any of them. Deterministic: the same scene and
// settings give the same path. The time is O(n), where n is the number of faces of all nodes; if
// there are more than kMostWeighed, n is the number of faces in a sample of them. Faces beyond
// kMostWeighed need no additional memory.
std::optional<SurfacePath> plan_surface_path(const Scene& scene,
                                             const SurfacePathSettings& settings);

}  // namespace palpate
