#pragma once

// Finds where surfaces of different nodes meet to within the rounding of the file's numbers.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/scene/mesh_features.h"
#include "geometry/base/box.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/mesh/welded_surface.h"
#include "io/scene_description.h"

namespace palpate {

// A vertex is reported as near another vertex or an edge, and not joined, up to this multiple of
// the distance that rounding explains.
inline constexpr double kReportedPerJoin = 64.0;

// A surface in the solver frame.
struct PlacedSurface {
  std::uint32_t number;  // of the surface
  std::uint32_t mesh;
  Mat3 linear;   // from the mesh frame to the solver frame
  Mat3 inverse;  // of `linear`
  Vec3 translation_m;
  double rounding_m;  // of vertex() and to_mesh()
  double bound_m;     // on the error of its vertices, see float_rounding_m()
  double margin_m;    // kReportedPerJoin times the bound, or close_gaps_m if that is more
  Box box_m;          // around its vertices, enlarged by margin_m

  Vec3 vertex(const Vec3& v_mesh) const;
  // The position in the mesh frame that the transform takes to p, up to rounding in double.
  Vec3 to_mesh(const Vec3& p) const;
};

// A bound on the distance between a vertex of a node and the position that its author intended, if
// the numbers in the file, and those from which they were computed, were rounded to single
// precision. reach_m: the largest |coordinate| of the mesh's vertices, by axis.
double float_rounding_m(const NodeDescription& node, const Vec3& reach_m);
// The part of that bound that belongs to the vertices themselves, mesh frame.
double float_rounding_of_vertex_m(const Vec3& reach_m);

// A vertex that lies on a vertex of another surface. Both get one position.
struct VertexOnVertex {
  std::uint32_t a, vertex_a, b, vertex_b;  // numbers of placed surfaces; a < b
};
// A vertex that lies on a sharp edge of another surface. The edge is divided there.
struct VertexOnEdge {
  std::uint32_t surface, vertex;
  std::uint32_t other, half_edge;
};
// A sharp vertex that lies on a flat part of another surface. It is moved a little beyond the face,
// away from its own surface, so that nothing passes between the two.
struct VertexOnFace {
  std::uint32_t surface, vertex;
  std::uint32_t other, face;
  int side;  // of the face, on which the vertex must lie: 1 in front, -1 behind
};
// Two edges that cross. Both are divided there. If the second edge is flat, only the first edge is
// divided, and its new vertex is moved like a VertexOnFace.
struct EdgeOnEdge {
  std::uint32_t surface, half_edge;
  std::uint32_t other, other_half_edge;
  int side;      // 0: both edges are sharp
  double along;  // place on the other edge: 0 at its start, 1 at its end
};

struct Meetings {
  std::vector<VertexOnVertex> vertices;
  std::vector<VertexOnEdge> on_edges;
  std::vector<VertexOnFace> on_faces;
  std::vector<EdgeOnEdge> crossings;
  // Vertices that are near a vertex or a sharp edge of another surface, but farther than they may
  // be joined.
  std::size_t apart = 0;
  double least_apart_m = 0.0;
  double most_apart_m = 0.0;
  bool is_complete = true;  // false: the search gave up, and nothing is listed
};

// Two surfaces meet where they are at most the sum of their bounds apart, or close_gaps_m if that
// is more. The search gives up if surfaces overlap so much that it would take longer than
// kMostWork, or if memory is short. Deterministic.
class FlushSearch {
 public:
  // meshes, boxes, moved_m and surfaces must outlive this object. boxes: of the meshes, mesh frame.
  // moved_m: see conform().
  FlushSearch(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
              std::span<const double> moved_m, std::span<const PlacedSurface> surfaces,
              double close_gaps_m, MemoryLedger& ledger);

  Result<Meetings> find();

  // The features of a surface that meets another one.
  const MeshFeatures& features(std::uint32_t s) const { return *features_[surfaces_[s].mesh]; }
  double joins_within_m(std::uint32_t s, std::uint32_t other) const;

 private:
  struct Nearest;
  struct Edge;

  void place_small_meshes();
  void search_pair(std::uint32_t a, std::uint32_t b);
  bool make_features(std::uint32_t mesh);
  std::uint64_t bytes_of_meetings() const;
  bool gives_up() const { return work_ > limit_ || is_memory_short_; }
  void search_vertices(std::uint32_t s, std::uint32_t other, const Box& box_m,
                       std::span<const std::uint32_t> faces);
  void search_edges(std::uint32_t s, std::uint32_t other, std::span<const std::uint32_t> faces);
  bool lies_along(std::uint32_t s, std::uint32_t half_edge, const Vec3& from, const Vec3& to,
                  double bound_m) const;
  void cross(const Edge& edge, std::uint32_t other, std::uint32_t other_half_edge);
  double reported_within_m(std::uint32_t s, std::uint32_t other) const;
  void find_faces(std::uint32_t s, std::uint32_t other, const Box& box_m,
                  std::vector<std::uint32_t>& faces);
  Nearest nearest(std::uint32_t other, const Vec3& p, double bound_m, double reported_m,
                  bool needs_face);
  int side_of_vertex(std::uint32_t s, std::uint32_t vertex, std::uint32_t other, std::uint32_t face,
                     double tolerance_m) const;
  int side_of_edge(std::uint32_t s, std::uint32_t half_edge, std::uint32_t other,
                   std::uint32_t face, double tolerance_m) const;
  const WeldedSurface& mesh(std::uint32_t s) const { return meshes_[surfaces_[s].mesh]; }
  Vec3 position(std::uint32_t s, std::uint32_t v) const {
    const std::size_t first = first_placed_[s];
    return first != kNotPlaced ? placed_m_[first + v] : surfaces_[s].vertex(mesh(s).positions()[v]);
  }
  Vec3 start_of(std::uint32_t s, std::uint32_t h) const {
    return position(s, mesh(s).faces()[h / 3][h % 3]);
  }
  Box box_in_mesh(std::uint32_t s, const Box& box_m) const;
  double height(std::uint32_t other, std::uint32_t face, const Vec3& p) const;

  const std::vector<WeldedSurface>& meshes_;
  std::span<const Box> boxes_;
  std::span<const double> moved_m_;
  std::span<const PlacedSurface> surfaces_;
  double close_gaps_m_;
  MemoryLedger& ledger_;
  std::vector<std::unique_ptr<MeshFeatures>> features_;  // by mesh; of meshes near others
  // The vertices of surfaces with few vertices, solver frame, and where those of a surface begin.
  static constexpr std::size_t kNotPlaced = ~std::size_t{0};
  std::vector<Vec3> placed_m_;
  std::vector<std::size_t> first_placed_;
  // Of the pair or the point that is searched; members, so that no pair allocates.
  std::vector<std::uint32_t> faces_a_, faces_b_, near_faces_, vertices_;
  std::uint64_t features_bytes_ = 0;
  std::uint64_t work_ = 0;
  std::uint64_t limit_ = 0;  // of the work
  bool is_memory_short_ = false;
  Meetings found_;
};

}  // namespace palpate
