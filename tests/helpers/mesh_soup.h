#pragma once

// A mesh of the models as triangles to touch.

#include "models/primitives.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

inline Soup soup_of(const TriangleMesh& mesh) {
  return {mesh.positions_m, mesh.triangles};
}

}  // namespace palpate::test
