#pragma once

// A box whose faces have texture coordinates.

#include <vector>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<Point2> texture_coordinates;  // one per vertex: u to the right, v down; no unit
};

// A box with the corners of box(), but with four separate vertices per face. The texture therefore
// runs straight across each face and, seen from outside, is not mirrored. On the surface, an image
// is tile_m wide and high, and repeats. On the top, u runs along +x and v along -y, and the upper
// left corner of the first image is at low x and high y. Coordinates are float values. Frame: the
// slab's own, with its centre at the origin; metres. Requires every component of size_m > 0 and
// tile_m > 0. Thread-safe.
TexturedMesh textured_slab(const Vec3& size_m, double tile_m);

}  // namespace palpate
