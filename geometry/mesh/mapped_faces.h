#pragma once

// The faces of a surface, with the map to the frame of an index.

#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/base/types.h"

namespace palpate {

// The map from the frame of a surface to the frame of its index: p_index = linear * p_mesh +
// translation_m.
struct AffineMap {
  Mat3 linear = Mat3::Identity();  // not singular; under a mirror, faces are reversed
  Vec3 translation_m = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return linear * p + translation_m; }
};

// Faces as welded vertex indices, and the map to the frame of an index.
struct MappedFaces {
  std::span<const Vec3> positions_mesh_m;
  std::span<const Triangle> faces;
  AffineMap map_index_mesh;

  Vec3 corner(std::uint32_t face, std::size_t i) const {
    return map_index_mesh(positions_mesh_m[faces[face][i]]);
  }
};

}  // namespace palpate
