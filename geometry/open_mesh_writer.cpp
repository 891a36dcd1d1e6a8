#include "geometry/open_mesh_writer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace palpate {
namespace {

OpenMesh::VertexHandle vertex_handle(std::uint32_t v) {
  return OpenMesh::VertexHandle(static_cast<int>(v));
}

class Writer {
 public:
  Writer(const std::vector<Triangle>& faces, const std::vector<std::uint32_t>& mate)
      : faces_(faces), mate_(mate), half_edges_(mate.size()) {}

  void write(const std::vector<Vec3>& positions_m,
             const std::vector<std::uint32_t>& copied_vertices, OpenMeshSurface& mesh) {
    mesh.resize(positions_m.size() + copied_vertices.size(), count_edges(), faces_.size());
    std::uint32_t next_vertex = 0;
    for (const Vec3& p : positions_m) mesh.set_point(vertex_handle(next_vertex++), p);
    for (const std::uint32_t original : copied_vertices) {
      mesh.set_point(vertex_handle(next_vertex++), positions_m[original]);
    }
    number_edges(mesh);
    link_faces(mesh);
    link_boundaries(mesh);
  }

 private:
  std::uint32_t start(std::uint32_t h) const { return faces_[h / 3][h % 3]; }

  std::size_t count_edges() const {
    const auto boundary = std::count(mate_.begin(), mate_.end(), kNoHalfEdge);
    return (mate_.size() + static_cast<std::size_t>(boundary)) / 2;
  }

  // Edges in the order in which faces come to them; the first face has the first half-edge.
  void number_edges(OpenMeshSurface& mesh) {
    int next_edge = 0;
    for (std::uint32_t h = 0; h < mate_.size(); ++h) {
      if (mate_[h] < h) {
        half_edges_[h] = mesh.opposite_halfedge_handle(half_edges_[mate_[h]]);
      } else {
        half_edges_[h] = mesh.halfedge_handle(OpenMesh::EdgeHandle(next_edge++), 0);
        mesh.set_vertex_handle(half_edges_[h], vertex_handle(start(next_half_edge(h))));
        mesh.set_vertex_handle(mesh.opposite_halfedge_handle(half_edges_[h]),
                               vertex_handle(start(h)));
      }
    }
  }

  void link_faces(OpenMeshSurface& mesh) {
    for (std::uint32_t first = 0; first < mate_.size(); first += 3) {
      const OpenMesh::FaceHandle face(static_cast<int>(first / 3));
      // OpenMesh lists a face's vertices from the one that this half-edge points to.
      mesh.set_halfedge_handle(face, half_edges_[first + 2]);
      for (std::uint32_t h = first; h < first + 3; ++h) {
        mesh.set_face_handle(half_edges_[h], face);
        mesh.set_next_halfedge_handle(half_edges_[h], half_edges_[next_half_edge(h)]);
        mesh.set_halfedge_handle(vertex_handle(start(h)), half_edges_[h]);
      }
    }
  }

  // A split vertex has one fan, so at most one boundary half-edge leaves it. OpenMesh wants that
  // one as the vertex's own.
  void link_boundaries(OpenMeshSurface& mesh) {
    for (std::uint32_t h = 0; h < mate_.size(); ++h) {
      if (mate_[h] != kNoHalfEdge) continue;
      mesh.set_halfedge_handle(vertex_handle(start(next_half_edge(h))),
                               mesh.opposite_halfedge_handle(half_edges_[h]));
    }
    for (std::uint32_t h = 0; h < mate_.size(); ++h) {
      if (mate_[h] != kNoHalfEdge) continue;
      mesh.set_next_halfedge_handle(mesh.opposite_halfedge_handle(half_edges_[h]),
                                    mesh.halfedge_handle(vertex_handle(start(h))));
    }
  }

  const std::vector<Triangle>& faces_;  // in split vertices
  const std::vector<std::uint32_t>& mate_;
  std::vector<OpenMesh::HalfedgeHandle> half_edges_;  // of OpenMesh, per half-edge
};

}  // namespace

void write_open_mesh(const std::vector<Triangle>& faces, const HalfEdgeMates& mates,
                     const std::vector<Vec3>& positions_m,
                     const std::vector<std::uint32_t>& copied_vertices, OpenMeshSurface& surface) {
  Writer(faces, mates.aligned).write(positions_m, copied_vertices, surface);
}

}  // namespace palpate
