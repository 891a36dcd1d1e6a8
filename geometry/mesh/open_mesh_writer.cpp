#include "geometry/mesh/open_mesh_writer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "geometry/base/fixed_array.h"

namespace palpate {
namespace {

OpenMesh::VertexHandle vertex_handle(std::uint32_t v) {
  return OpenMesh::VertexHandle(static_cast<int>(v));
}

class Writer {
 public:
  Writer(std::span<const Triangle> faces, FixedArray<std::uint32_t> mates, OpenMeshSurface& mesh)
      : faces_(faces), half_edges_(std::move(mates)), mesh_(mesh) {}

  void write(std::vector<Vec3> points) {
    const std::size_t vertex_count = points.size();
    mesh_.property(mesh_.points_property_handle()).data_vector() = std::move(points);
    mesh_.resize(vertex_count, count_edges(), faces_.size());
    number_edges();
    link_faces();
    link_boundaries();
  }

 private:
  std::uint32_t start(std::uint32_t h) const { return faces_[h / 3][h % 3]; }

  std::size_t count_edges() const {
    const auto boundary = std::count(half_edges_.begin(), half_edges_.end(), kNoHalfEdge);
    return (half_edges_.size() + static_cast<std::size_t>(boundary)) / 2;
  }

  OpenMesh::HalfedgeHandle handle(std::uint32_t h) const {
    return OpenMesh::HalfedgeHandle(static_cast<int>(half_edges_[h]));
  }

  // Numbers the edges in the order in which the faces reach them; the first face has the edge's
  // first half-edge. Replaces each entry of half_edges_, the mate, by the half-edge's number in
  // OpenMesh.
  void number_edges() {
    int next_edge = 0;
    for (std::uint32_t h = 0; h < half_edges_.size(); ++h) {
      const std::uint32_t mate = half_edges_[h];
      const bool is_second = mate < h;  // false for kNoHalfEdge
      const OpenMesh::HalfedgeHandle own =
          is_second ? mesh_.opposite_halfedge_handle(handle(mate))
                    : mesh_.halfedge_handle(OpenMesh::EdgeHandle(next_edge++), 0);
      half_edges_[h] = static_cast<std::uint32_t>(own.idx());
      if (is_second) continue;
      mesh_.set_vertex_handle(own, vertex_handle(start(next_half_edge(h))));
      mesh_.set_vertex_handle(mesh_.opposite_halfedge_handle(own), vertex_handle(start(h)));
    }
  }

  void link_faces() {
    for (std::uint32_t first = 0; first < half_edges_.size(); first += 3) {
      const OpenMesh::FaceHandle face(static_cast<int>(first / 3));
      // OpenMesh lists a face's vertices starting where this half-edge ends.
      mesh_.set_halfedge_handle(face, handle(first + 2));
      for (std::uint32_t h = first; h < first + 3; ++h) {
        mesh_.set_face_handle(handle(h), face);
        mesh_.set_next_halfedge_handle(handle(h), handle(next_half_edge(h)));
        mesh_.set_halfedge_handle(vertex_handle(start(h)), handle(h));
      }
    }
  }

  // A split vertex has one fan, so at most one boundary half-edge leaves it. OpenMesh requires this
  // half-edge as the half-edge of the vertex.
  void link_boundaries() {
    const auto for_each_boundary = [this](const auto& visit) {
      for (std::uint32_t h = 0; h < half_edges_.size(); ++h) {
        const OpenMesh::HalfedgeHandle boundary = mesh_.opposite_halfedge_handle(handle(h));
        if (!mesh_.face_handle(boundary).is_valid()) visit(h, boundary);
      }
    };
    for_each_boundary([this](std::uint32_t h, OpenMesh::HalfedgeHandle boundary) {
      mesh_.set_halfedge_handle(vertex_handle(start(next_half_edge(h))), boundary);
    });
    for_each_boundary([this](std::uint32_t h, OpenMesh::HalfedgeHandle boundary) {
      mesh_.set_next_halfedge_handle(boundary, mesh_.halfedge_handle(vertex_handle(start(h))));
    });
  }

  std::span<const Triangle> faces_;
  FixedArray<std::uint32_t> half_edges_;  // number in OpenMesh, per half-edge; initially the mate
  OpenMeshSurface& mesh_;
};

}  // namespace

void write_open_mesh(std::span<const Triangle> faces, FixedArray<std::uint32_t> mates,
                     std::vector<Vec3> points, OpenMeshSurface& surface) {
  Writer(faces, std::move(mates), surface).write(std::move(points));
}

}  // namespace palpate
