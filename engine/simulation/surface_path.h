#pragma once

// A path over the surfaces of a scene, for a hand that senses three axes.

#include <cstdint>
#include <optional>

#include "engine/scene/scene.h"
#include "engine/simulation/hand_path.h"

namespace palpate {

struct SurfacePathSettings {
  double length_m = 1.0;  // of the whole path, which is shorter where it goes over sharp edges
  double leg_m = 0.12;    // after so much the path takes another heading
  // Above the path there is so much room, and twice as much where it begins, if there is such a
  // place.
  double room_m = 4e-3;
  std::uint64_t seed = 1;
};

struct SurfacePath {
  // Walls pressed on from their front; a point at every edge that is crossed.
  HandPath path;
  // Up to the next surface in front of where it begins; infinity if there is none.
  double free_m = 0.0;
  bool is_open = false;  // the surface has a boundary: a hand can get behind it
};

// Begins at a random place (uniform by area) with nothing in front of it, and goes straight over
// the surface: a geodesic, which each edge that it crosses unfolds. It takes a random heading every
// leg_m and where it cannot go on: at open boundaries, where three faces or more meet at an edge or
// two are oriented against each other, where a probe held a little above the surface would meet any
// surface of the scene, and where less than room_m is above it. Where no heading leads on, it goes
// back the way it came. So it may cover a place twice.
//
// Scene frame, in the rest pose of the nodes. Nothing if no place of some sixty tried leads
// anywhere. The same for the same scene and settings. O(n) in the faces of all nodes (of a part of
// them beyond kMostWeighed), and allocates nothing for each of them beyond that.
std::optional<SurfacePath> plan_surface_path(const Scene& scene,
                                             const SurfacePathSettings& settings);

}  // namespace palpate
