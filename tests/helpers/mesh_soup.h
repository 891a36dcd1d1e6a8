#pragma once

// Converts a mesh of the models to a triangle soup.

#include "models/primitives.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

inline Soup soup_of(const TriangleMesh& mesh) {
  return {mesh.positions_m, mesh.triangles};
}

}  // namespace palpate::test
