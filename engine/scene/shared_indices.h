#pragma once

// Which nodes share an index. An index takes hundreds of bytes a triangle, a node that shares one
// next to nothing.

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

// What an index is made of: a mesh in a frame of its own. That is the frame of the mesh, about its
// middle and times a power of two that makes it of size 1: so single precision has the same digits
// whatever the unit, and a vertex has the bits that it has about its middle. Where all nodes deform
// a mesh alike, but for their sizes, the index has it deformed. Bodies that are next to nothing
// beside the scene have an index with a longer unit, in which the scene is no larger than single
// precision can say.
struct IndexShape {
  std::uint32_t mesh;
  AffineMap map_index_mesh;
  double sweep_radius = 0.0;  // that the index is built for, in its unit
};

// How a node has its surface from an index: see ContactBody.
struct IndexUse {
  static constexpr std::uint32_t kNoStretch = ~std::uint32_t{0};

  std::uint32_t shape;
  std::uint32_t stretch = kNoStretch;
  double metres_per_unit = 1.0;
};

// Decides what is built before any of it is. Uniform scales and mirrors share an index, and so do
// stretches up to Stretch::kMostRatio if the proxy is a point. A sphere's radius is in the boxes of
// an index: scales within a factor of two share one that is built for the least of them, and each
// stretch has its own.
//
// Of all nodes look_at() comes first, then use().
class IndexSharing {
 public:
  // boxes: around the meshes, which outlive this. sweep_radius_m: of a sphere; 0 for a point.
  // size_m: of the scene.
  IndexSharing(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
               double sweep_radius_m, double size_m);

  void look_at(std::uint32_t mesh, const NodePlacement& placement);
  // O(log n).
  IndexUse use(std::uint32_t mesh, const NodePlacement& placement);

  std::vector<IndexShape> take_shapes() { return std::move(shapes_); }
  std::vector<Stretch> take_stretches() { return std::move(stretches_); }

 private:
  // Finds a matrix among those that were added, to within rounding.
  class MatrixFinder {
   public:
    // stored(id): the matrix that was added as that.
    template <typename Stored>
    std::optional<std::uint32_t> find(const Mat3& m, const Stored& stored) const;
    void add(const Mat3& m, std::uint32_t id);

   private:
    std::multimap<double, std::uint32_t> by_key_;
  };
  // A deformation but for its size, and what an index with it has: positive definite.
  struct Deformation {
    Mat3 unit;
    Mat3 base;
    Box box;  // around the mesh, with the base
  };
  struct OfMesh {
    std::optional<Mat3> unit;  // of the deformation of its first node
    bool is_alike = true;      // all nodes deform it like that
    MatrixFinder deformations;
  };
  // Mesh, deformation, exponent of its scale, steps that the unit is longer.
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
