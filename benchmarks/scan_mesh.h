#pragma once

// What a scanner makes of a body: a mesh with noise, holes and slivers.

#include <cstdint>

#include "benchmarks/scanned_body.h"
#include "models/primitives.h"

namespace palpate::bench {

// How good a scan is.
struct ScanQuality {
  double noise_cells = 0.1;     // standard deviation of a vertex, along the surface's normal
  int holes = 12;               // places that the scanner has not seen,
  double hole_radius_m = 1e-3;  // the same in each scan of the body
  std::uint64_t seed = 1;
};

// The surface of the body through the cells of a grid, by marching tetrahedra (A. Doi and A. Koide,
// "An Efficient Method of Triangulating Equi-Valued Surfaces by Using Tetrahedral Cells", 1991).
// Vertices are shared, and triangles as uneven as those of real scans; what is thinner than a cell
// is lost in part. Single precision coordinates, the body's frame, metres. The same bits each time.
// Requires cell_m > 0.
TriangleMesh scan_of(const ScannedBody& body, double cell_m, const ScanQuality& quality = {});

}  // namespace palpate::bench
