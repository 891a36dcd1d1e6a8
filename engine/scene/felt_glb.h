#pragma once

// A compiled scene as a binary glTF asset: what can be felt, for a display.

#include <cstddef>
#include <string>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

// A scene with more triangles is simplified for the display.
inline constexpr std::size_t kMostShownTriangles = 300'000;

struct FeltGlb {
  std::string bytes;
  std::size_t triangles = 0;        // of the scene, summed over its bodies
  std::size_t shown_triangles = 0;  // in `bytes`
};

// Encodes the surfaces that can be touched, as they were compiled: after the choice of a node,
// scale, fit, cleaning and pose. Each body is one mesh with its place as the node's matrix
// (T_scene_body); the node has the body's number as extras.body and its name. Positions are floats
// in the body frame, m. No normals, textures, materials or compression.
//
// most_triangles: a scene with more is simplified (meshoptimizer), each body by the same share; 0:
// never. A body keeps at least one triangle if it has one after simplification.
//
// The same scene gives the same bytes. Returns kLimitExceeded beyond 4 GiB. Allocates; thread-safe.
Result<FeltGlb> encode_felt_scene(const Scene& scene, std::size_t most_triangles = 0);

}  // namespace palpate
