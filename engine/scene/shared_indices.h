#pragma once

// Decides which nodes share an index. An index needs hundreds of bytes per triangle; a node that
// shares an existing index needs almost no memory.

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "engine/scene/node_placement.h"
#include "geometry/base/box.h"
#include "geometry/index/stretch.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {

// The input of an index: a mesh and the map to the index frame.
//
// The index frame is the mesh frame, moved to the middle of the mesh and scaled by a power of two
// so that the largest extent of the mesh is between 1/2 and 1. Therefore the rounding to single
// precision does not depend on the unit of length of the mesh, and the scaling itself rounds no
// coordinate. If all nodes deform a mesh in the same way, apart from the size, the index contains
// the deformed mesh. If a body is tiny relative to the scene, its index has a longer unit, because
// the scene, measured in the usual unit, would exceed the range of single precision.
struct IndexShape {
  std::uint32_t mesh;
  AffineMap map_index_mesh;
  double sweep_radius = 0.0;  // largest sweep radius of a query, in units of the index
};

// The index that a node uses, and the transform from index frame to body frame (see ContactBody).
struct IndexUse {
  static constexpr std::uint32_t kNoStretch = ~std::uint32_t{0};

  std::uint32_t shape;
  std::uint32_t stretch = kNoStretch;
  double metres_per_unit = 1.0;
};

// Plans all indices before any of them is built.
//
// If the proxy is a point, the following nodes of a mesh share one index: nodes that are uniformly
// scaled or mirrored, and nodes that are stretched by at most Stretch::kMostRatio. If the proxy is
// a sphere, its radius is part of the boxes in an index. Nodes then share an index if their scales
// lie between the same two powers of two; the index is built for the smallest of these scales. Each
// different stretch then has its own index.
//
// Call examine() for all nodes first, then use() for all nodes.
class IndexSharing {
 public:
  // boxes: the bounding boxes of the meshes. meshes and boxes must outlive this object.
  // sweep_radius_m: the sweep radius for a sphere proxy; 0 for a point proxy. size_m: the largest
  // extent of the scene.
  IndexSharing(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
               double sweep_radius_m, double size_m);

  void examine(std::uint32_t mesh, const NodePlacement& placement);
  // Takes O(log n) time.
  IndexUse use(std::uint32_t mesh, const NodePlacement& placement);

  std::vector<IndexShape> take_shapes() { return std::move(shapes_); }
  std::vector<Stretch> take_stretches() { return std::move(stretches_); }

 private:
  // Finds, among the matrices added, one that equals `m` to within rounding.
  class MatrixFinder {
   public:
    // stored(id): the matrix that was added with this id.
    template <typename Stored>
    std::optional<std::uint32_t> find(const Mat3& m, const Stored& stored) const;
    void add(const Mat3& m, std::uint32_t id);

   private:
    std::multimap<double, std::uint32_t> by_key_;
  };
  // A deformation that is applied to the mesh in an index. Both matrices are positive definite.
  struct Deformation {
    Mat3 unit;  // normalised: independent of the size
    Mat3 base;  // applied in the index
    Box box;    // bounding box of the mesh after `base`
  };
  struct OfMesh {
    std::optional<Mat3> unit;  // normalised deformation of its first node
    bool is_alike = true;      // all nodes have this normalised deformation
    MatrixFinder deformations;
  };
  // Mesh, deformation, exponent of the scale, number of steps by which the unit of length is
  // lengthened.
  using ShapeKey = std::tuple<std::uint32_t, std::uint32_t, int, int>;

  IndexUse similar(std::uint32_t mesh, std::uint32_t deformation, const Mat3& base, double scale,
                   double least_scale);
  int unit_exponent(const Box& box, int exponent) const;
  int steps_longer(int exponent_m) const;
  IndexUse stretched(std::uint32_t mesh, const Mat3& deformation);
  std::uint32_t deformation_of(std::uint32_t mesh, const Mat3& unit, const Mat3& base);
  Box box_of(std::uint32_t mesh, const Mat3& base) const;

  const std::vector<WeldedSurface>& meshes_;
  std::span<const Box> boxes_;
  double sweep_radius_m_;
  double size_m_;
  std::vector<OfMesh> of_mesh_;
  std::vector<Deformation> deformations_;
  std::map<ShapeKey, std::uint32_t> shape_of_;
  std::vector<IndexShape> shapes_;
  std::vector<Stretch> stretches_;
  std::map<std::uint32_t, MatrixFinder> stretches_of_shape_;
};

}  // namespace palpate
