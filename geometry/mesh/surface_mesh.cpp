#include "geometry/mesh/surface_mesh.h"

#include <algorithm>
#include <utility>

#include "geometry/mesh/manifold_split.h"
#include "geometry/mesh/open_mesh_writer.h"

namespace palpate {
namespace {

std::size_t adjacency_bytes(std::size_t vertices, std::size_t edges, std::size_t faces) {
  using Items = OpenMesh::ArrayItems;
  // OpenMesh stores a property for the traits, which are empty here, with every item and half-edge.
  constexpr std::size_t kTraits = 1;
  return sizeof(SurfaceMesh) + sizeof(OpenMeshSurface) +
         vertices * (sizeof(Items::Vertex) + kTraits) +
         edges * (sizeof(Items::Edge) + 3 * kTraits) + faces * (sizeof(Items::Face) + kTraits);
}

}  // namespace

SurfaceMesh::SurfaceMesh(WeldedSurface& welded)
    : sources_(std::move(welded.sources_)), report_(welded.report_) {
  HalfEdgeMates mates = std::move(welded.mates_);
  ManifoldSplit split = split_to_manifold(welded.faces(), mates, report_.welded_vertices);
  const std::vector<Triangle> split_faces = split.split_faces(welded.faces());
  const std::span<const Triangle> faces = split_faces.empty() ? welded.faces() : split_faces;
  copied_vertices_ = std::move(split.copied_vertices);
  copied_vertices_.shrink_to_fit();
  report_.split_vertices = copied_vertices_.size();
  const auto surface = std::make_shared<OpenMeshSurface>();
  try {
    write_open_mesh(faces, std::move(mates.aligned), points(welded.positions_), *surface);
  } catch (...) {  // memory is short; others may still read the positions
    std::vector<Vec3>& taken = surface->property(surface->points_property_handle()).data_vector();
    if (copied_vertices_.empty()) welded.positions_ = std::move(taken);
    throw;
  }
  surface_ = surface;
  cut_edges_ = std::move(mates.misaligned);
  cut_edges_.shrink_to_fit();
}

// The positions of all vertices. Without copied vertices, the memory is moved.
std::vector<Vec3> SurfaceMesh::points(std::vector<Vec3>& welded) const {
  if (copied_vertices_.empty()) return std::move(welded);
  std::vector<Vec3> points;
  points.reserve(welded.size() + copied_vertices_.size());
  points.assign(welded.begin(), welded.end());
  for (const std::uint32_t original : copied_vertices_) points.push_back(welded[original]);
  return points;
}

SurfaceMesh SurfaceMesh::build(std::vector<Vec3> positions, std::vector<Triangle> triangles) {
  WeldedSurface welded(std::move(positions), std::move(triangles));
  return SurfaceMesh(welded);
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

MemoryNeed SurfaceMesh::memory_need(const WeldedSurface& welded) {
  constexpr std::uint64_t kBlocks = 1024;  // rounding of block sizes, and small blocks
  const std::span<const std::uint32_t> mates = welded.mates().aligned.span();
  const std::uint64_t faces = welded.face_count();
  std::vector<bool> is_open(welded.positions().size(), false);
  std::uint64_t open_fans = 0;  // each open fan ends at one half-edge without a mate
  std::uint64_t copies = 0;     // for vertices with several open fans
  for (std::size_t h = 0; h < mates.size(); ++h) {
    if (mates[h] != kNoHalfEdge) continue;
    const std::uint32_t vertex = welded.faces()[h / 3][h % 3];
    ++open_fans;
    copies += is_open[vertex] ? 1 : 0;
    is_open[vertex] = true;
  }
  const std::uint64_t vertices = is_open.size() + copies;
  const std::uint64_t kept = kBlocks +
                             adjacency_bytes(vertices, (3 * faces + open_fans) / 2, faces) +
                             copies * (sizeof(Vec3) + sizeof(std::uint32_t));
  // Marks of corners and vertices; with copies, also a second copy of faces and positions.
  std::uint64_t split = (3 * faces + vertices) / 8;
  if (copies > 0) split += faces * sizeof(Triangle) + welded.positions().size() * sizeof(Vec3);
  return {kept, kept + split};
}

MemoryBreakdown SurfaceMesh::memory() const {
  MemoryBreakdown memory;
  memory.adjacency =
      adjacency_bytes(surface_->n_vertices(), surface_->n_edges(), surface_->n_faces());
  memory.positions = surface_->n_vertices() * sizeof(Vec3);
  memory.maps = sources_.memory_bytes() + bytes_of(copied_vertices_) + bytes_of(cut_edges_);
  return memory;
}

}  // namespace palpate
