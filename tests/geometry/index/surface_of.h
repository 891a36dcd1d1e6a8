#pragma once

// The welded surface of a mesh of the models.

#include "geometry/mesh/surface_mesh.h"
#include "models/primitives.h"

namespace palpate::test {

inline SurfaceMesh surface_of(const TriangleMesh& mesh) {
  return SurfaceMesh::build(mesh.positions_m, mesh.triangles);
}

}  // namespace palpate::test
