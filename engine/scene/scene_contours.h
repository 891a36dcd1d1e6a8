#pragma once

// The contours that a device with two sensors would find in the middle of a scene.

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "engine/scene/scene.h"

namespace palpate {

inline constexpr std::array<std::string_view, 3> kContourNormals = {"A1", "A2", "A3"};

// The intersection of all surfaces with a plane perpendicular to an axis of the scene.
struct SceneContour {
  double offset_m = 0.0;   // position of the plane along the axis, scene frame
  std::size_t curves = 0;  // number of open and closed curves of all surfaces
  double longest_m = 0.0;  // length of the longest curve
  bool is_closed = false;  // whether the longest curve is closed
};

// The default limit on the number of faces examined, for all nodes and planes together. The
// examination of this many faces takes about half a second.
inline constexpr std::size_t kMostContourFaces = std::size_t{1} << 25;

// For each axis, cuts all nodes by the plane perpendicular to this axis through the centre of the
// scene's bounding box. A curve ends at the boundary of its node, as in plane_section() and in
// `palpate run`. Media are not cut. Returns no value if more than most_faces faces would have to be
// examined. A face counts once for each node and plane. Only scenes with many instances reach this
// limit.
//
// At any time, only one mesh and the cut faces of one node need memory. For load time, not for the
// haptic thread. Thread-safe.
std::optional<std::array<SceneContour, 3>> scene_contours(
    const Scene& scene, std::size_t most_faces = kMostContourFaces);

}  // namespace palpate
