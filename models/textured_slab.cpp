#include "models/textured_slab.h"

#include <cassert>
#include <cstdint>
#include <utility>

namespace palpate {

TexturedMesh textured_slab(const Vec3& size_m, double tile_m) {
  assert(size_m.minCoeff() > 0.0 && tile_m > 0.0);
  TexturedMesh slab;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      // right, up and the outward normal of the face form a right-handed frame.
      const int right = (axis + (side > 0.0 ? 1 : 2)) % 3;
      const int up = (axis + (side > 0.0 ? 2 : 1)) % 3;
      const auto first = static_cast<std::uint32_t>(slab.mesh.positions_m.size());
      for (const auto& [u, v] :
           {std::pair(0, 1), {1, 1}, {1, 0}, {0, 0}}) {  // fractions of the face
        Vec3 p;
        p[axis] = to_float(0.5 * side * size_m[axis]);
        p[right] = to_float((u - 0.5) * size_m[right]);
        p[up] = to_float((0.5 - v) * size_m[up]);
        slab.mesh.positions_m.push_back(p);
        slab.texture_coordinates.emplace_back(to_float(u * size_m[right] / tile_m),
                                              to_float(v * size_m[up] / tile_m));
      }
      slab.mesh.triangles.push_back({first, first + 1, first + 2});
      slab.mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  return slab;
}

}  // namespace palpate
