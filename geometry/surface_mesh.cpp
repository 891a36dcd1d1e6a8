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

// Triangles in welded vertices, and what was left out to get them.
struct FaceList {
  std::vector<Triangle> faces;
  std::vector<std::uint32_t> dropped;  // in the input, rising
};

FaceList faces_with_area(const Weld& weld, const std::vector<Triangle>& triangles) {
  FaceList list;
  list.faces.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Triangle face;
    for (std::size_t i = 0; i < 3; ++i) {
      assert(triangles[t][i] < weld.vertex_of.size());
      face[i] = weld.vertex_of[triangles[t][i]];
    }
    const std::vector<Vec3>& p = weld.positions_m;
    const bool has_area = face[0] != face[1] && face[1] != face[2] && face[2] != face[0] &&
                          !exactly_collinear(p[face[0]], p[face[1]], p[face[2]]);
    if (has_area) {
      list.faces.push_back(face);
    } else {
      list.dropped.push_back(static_cast<std::uint32_t>(t));
    }
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
  std::vector<std::uint32_t> dropped;
  std::size_t kept = 0;
  std::size_t next_dropped = 0;
  std::uint32_t source = 0;
  for (std::size_t f = 0; f < list.faces.size(); ++f, ++source) {
    for (; next_dropped < list.dropped.size() && list.dropped[next_dropped] == source; ++source) {
      dropped.push_back(list.dropped[next_dropped++]);
    }
    if (is_duplicate[f]) {
      dropped.push_back(source);
    } else {
      list.faces[kept++] = list.faces[f];
    }
  }
  dropped.insert(dropped.end(), list.dropped.begin() + static_cast<std::ptrdiff_t>(next_dropped),
                 list.dropped.end());
  list.faces.resize(kept);
  list.dropped = std::move(dropped);
}

// Leaves only the positions that faces use, in their order; faces are renumbered.
void drop_unused_positions(std::vector<Vec3>& positions_m, std::vector<Triangle>& faces) {
  std::vector<std::uint32_t> new_index(positions_m.size(), kUnused);
  for (const Triangle& face : faces) {
    for (const std::uint32_t v : face) new_index[v] = 0;
  }
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < positions_m.size(); ++v) {
    if (new_index[v] == kUnused) continue;
    new_index[v] = used;
    positions_m[used++] = positions_m[v];
  }
  if (used == positions_m.size()) return;
  positions_m.resize(used);
  for (Triangle& face : faces) {
    for (std::uint32_t& v : face) v = new_index[v];
  }
}

// Dropped triangle i has so many kept ones before it. Rising, too.
std::vector<std::uint32_t> kept_before(const std::vector<std::uint32_t>& dropped) {
  std::vector<std::uint32_t> kept(dropped.size());
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    kept[i] = dropped[i] - static_cast<std::uint32_t>(i);
  }
  return kept;
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

  Weld weld = weld_equal_positions(positions);
  FaceList list = faces_with_area(weld, triangles);
  weld.vertex_of = {};
  report.dropped_degenerate = list.dropped.size();
  HalfEdgeMates mates = match_half_edges(list.faces, weld.positions_m.size());
  if (mates.has_duplicates) {
    mates = {};  // first, so that two of them never share the memory
    drop_duplicates(list, weld.positions_m.size());
    mates = match_half_edges(list.faces, weld.positions_m.size());
  }
  report.dropped_duplicate = list.dropped.size() - report.dropped_degenerate;
  report.triangles = list.faces.size();
  report.boundary_edges = mates.boundary_edges;
  report.non_manifold_edges = mates.non_manifold_edges;
  drop_unused_positions(weld.positions_m, list.faces);
  report.welded_vertices = weld.positions_m.size();
  mesh.kept_before_dropped_ = kept_before(list.dropped);

  mesh.copied_vertices_ = split_to_manifold(list.faces, mates, report.welded_vertices);
  mesh.copied_vertices_.shrink_to_fit();
  report.split_vertices = mesh.copied_vertices_.size();
  mesh.cut_edges_ = std::move(mates.misaligned);
  mesh.cut_edges_.shrink_to_fit();
  const auto surface = std::make_shared<OpenMeshSurface>();
  write_open_mesh(list.faces, mates, weld.positions_m, mesh.copied_vertices_, *surface);
  mesh.surface_ = surface;
  return mesh;
}

Triangle SurfaceMesh::face(std::size_t f) const {
  // The half-edge of a face points to its first corner.
  OpenMesh::HalfedgeHandle h = surface_->halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(f)));
  Triangle corners;
  for (std::uint32_t& corner : corners) {
    corner = welded_vertex(static_cast<std::size_t>(surface_->to_vertex_handle(h).idx()));
    h = surface_->next_halfedge_handle(h);
  }
  return corners;
}

std::vector<Triangle> SurfaceMesh::faces() const {
  std::vector<Triangle> faces;
  faces.reserve(face_count());
  for (std::size_t f = 0; f < face_count(); ++f) faces.push_back(face(f));
  return faces;
}

std::uint32_t SurfaceMesh::source_triangle(std::size_t face) const {
  const auto& kept = kept_before_dropped_;
  const auto later = std::upper_bound(kept.begin(), kept.end(), face);
  return static_cast<std::uint32_t>(face + static_cast<std::size_t>(later - kept.begin()));
}

std::uint32_t SurfaceMesh::welded_neighbour(std::size_t face, int e) const {
  OpenMesh::HalfedgeHandle h =
      surface_->halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(face)));
  for (int i = 0; i <= e; ++i) h = surface_->next_halfedge_handle(h);
  const OpenMesh::FaceHandle neighbour = surface_->opposite_face_handle(h);
  if (neighbour.is_valid()) return static_cast<std::uint32_t>(neighbour.idx());
  const auto half_edge = static_cast<std::uint32_t>(3 * face + static_cast<std::size_t>(e));
  const auto cut = std::lower_bound(
      cut_edges_.begin(), cut_edges_.end(), half_edge,
      [](const MisalignedMate& edge, std::uint32_t h_sought) { return edge.half_edge < h_sought; });
  return cut != cut_edges_.end() && cut->half_edge == half_edge ? cut->mate / 3 : kNone;
}

MemoryBreakdown SurfaceMesh::memory() const {
  using Items = OpenMesh::ArrayItems;
  MemoryBreakdown memory;
  // With every item and half-edge OpenMesh keeps a property for the traits, which are empty here.
  constexpr std::size_t kTraits = 1;
  memory.adjacency = sizeof(*this) + sizeof(OpenMeshSurface) +
                     surface_->n_vertices() * (sizeof(Items::Vertex) + kTraits) +
                     surface_->n_edges() * (sizeof(Items::Edge) + 3 * kTraits) +
                     surface_->n_faces() * (sizeof(Items::Face) + kTraits);
  memory.positions = surface_->n_vertices() * sizeof(Vec3);
  memory.maps = bytes_of(kept_before_dropped_) + bytes_of(copied_vertices_) + bytes_of(cut_edges_);
  return memory;
}

}  // namespace palpate
