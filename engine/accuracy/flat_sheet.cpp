#include "engine/accuracy/flat_sheet.h"

#include <numbers>
#include <utility>

#include "geometry/base/decompositions.h"

namespace palpate {
namespace {

// Away from the diagonal, where the hand would touch two triangles at once.
constexpr double kOffDiagonal_m = kSheetSize_m / 6.0;

// A pose with this normal, and a random turn and position.
RigidTransform facing(const Vec3& normal, SeededRandom& random) {
  const double turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Quat turn(Eigen::AngleAxisd(turn_rad, normal));
  const Quat upright = turn_between(Vec3::UnitZ(), normal);
  return {(turn * upright).normalized(), random.in_box(0.5 * kSheetSize_m)};
}

}  // namespace

FlatSheet::FlatSheet(const Vec3& normal, SeededRandom& random)
    : normal_(normal),
      sheet_(std::move(*sheet_at(facing(normal, random)))) {}  // no error without friction

Vec3 FlatSheet::below(double depth_m, const Eigen::Vector2d& along_m) const {
  const Vec3 in_sheet_m(kOffDiagonal_m + along_m.x(), -kOffDiagonal_m + along_m.y(), 0.0);
  return sheet_.T_scene_sheet.point(in_sheet_m) - depth_m * normal_;
}

}  // namespace palpate
