#include "geometry/surface_mesh.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "geometry/buckets.h"
#include "geometry/exact.h"
#include "geometry/half_edges.h"
#include "geometry/manifold_split.h"
#include "geometry/open_mesh_writer.h"
#include "geometry/weld.h"

namespace palpate {
namespace {

constexpr std::uint32_t kUnused = SurfaceMesh::kNone;

// Triangles in welded vertices, with the index each had in the input.
struct FaceList {
  std::vector<Triangle> faces;
  std::vector<std::uint32_t> source;
};

FaceList faces_with_area(const Weld& weld, const std::vector<Triangle>& triangles) {
  FaceList list;
  list.faces.reserve(triangles.size());
  list.source.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Triangle face;
    for (std::size_t i = 0; i < 3; ++i) {
      assert(triangles[t][i] < weld.vertex_of.size());
      face[i] = weld.vertex_of[triangles[t][i]];
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    const std::vector<Vec3>& p = weld.positions_m;
    if (exactly_collinear(p[face[0]], p[face[1]], p[face[2]])) continue;
    list.faces.push_back(face);
    list.source.push_back(static_cast<std::uint32_t>(t));
  }
  return list;
}

// Per face: has an earlier one the same three vertices?
std::vector<bool> find_duplicates(const std::vector<Triangle>& faces, std::size_t vertex_count) {
  std::vector<Triangle> keys = faces;
  for (Triangle& key : keys) std::sort(key.begin(), key.end());
  Buckets by_lowest =
      group_by_key(keys.size(), vertex_count, [&](std::size_t f) { return keys[f][0]; });
  std::vector<bool> is_duplicate(faces.size(), false);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = by_lowest.items.begin() + by_lowest.first[v];
    const auto end = by_lowest.items.begin() + by_lowest.first[v + 1];
    std::sort(begin, end, [&](std::uint32_t f, std::uint32_t g) {
      return keys[f] != keys[g] ? keys[f] < keys[g] : f < g;
    });
    for (auto f = begin; f != end; ++f) {
      if (f != begin && keys[*f] == keys[*(f - 1)]) is_duplicate[*f] = true;
    }
  }
  return is_duplicate;
}

void drop_duplicates(FaceList& list, std::size_t vertex_count) {
  const std::vector<bool> is_duplicate = find_duplicates(list.faces, vertex_count);
  std::size_t kept = 0;
  for (std::size_t f = 0; f < list.faces.size(); ++f) {
    if (is_duplicate[f]) continue;
    list.faces[kept] = list.faces[f];
    list.source[kept++] = list.source[f];
  }
  list.faces.resize(kept);
  list.source.resize(kept);
}

// The positions that faces use, in their order; faces are renumbered.
std::vector<Vec3> used_positions(const std::vector<Vec3>& positions_m,
                                 std::vector<Triangle>& faces) {
  std::vector<std::uint32_t> new_index(positions_m.size(), kUnused);
  for (const Triangle& face : faces) {
    for (const std::uint32_t v : face) new_index[v] = 0;
  }
  std::vector<Vec3> used;
  for (std::size_t v = 0; v < positions_m.size(); ++v) {
    if (new_index[v] == kUnused) continue;
    new_index[v] = static_cast<std::uint32_t>(used.size());
    used.push_back(positions_m[v]);
  }
  for (Triangle& face : faces) {
    for (std::uint32_t& v : face) v = new_index[v];
  }
  return used;
}

void set_normals(const std::vector<Vec3>& positions_m, const std::vector<Triangle>& faces,
                 OpenMeshSurface& mesh) {
  mesh.request_face_normals();
  mesh.request_vertex_normals();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Triangle& face = faces[f];
    const Vec3 n =
        accurate_unit_normal(positions_m[face[0]], positions_m[face[1]], positions_m[face[2]]);
    mesh.set_normal(OpenMesh::FaceHandle(static_cast<int>(f)),
                    OpenMesh::Vec3d(n.x(), n.y(), n.z()));
  }
  mesh.update_vertex_normals();
}

std::vector<Triangle> neighbouring_faces(const std::vector<std::uint32_t>& mates) {
  std::vector<Triangle> neighbours(mates.size() / 3);
  for (std::size_t h = 0; h < mates.size(); ++h) {
    neighbours[h / 3][h % 3] = mates[h] == kNoHalfEdge ? SurfaceMesh::kNone : mates[h] / 3;
  }
  return neighbours;
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& vector) {
  return vector.capacity() * sizeof(T);
}

}  // namespace

SurfaceMesh SurfaceMesh::build(const std::vector<Vec3>& positions,
                               const std::vector<Triangle>& triangles) {
  assert(triangles.size() < 300'000'000);  // six half-edges each, within OpenMesh's int
  SurfaceMesh mesh;
  CleaningReport& report = mesh.report_;
  report.triangles_in = triangles.size();

  const Weld weld = weld_equal_positions(positions);
  FaceList list = faces_with_area(weld, triangles);
  report.dropped_degenerate = triangles.size() - list.faces.size();
  drop_duplicates(list, weld.positions_m.size());
  report.dropped_duplicate = triangles.size() - report.dropped_degenerate - list.faces.size();
  report.triangles = list.faces.size();
  mesh.faces_ = std::move(list.faces);
  mesh.source_triangle_ = std::move(list.source);
  mesh.welded_positions_ = used_positions(weld.positions_m, mesh.faces_);
  report.welded_vertices = mesh.welded_positions_.size();

  const HalfEdgeMates mates = match_half_edges(mesh.faces_, report.welded_vertices);
  report.boundary_edges = mates.boundary_edges;
  report.non_manifold_edges = mates.non_manifold_edges;
  mesh.welded_neighbours_ = neighbouring_faces(mates.any);

  ManifoldSplit split = split_to_manifold(mesh.faces_, mates, report.welded_vertices);
  report.split_vertices = split.original_vertex.size() - report.welded_vertices;
  const auto surface = std::make_shared<OpenMeshSurface>();
  write_open_mesh(split, mates, mesh.welded_positions_, *surface);
  set_normals(mesh.welded_positions_, mesh.faces_, *surface);
  mesh.surface_ = surface;
  mesh.welded_vertex_ = std::move(split.original_vertex);
  return mesh;
}

std::size_t SurfaceMesh::memory_bytes() const {
  using Items = OpenMesh::ArrayItems;
  const std::size_t open_mesh =
      surface_->n_vertices() * (sizeof(Items::Vertex) + 2 * sizeof(OpenMesh::Vec3d)) +
      surface_->n_edges() * sizeof(Items::Edge) +
      surface_->n_faces() * (sizeof(Items::Face) + sizeof(OpenMesh::Vec3d));
  return sizeof(*this) + open_mesh + bytes_of(welded_positions_) + bytes_of(faces_) +
         bytes_of(source_triangle_) + bytes_of(welded_vertex_) + bytes_of(welded_neighbours_);
}

}  // namespace palpate
