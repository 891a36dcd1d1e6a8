#pragma once

// A box whose faces have texture coordinates.

#include <vector>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<Point2> texture_coordinates;  // one a vertex: u to the right, v down; no unit
};

// Where box() has its corners, but each face has four vertices of its own, so that the texture runs
// straight across it, unmirrored as seen from outside: an image is tile_m wide and high on the
// surface and repeats. On the top, u runs along +x and v along -y, and the first image's upper left
// corner lies at the low x and high y. Coordinates are float values. Frame: the slab's own, its
// centre at the origin; metres. Requires every component of size_m > 0 and tile_m > 0.
// Thread-safe.
TexturedMesh textured_slab(const Vec3& size_m, double tile_m);

}  // namespace palpate
