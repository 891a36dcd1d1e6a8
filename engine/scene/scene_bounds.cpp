#include "engine/scene/scene_bounds.h"

#include <cstddef>
#include <span>
#include <sstream>

#include "io/transform_product.h"

namespace palpate {
namespace {

// Squares of areas must neither overflow nor underflow, also for triangles a million times smaller
// than the scene.
constexpr double kLargestExtent_m = 1e60;
constexpr double kSmallestExtent_m = 1e-60;

// Limit on the vertices examined for the extent of a scene, for all nodes together: up to a second.
constexpr std::size_t kMostExactVertices = std::size_t{1} << 27;

Box bounding_box(std::span<const Vec3> positions, const Mat3& linear) {
  Box box = Box::empty();
  for (const Vec3& p : positions) {
    const Vec3 q = linear * p;
    box = box.united({q, q});
  }
  return box;
}

// The bounding box of p_scene = linear * p + translation_m for all p in a box.
Box placed_box(const Box& box, const NodeDescription& node) {
  const Vec3 centre =
      node.linear_scene_mesh * (0.5 * box.low + 0.5 * box.high) + node.translation_m;
  const Vec3 reach = node.linear_scene_mesh.cwiseAbs() * (0.5 * box.high - 0.5 * box.low);
  return {centre - reach, centre + reach};
}

}  // namespace

std::vector<Box> bounding_boxes(const std::vector<WeldedSurface>& meshes) {
  std::vector<Box> boxes;
  boxes.reserve(meshes.size());
  for (const WeldedSurface& mesh : meshes) {
    boxes.push_back(bounding_box(mesh.positions(), Mat3::Identity()));
  }
  return boxes;
}

Box bounds_in_scene(const std::vector<WeldedSurface>& meshes, const std::vector<Box>& boxes,
                    const std::vector<NodeDescription>& nodes) {
  Box bounds = Box::empty();
  std::size_t left = kMostExactVertices;
  for (const NodeDescription& node : nodes) {
    const WeldedSurface& mesh = meshes[node.mesh];
    if (mesh.face_count() == 0) continue;
    const Box placed = placed_box(boxes[node.mesh], node);
    if (bounds.contains(placed.low) && bounds.contains(placed.high)) continue;
    if (mesh.positions().size() > left) {
      bounds = bounds.united(placed);
      continue;
    }
    left -= mesh.positions().size();
    for (const Vec3& p : mesh.positions()) {
      const Vec3 q = node.linear_scene_mesh * p + node.translation_m;
      bounds = bounds.united({q, q});
    }
  }
  return bounds;
}

std::optional<Error> refuse_beyond_limits(const std::vector<Box>& boxes,
                                          const std::vector<NodeDescription>& nodes) {
  for (const NodeDescription& node : nodes) {
    const Box& box = boxes[node.mesh];
    const Vec3 farthest = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs());
    const Vec3 reach_m = node.linear_scene_mesh.cwiseAbs() * farthest;
    if ((reach_m.array() <= kLargestExtent_m).all()) continue;  // false for NaN
    std::ostringstream problem;
    const double scale = lengthening(node.linear_scene_mesh);
    if (scale != 1.0) problem << "at its scale of " << scale << " ";
    problem << "its mesh reaches farther than " << kLargestExtent_m << " m from its origin";
    return Error{ErrorCode::kLimitExceeded, "", "node \"" + node.name + "\"", problem.str(),
                 "choose another scale"};
  }
  return std::nullopt;
}

std::optional<Error> refuse_extent(const Vec3& extents_m) {
  const double extent_m = extents_m.maxCoeff();
  if (!extents_m.allFinite() || extent_m > kLargestExtent_m || extent_m < kSmallestExtent_m) {
    std::ostringstream problem;
    problem << "its largest extent is " << extent_m << " m; expected " << kSmallestExtent_m
            << " to " << kLargestExtent_m << " m";
    return Error{ErrorCode::kLimitExceeded, "", "scene", problem.str(), "choose another scale"};
  }
  return std::nullopt;
}

}  // namespace palpate
