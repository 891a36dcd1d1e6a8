#include "geometry/index/inside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/exact/orientation.h"
#include "geometry/exact/segment_triangle.h"
#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

// The triangles that a segment crosses.
struct Crossings {
  const SurfaceIndex* index;
  Vec3 p, q, d;
  // Each slot is counted once, even if its pack is visited twice.
  std::array<std::uint32_t, kMostCrossings> slots;
  std::size_t count = 0;
  bool undecided = false;

  void consider(std::uint32_t slot) {
    SignWork signs;
    const Crossing crossing = crossing_of(index->triangle(slot), p, q, signs);
    if (crossing == Crossing::kNone) return;
    const auto end = slots.begin() + static_cast<std::ptrdiff_t>(count);
    if (std::find(slots.begin(), end, slot) != end) return;
    if (crossing == Crossing::kUndecided || count == slots.size()) {
      undecided = true;
    } else {
      slots[count++] = slot;
    }
  }

  // A PackVisitor.
  static QueryFraction visit(void* state, std::span<const std::uint32_t> packs) {
    auto& self = *static_cast<Crossings*>(state);
    std::array<PackLanes, TrianglePack::kLanes> doubtful;
    const std::size_t found =
        lanes_in_the_way(self.index->packs(), packs, self.p, self.d, 0.0, doubtful.data());
    for (std::size_t i = 0; i < found && !self.undecided; ++i) {
      for (std::uint32_t lanes = doubtful[i].lanes; lanes != 0 && !self.undecided;) {
        self.consider(SurfaceIndex::slot(doubtful[i].pack, take_lane(lanes)));
      }
    }
    return self.undecided ? QueryFraction::start() : QueryFraction::end();
  }
};

// Element `attempt` of a sequence that fills (-1/2, 1/2) evenly. Its irrational step avoids typical
// edge directions of meshes.
double slant(int attempt, double step) {
  const double x = (attempt + 1) * step;
  return x - std::floor(x) - 0.5;
}

}  // namespace

Crossing crossing_of(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                     SignWork& signs) noexcept {
  const SegmentCrossing crossing = cross_segment(t, p, q);
  signs = crossing.signs;
  if (crossing.kind == SegmentCrossing::Kind::kMiss) return Crossing::kNone;
  if (crossing.kind != SegmentCrossing::Kind::kThrough) return Crossing::kUndecided;
  const auto is_beside = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return orientation(a, b, c, d, signs) != 0;
  };
  const bool is_proper = is_beside(t.a, t.b, t.c, q) && is_beside(p, q, t.a, t.b) &&
                         is_beside(p, q, t.b, t.c) && is_beside(p, q, t.c, t.a);
  return is_proper ? Crossing::kProper : Crossing::kUndecided;
}

bool is_closed(const SurfaceMesh& mesh) {
  if (mesh.report().boundary_edges > 0) return false;
  if (mesh.report().non_manifold_edges == 0) return true;
  // surface() is cut along every face of an edge that does not have exactly two aligned faces.
  std::vector<std::uint64_t> cuts;
  const OpenMeshSurface& surface = mesh.surface();
  for (const auto h : surface.halfedges()) {
    if (!surface.is_boundary(h)) continue;
    const auto end = [&](OpenMesh::VertexHandle v) {
      return std::uint64_t{mesh.welded_vertex(static_cast<std::size_t>(v.idx()))};
    };
    const std::uint64_t u = end(surface.from_vertex_handle(h));
    const std::uint64_t v = end(surface.to_vertex_handle(h));
    cuts.push_back(std::max(u, v) << 32 | std::min(u, v));
  }
  std::sort(cuts.begin(), cuts.end());
  for (auto edge = cuts.begin(); edge != cuts.end();) {
    const auto next = std::upper_bound(edge, cuts.end(), *edge);
    if ((next - edge) % 2 != 0) return false;
    edge = next;
  }
  return true;
}

std::optional<bool> crosses_odd(const SurfaceIndex& index, const Vec3& p, const Vec3& q) noexcept {
  Crossings crossings;
  crossings.index = &index;
  crossings.p = p;
  crossings.q = q;
  crossings.d = q - p;
  index.visit_segment(p, crossings.d, 0.0, Crossings::visit, &crossings);
  if (crossings.undecided) return std::nullopt;
  return crossings.count % 2 != 0;
}

std::optional<bool> is_inside(const SurfaceIndex& index, const Vec3& p) noexcept {
  if (index.pack_count() == 0 || !index.box().contains(p)) return false;
  for (int attempt = 0; attempt < kMostTries; ++attempt) {
    const auto odd = crosses_odd(index, p, probe_end(index.box(), p, attempt));
    if (odd) return odd;
  }
  return std::nullopt;
}

Vec3 probe_end(const Box& box, const Vec3& p, int attempt) noexcept {
  // Faces 0 to 2 are the low faces of the axes, 3 to 5 the high faces.
  std::array<double, 6> distances;
  std::array<std::size_t, 6> faces;
  for (std::size_t face = 0; face < 6; ++face) {
    const auto axis = static_cast<Eigen::Index>(face % 3);
    distances[face] = face < 3 ? p[axis] - box.low[axis] : box.high[axis] - p[axis];
    faces[face] = face;
  }
  std::sort(faces.begin(), faces.end(), [&](std::size_t x, std::size_t y) {
    return distances[x] != distances[y] ? distances[x] < distances[y] : x < y;
  });
  const std::size_t face = faces[static_cast<std::size_t>(attempt % 6)];
  const auto axis = static_cast<Eigen::Index>(face % 3);
  // The size of the box certainly exceeds the rounding of its coordinates.
  const double beyond = (box.high - box.low).maxCoeff();
  const double reach = distances[face] + beyond;
  // Steps of a low-discrepancy sequence in the plane: powers of 1 / 1.3247, where 1.3247 is the
  // root of x^3 = x + 1.
  constexpr double kStep = 0.7548776662466927;
  Vec3 end = p;
  end[axis] = face < 3 ? box.low[axis] - beyond : box.high[axis] + beyond;
  end[(axis + 1) % 3] += reach * slant(attempt, kStep);
  end[(axis + 2) % 3] += reach * slant(attempt, kStep * kStep);
  return end;
}

}  // namespace palpate
