#pragma once

// The start and the end of a turn around the contour of an object, as a scene file states them.

#include <cstdint>
#include <string>

#include "geometry/base/types.h"

namespace palpate {

// A node with extras.palpate_contour, valid or not. Only a consumer of contours refuses an invalid
// contour; for other consumers, an invalid contour causes a warning.
struct ContourDescription {
  std::string node;  // the node's name
  // The JSON path of the contour, "/nodes/7/extras/palpate_contour". If there is a problem, the
  // path of the wrong value, "/nodes/7/extras/palpate_contour/start_m".
  std::string element;
  // In the scene frame, metres: finite and different from each other. Zero if there is a problem.
  Vec3 start_scene_m = Vec3::Zero();
  Vec3 end_scene_m = Vec3::Zero();
  std::uint32_t tree_node = 0;  // index into SceneDescription::tree
  // The problem and the hint, as in Error; both are empty if the contour is valid.
  std::string problem = {};
  std::string hint = {};
};

// Sets the problem of a contour that has none yet, if a point is not finite or if both points are
// equal.
void check_points(ContourDescription& contour);

// The warning about the problem of a contour.
std::string warning_of(const ContourDescription& contour);

}  // namespace palpate
