#include "io/contour_description.h"

#include "geometry/base/quoted.h"

namespace palpate {

void check_points(ContourDescription& contour) {
  if (!contour.problem.empty()) return;
  if (!contour.start_scene_m.allFinite() || !contour.end_scene_m.allFinite()) {
    contour.problem = "has a point that is not finite in the scene frame; expected finite numbers";
    contour.hint = "reduce the point, or the scale of the node, of its ancestors or of the scene";
  } else if (contour.start_scene_m == contour.end_scene_m) {
    contour.problem = "has equal points in the scene frame; expected two different points";
    contour.hint =
        "state different points, and do not scale the node, its ancestors or the scene to zero";
  } else {
    return;
  }
  contour.start_scene_m.setZero();
  contour.end_scene_m.setZero();
}

std::string warning_of(const ContourDescription& contour) {
  return contour.element + ": " + contour.problem + "; the contour of " + in_quotes(contour.node) +
         " is ignored (" + contour.hint + ")";
}

}  // namespace palpate
