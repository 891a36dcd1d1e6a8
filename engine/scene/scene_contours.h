#pragma once

// What a device with two sensors would find in the middle of a scene.

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "engine/scene/scene.h"

namespace palpate {

inline constexpr std::array<std::string_view, 3> kContourNormals = {"A1", "A2", "A3"};

// What a plane across an axis of the scene cuts out of the surfaces.
struct SceneContour {
  double offset_m = 0.0;   // of the plane, along the axis, scene frame
  std::size_t curves = 0;  // open and closed ones, of all surfaces
  double longest_m = 0.0;  // of the curves
  bool is_closed = false;  // the longest
};

// Faces that are looked at, of all nodes and planes together: a second or two.
inline constexpr std::size_t kMostContourFaces = std::size_t{1} << 28;

// For each axis, the plane across it through the centre of the scene's bounding box. Curves end
// where a node ends, as those of plane_section() and of `palpate run`. Media have none. Nothing if
// the meshes of the nodes that planes cut have more than most_faces faces, which takes many
// instances.
//
// Takes memory for one mesh, and for what is cut of one node at a time. For load time. Thread-safe.
std::optional<std::array<SceneContour, 3>> scene_contours(
    const Scene& scene, std::size_t most_faces = kMostContourFaces);

}  // namespace palpate
