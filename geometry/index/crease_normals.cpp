#include "geometry/index/crease_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "geometry/exact/exact.h"
#include "geometry/exact/orientation.h"

namespace palpate {
namespace {

using HalfEdge = OpenMesh::HalfedgeHandle;

// The squared length of the difference of two unit vectors at this angle. Unlike the cosine, it
// keeps its precision at small angles.
double squared_chord(double angle_rad) {
  if (angle_rad >= std::numbers::pi) return std::numeric_limits<double>::infinity();
  const double half = std::sin(0.5 * std::max(angle_rad, 0.0));
  return 4.0 * half * half;
}

class CreaseNormals {
 public:
  CreaseNormals(const SurfaceMesh& mesh, const AffineMap& map, double crease_angle_rad)
      : mesh_(mesh),
        surface_(mesh.surface()),
        mirrored_(map.linear.determinant() < 0.0),
        crease_(squared_chord(crease_angle_rad)) {
    for (const Vec3& p : mesh.welded_positions()) positions_.push_back(map(p));
    normals_.reserve(mesh.face_count());
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      normals_.push_back(face_normal(mesh.face(f), map));
    }
  }

  std::vector<CornerNormals> at_corners() {
    std::vector<CornerNormals> corners(normals_.size());
    std::vector<bool> done(3 * normals_.size(), false);
    for (std::size_t f = 0; f < normals_.size(); ++f) {
      for (std::size_t e = 0; e < 3; ++e) {
        if (done[3 * f + e]) continue;
        find_fan({half_edge(f, e), false});
        const Vec3 sum = normal_of_fan();
        for (const Corner& corner : fan_) {
          const std::size_t face = face_of(corner.out);
          const std::size_t at = number_in_face(corner.out);
          done[3 * face + at] = true;
          const Vec3 normal = sum.isZero(0.0) ? normals_[face] : corner.turned ? Vec3(-sum) : sum;
          std::array<float, 3>& out = corners[face][mirrored_ ? (3 - at) % 3 : at];
          for (int k = 0; k < 3; ++k)
            out[static_cast<std::size_t>(k)] = static_cast<float>(normal[k]);
        }
      }
    }
    return corners;
  }

 private:
  // A face at a vertex, identified by the face's half-edge that leaves the vertex. `turned`: the
  // face has the opposite orientation to the first face of the fan.
  struct Corner {
    HalfEdge out;
    bool turned;
  };

  // The same normal as in the index.
  Vec3 face_normal(Triangle corners, const AffineMap& map) const {
    const auto of = [&](const auto& positions) {
      return accurate_unit_normal(positions[corners[0]], positions[corners[1]],
                                  positions[corners[2]]);
    };
    if (exactly_collinear(positions_[corners[0]], positions_[corners[1]], positions_[corners[2]])) {
      return (map.linear.inverse().transpose() * of(mesh_.welded_positions())).normalized();
    }
    if (mirrored_) std::swap(corners[1], corners[2]);
    return of(positions_);
  }

  // The half-edge from corner e of a face to the next corner.
  HalfEdge half_edge(std::size_t face, std::size_t e) const {
    HalfEdge h = surface_.halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(face)));
    for (std::size_t i = 0; i <= e; ++i) h = surface_.next_halfedge_handle(h);
    return h;
  }
  std::size_t face_of(HalfEdge h) const {
    return static_cast<std::size_t>(surface_.face_handle(h).idx());
  }
  std::size_t number_in_face(HalfEdge h) const {
    const std::size_t face = face_of(h);
    return h == half_edge(face, 0) ? 0 : h == half_edge(face, 1) ? 1 : 2;
  }
  std::uint32_t start(HalfEdge h) const {
    return mesh_.welded_vertex(static_cast<std::size_t>(surface_.from_vertex_handle(h).idx()));
  }
  std::uint32_t end(HalfEdge h) const {
    return mesh_.welded_vertex(static_cast<std::size_t>(surface_.to_vertex_handle(h).idx()));
  }

  // The half-edge of the neighbouring face that runs in the same direction as h, at an edge that
  // surface() cuts because of orientation; invalid if there is none.
  HalfEdge misaligned_mate(HalfEdge h) const {
    const std::uint32_t neighbour =
        mesh_.welded_neighbour(face_of(h), static_cast<int>(number_in_face(h)));
    if (neighbour == SurfaceMesh::kNone) return HalfEdge();
    for (std::size_t e = 0; e < 3; ++e) {
      const HalfEdge mate = half_edge(neighbour, e);
      if (start(mate) == start(h) && end(mate) == end(h)) return mate;
    }
    return HalfEdge();
  }

  // The next corner around the vertex, counter-clockwise or clockwise as seen from the front of the
  // fan's first face; no value beyond a crease.
  std::optional<Corner> next(const Corner& corner, bool counter_clockwise) const {
    // In counter-clockwise order, the path leaves a face across the half-edge into the vertex.
    const bool incoming = counter_clockwise != corner.turned;
    const HalfEdge h = incoming ? surface_.prev_halfedge_handle(corner.out) : corner.out;
    HalfEdge across = surface_.opposite_halfedge_handle(h);
    const bool cut = surface_.is_boundary(across);
    if (cut) across = misaligned_mate(h);
    if (!across.is_valid()) return std::nullopt;
    // An aligned neighbour's half-edge leaves the vertex where the half-edge of this face enters
    // it.
    const HalfEdge out = incoming != cut ? across : surface_.next_halfedge_handle(across);
    const Vec3& here = normals_[face_of(h)];
    const Vec3& there = normals_[face_of(out)];
    const Vec3 difference = cut ? Vec3(here + there) : Vec3(here - there);
    if (difference.squaredNorm() > crease_) return std::nullopt;
    return Corner{out, corner.turned != cut};
  }

  // Finds all corners at a vertex that are connected to one corner without a crease, in order.
  void find_fan(const Corner& corner) {
    Corner first = corner;
    for (auto before = next(first, false); before && before->out != corner.out;
         before = next(first, false)) {
      first = *before;
    }
    fan_.assign(1, first);
    for (auto after = next(first, true); after && after->out != first.out;
         after = next(*after, true)) {
      fan_.push_back(*after);
    }
  }

  double angle(HalfEdge out) const {
    const Vec3& apex = positions_[start(out)];
    const Vec3 u = (positions_[end(out)] - apex).normalized();
    const Vec3 v = (positions_[start(surface_.prev_halfedge_handle(out))] - apex).normalized();
    return std::atan2(u.cross(v).norm(), u.dot(v));
  }

  // Zero if the normals of the faces cancel.
  Vec3 normal_of_fan() const {
    Vec3 sum = Vec3::Zero();
    double weight = 0.0;
    for (const Corner& corner : fan_) {
      const double own = angle(corner.out);
      sum += (corner.turned ? -own : own) * normals_[face_of(corner.out)];
      weight += own;
    }
    // A shorter sum may be rounding alone: 4 roundings of each normal, 4 of its angle and 1 of the
    // product, doubled for second-order terms and small angles, and 1 of each addition.
    const double rounding = kUnitRoundoff * (18.0 + static_cast<double>(fan_.size())) * weight;
    const double norm = sum.norm();
    return norm > rounding ? Vec3(sum / norm) : Vec3::Zero();
  }

  const SurfaceMesh& mesh_;
  const OpenMeshSurface& surface_;
  const bool mirrored_;
  const double crease_;
  std::vector<Vec3> positions_;  // of welded vertices, frame of the index
  std::vector<Vec3> normals_;    // of faces
  std::vector<Corner> fan_;      // a member, so that a vertex does not allocate
};

}  // namespace

std::vector<CornerNormals> crease_normals(const SurfaceMesh& mesh, const AffineMap& map,
                                          double crease_angle_rad) {
  return CreaseNormals(mesh, map, crease_angle_rad).at_corners();
}

}  // namespace palpate
