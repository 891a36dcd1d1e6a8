#pragma once

// A simulated scan of a body: a mesh with noise, holes and slivers.

#include <cstdint>

#include "benchmarks/scanned_body.h"
#include "models/primitives.h"

namespace palpate::bench {

// The quality of a scan.
struct ScanQuality {
  // Standard deviation of a vertex along the surface's normal, in cells.
  double noise_cells = 0.1;
  int holes = 12;  // number of holes, at the same places in every scan of the body
  double hole_radius_m = 1e-3;
  std::uint64_t seed = 1;
};

// The surface of the body, found in the cells of a grid by marching tetrahedra (A. Doi and A.
// Koide, "An Efficient Method of Triangulating Equi-Valued Surfaces by Using Tetrahedral Cells",
// 1991). Vertices are shared; triangles are as uneven as in real scans; parts thinner than a cell
// are partly lost. Coordinates have single precision; frame of the body, metres. Deterministic to
// the bit. Requires cell_m > 0.
TriangleMesh scan_of(const ScannedBody& body, double cell_m, const ScanQuality& quality = {});

}  // namespace palpate::bench
