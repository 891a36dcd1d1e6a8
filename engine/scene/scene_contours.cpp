#include "engine/scene/scene_contours.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "geometry/mesh/section.h"

namespace palpate {
namespace {

// The faces of one node that a plane cuts, with their vertices.
struct CutFaces {
  std::vector<Vec3> positions_scene_m;
  std::vector<Triangle> triangles;
};

// A mesh placed by an object: p_scene = linear * p_mesh + translation_m, with an error of at most
// roundoff_m for all points of the mesh.
struct PlacedMesh {
  const SceneObject& object;
  AffineMap deformation;
  Mat3 linear;
  Vec3 translation_m;
  double roundoff_m;

  Vec3 scene_point(const Vec3& p_mesh) const {
    return object.T_scene_body.point(deformation(p_mesh));
  }
};

// Cuts all nodes that have the same mesh.
class CutMesh {
 public:
  CutMesh(const SurfaceMesh& surface, const Vec3& centre_scene_m)
      : surface_(surface),
        positions_(surface.welded_positions()),
        centre_scene_m_(centre_scene_m),
        box_{Vec3::Constant(std::numeric_limits<double>::infinity()),
             Vec3::Constant(-std::numeric_limits<double>::infinity())} {
    for (const Vec3& p : positions_) box_ = box_.united({p, p});
  }

  // The number of faces that cut() examines for an object.
  std::size_t examined_faces(const SceneObject& object, const AffineMap& deformation) const {
    const PlacedMesh placed = place(object, deformation);
    std::size_t planes = 0;
    for (int axis = 0; axis < 3; ++axis) planes += may_cut(placed, axis) ? 1 : 0;
    return planes * surface_.face_count();
  }

  // Adds the curves of an object to `contours`.
  void cut(const SceneObject& object, const AffineMap& deformation,
           std::array<SceneContour, 3>& contours) {
    const PlacedMesh placed = place(object, deformation);
    for (int axis = 0; axis < 3; ++axis) {
      if (!may_cut(placed, axis)) continue;
      if (faces_.empty()) faces_ = surface_.faces();
      find_sides(placed, axis);
      find_cut_faces();
      if (!cut_faces_.empty()) add_curves(placed, axis, contours[axis]);
    }
  }

 private:
  PlacedMesh place(const SceneObject& object, const AffineMap& deformation) const {
    const Mat3 rotation = object.T_scene_body.rotation.toRotationMatrix();
    // Bounds the error of a dozen products and sums, each relative to the size of its operands.
    constexpr double kRoundoff = 32 * std::numeric_limits<double>::epsilon();
    const Vec3 farthest = box_.low.cwiseAbs().cwiseMax(box_.high.cwiseAbs());
    const double size_m = deformation.linear.norm() * farthest.norm() +
                          deformation.translation_m.norm() +
                          object.T_scene_body.translation_m.norm() + centre_scene_m_.norm();
    return {object, deformation, rotation * deformation.linear,
            rotation * deformation.translation_m + object.T_scene_body.translation_m,
            kRoundoff * size_m};
  }

  bool may_cut(const PlacedMesh& placed, int axis) const {
    const auto row = placed.linear.row(axis);
    const double centre = row.dot(0.5 * box_.low + 0.5 * box_.high) + placed.translation_m[axis];
    const double reach = row.cwiseAbs().dot(0.5 * box_.high - 0.5 * box_.low);
    return !(std::abs(centre - centre_scene_m_[axis]) > reach + placed.roundoff_m);
  }

  // Decides for each vertex whether it is above the plane, as plane_section() does: height 0 counts
  // as above. A cheaper formula is used where rounding cannot change the result.
  void find_sides(const PlacedMesh& placed, int axis) {
    const Vec3 row = placed.linear.row(axis);
    const double offset_m = placed.translation_m[axis] - centre_scene_m_[axis];
    is_above_.resize(positions_.size());
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      double height_m = row.dot(positions_[i]) + offset_m;
      if (!(std::abs(height_m) > placed.roundoff_m)) {
        height_m = placed.scene_point(positions_[i])[axis] - centre_scene_m_[axis];
      }
      is_above_[i] = height_m >= 0.0 ? 1 : 0;
    }
  }

  void find_cut_faces() {
    cut_faces_.clear();
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const auto [a, b, c] = faces_[f];
      const int above = is_above_[a] + is_above_[b] + is_above_[c];
      if (above == 1 || above == 2) cut_faces_.push_back(static_cast<std::uint32_t>(f));
    }
  }

  CutFaces collect(const PlacedMesh& placed) const {
    std::vector<std::uint32_t> used;
    used.reserve(3 * cut_faces_.size());
    for (const std::uint32_t f : cut_faces_) {
      used.insert(used.end(), faces_[f].begin(), faces_[f].end());
    }
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    CutFaces cut;
    cut.positions_scene_m.reserve(used.size());
    for (const std::uint32_t v : used) {
      cut.positions_scene_m.push_back(placed.scene_point(positions_[v]));
    }
    const auto new_index = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) -
                                        used.begin());
    };
    const bool is_mirrored = placed.deformation.linear.determinant() < 0.0;
    cut.triangles.reserve(cut_faces_.size());
    for (const std::uint32_t f : cut_faces_) {
      Triangle t = faces_[f];
      if (is_mirrored) std::swap(t[1], t[2]);
      cut.triangles.push_back({new_index(t[0]), new_index(t[1]), new_index(t[2])});
    }
    return cut;
  }

  void add_curves(const PlacedMesh& placed, int axis, SceneContour& contour) const {
    const CutFaces cut = collect(placed);
    const auto curves = plane_section(cut.positions_scene_m, cut.triangles, Vec3::Unit(axis),
                                      centre_scene_m_[axis]);
    contour.curves += curves.size();
    if (curves.empty()) return;
    const double longest_m = length_m(curves.front());
    if (longest_m <= contour.longest_m) return;
    contour.longest_m = longest_m;
    contour.is_closed = curves.front().closed;
  }

  const SurfaceMesh& surface_;
  std::span<const Vec3> positions_;
  Vec3 centre_scene_m_;
  Box box_;
  std::vector<Triangle> faces_;         // filled when first needed
  std::vector<std::uint8_t> is_above_;  // by vertex, 0 or 1
  std::vector<std::uint32_t> cut_faces_;
};

// All objects, grouped by mesh.
std::vector<std::size_t> objects_by_mesh(const Scene& scene) {
  std::vector<std::size_t> order(scene.objects().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scene.objects()[a].mesh < scene.objects()[b].mesh;
  });
  return order;
}

// Calls visit(mesh, index of the object) for all objects, those of one mesh after another, until it
// returns false. Returns whether it never did.
template <typename Visit>
bool visit_objects(const Scene& scene, const Vec3& centre_scene_m, Visit visit) {
  std::optional<CutMesh> mesh;
  std::optional<std::size_t> mesh_id;
  for (const std::size_t i : objects_by_mesh(scene)) {
    const std::size_t id = scene.objects()[i].mesh;
    if (mesh_id != id) mesh.emplace(scene.mesh(id), centre_scene_m);
    mesh_id = id;
    if (!visit(*mesh, i)) return false;
  }
  return true;
}

}  // namespace

std::optional<std::array<SceneContour, 3>> scene_contours(const Scene& scene,
                                                          std::size_t most_faces) {
  const Box& bounds = scene.statistics().bounds_scene;
  const Vec3 centre_scene_m = 0.5 * bounds.low + 0.5 * bounds.high;
  std::array<SceneContour, 3> contours;
  for (int axis = 0; axis < 3; ++axis) contours[axis].offset_m = centre_scene_m[axis];
  // The faces are counted first, so that what would take too long takes no time.
  std::size_t faces_left = most_faces;
  const bool is_cheap = visit_objects(scene, centre_scene_m, [&](CutMesh& mesh, std::size_t i) {
    const std::size_t faces = mesh.examined_faces(scene.objects()[i], scene.deformation(i));
    const bool is_enough = faces <= faces_left;
    faces_left -= is_enough ? faces : 0;
    return is_enough;
  });
  if (!is_cheap) return std::nullopt;
  visit_objects(scene, centre_scene_m, [&](CutMesh& mesh, std::size_t i) {
    mesh.cut(scene.objects()[i], scene.deformation(i), contours);
    return true;
  });
  return contours;
}

}  // namespace palpate
