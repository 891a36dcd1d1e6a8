#include "engine/scene_contours.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "geometry/section.h"

namespace palpate {
namespace {

// A bit for each axis.
using Axes = std::uint8_t;
constexpr Axes bit(int axis) {
  return static_cast<Axes>(1u << axis);
}

// The faces of one node that a plane cuts, with the vertices that they have.
struct CutFaces {
  std::vector<Vec3> positions_scene_m;
  std::vector<Triangle> triangles;
};

// How a node shows a mesh: p_scene = linear * p_mesh + a translation, within roundoff_m for all
// points of the mesh.
struct PlacedMesh {
  const SceneObject& object;
  AffineMap deformation;
  Mat3 linear;
  double roundoff_m;

  Vec3 scene_point(const Vec3& p_mesh) const {
    return object.T_scene_body.point(deformation(p_mesh));
  }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Box kEmptyBox = {Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)};

// A mesh while the nodes that show it are cut.
class CutMesh {
 public:
  CutMesh(const SurfaceMesh& surface, const Vec3& centre_scene_m)
      : surface_(surface),
        positions_(surface.welded_positions()),
        centre_scene_m_(centre_scene_m),
        box_(kEmptyBox) {
    for (const Vec3& p : positions_) box_ = box_.united({p, p});
  }

  // Adds the curves of an object to those there are. Takes from faces_left; false if it has too
  // few.
  bool cut(const SceneObject& object, const AffineMap& deformation, std::size_t& faces_left,
           std::array<SceneContour, 3>& contours) {
    const PlacedMesh placed = place(object, deformation);
    if (planes_near(placed, box_) == 0) return true;
    if (faces_.empty()) divide();
    std::array<std::vector<std::uint32_t>, 3> cut_faces;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const Axes near = planes_near(placed, blocks_[b]);
      if (near == 0) continue;
      const std::size_t end = std::min((b + 1) * kBlock, faces_.size());
      if (end - b * kBlock > faces_left) return false;
      faces_left -= end - b * kBlock;
      for (std::size_t f = b * kBlock; f < end; ++f) {
        const Axes cut = planes_through(placed, faces_[f]) & near;
        for (int axis = 0; cut != 0 && axis < 3; ++axis) {
          if (cut & bit(axis)) cut_faces[axis].push_back(static_cast<std::uint32_t>(f));
        }
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (!cut_faces[axis].empty()) add_curves(placed, axis, cut_faces[axis], contours[axis]);
    }
    return true;
  }

 private:
  // Faces that follow one another in a file are near each other as a rule.
  static constexpr std::size_t kBlock = 64;

  void divide() {
    faces_ = surface_.faces();
    blocks_.assign((faces_.size() + kBlock - 1) / kBlock, kEmptyBox);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      Box& block = blocks_[f / kBlock];
      for (const std::uint32_t v : faces_[f]) block = block.united({positions_[v], positions_[v]});
    }
  }

  PlacedMesh place(const SceneObject& object, const AffineMap& deformation) const {
    const Mat3 linear = object.T_scene_body.rotation.toRotationMatrix() * deformation.linear;
    // Of a dozen products and sums, each rounded to the size of what goes into them.
    constexpr double kRoundoff = 32 * std::numeric_limits<double>::epsilon();
    const Vec3 farthest = box_.low.cwiseAbs().cwiseMax(box_.high.cwiseAbs());
    const double size_m = deformation.linear.norm() * farthest.norm() +
                          deformation.translation_m.norm() +
                          object.T_scene_body.translation_m.norm();
    return {object, deformation, linear, kRoundoff * size_m};
  }

  // The planes that may cut what is in a box of the mesh. Rounding may make them too many.
  Axes planes_near(const PlacedMesh& placed, const Box& box) const {
    const Vec3 centre = placed.scene_point(0.5 * box.low + 0.5 * box.high);
    const Vec3 reach = placed.linear.cwiseAbs() * (0.5 * box.high - 0.5 * box.low);
    Axes axes = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double distance_m = std::abs(centre[axis] - centre_scene_m_[axis]);
      if (!(distance_m > reach[axis] + placed.roundoff_m)) axes |= bit(axis);
    }
    return axes;
  }

  // Those that have vertices of a face on both sides: as plane_section() has it, zero is above.
  Axes planes_through(const PlacedMesh& placed, const Triangle& face) const {
    Axes some = 0;
    Axes all = 0xff;
    for (const std::uint32_t v : face) {
      const Vec3 height_m = placed.scene_point(positions_[v]) - centre_scene_m_;
      Axes above = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (height_m[axis] >= 0.0) above |= bit(axis);
      }
      some |= above;
      all &= above;
    }
    return static_cast<Axes>(some & ~all);
  }

  CutFaces collect(const PlacedMesh& placed, const std::vector<std::uint32_t>& cut_faces) const {
    std::vector<std::uint32_t> used;
    used.reserve(3 * cut_faces.size());
    for (const std::uint32_t f : cut_faces) {
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
    cut.triangles.reserve(cut_faces.size());
    for (const std::uint32_t f : cut_faces) {
      Triangle t = faces_[f];
      if (is_mirrored) std::swap(t[1], t[2]);
      cut.triangles.push_back({new_index(t[0]), new_index(t[1]), new_index(t[2])});
    }
    return cut;
  }

  void add_curves(const PlacedMesh& placed, int axis, const std::vector<std::uint32_t>& cut_faces,
                  SceneContour& contour) const {
    const CutFaces cut = collect(placed, cut_faces);
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
  std::vector<Triangle> faces_;  // when they are first needed, with
  std::vector<Box> blocks_;      // the boxes of kBlock each
};

// The objects, those of one mesh together.
std::vector<std::size_t> objects_by_mesh(const Scene& scene) {
  std::vector<std::size_t> order(scene.objects().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scene.objects()[a].mesh < scene.objects()[b].mesh;
  });
  return order;
}

}  // namespace

std::optional<std::array<SceneContour, 3>> scene_contours(const Scene& scene,
                                                          std::size_t most_faces) {
  const Box& bounds = scene.statistics().bounds_scene;
  const Vec3 centre_scene_m = 0.5 * bounds.low + 0.5 * bounds.high;
  std::array<SceneContour, 3> contours;
  for (int axis = 0; axis < 3; ++axis) contours[axis].offset_m = centre_scene_m[axis];
  std::size_t faces_left = most_faces;
  std::optional<CutMesh> mesh;
  std::optional<std::size_t> mesh_id;
  for (const std::size_t i : objects_by_mesh(scene)) {
    const SceneObject& object = scene.objects()[i];
    if (mesh_id != object.mesh) mesh.emplace(scene.mesh(object.mesh), centre_scene_m);
    mesh_id = object.mesh;
    if (!mesh->cut(object, scene.deformation(i), faces_left, contours)) return std::nullopt;
  }
  return contours;
}

}  // namespace palpate
