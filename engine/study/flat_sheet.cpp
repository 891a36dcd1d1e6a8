#include "engine/study/flat_sheet.h"

#include <numbers>
#include <utility>

namespace palpate {
namespace {

constexpr double kHalfSide_m = 0.5 * FlatSheet::kSide_m;

// Off the diagonal, where two triangles would be touched at once.
constexpr double kOffDiagonal_m = FlatSheet::kSide_m / 6.0;

Scene compile_sheet(const RigidTransform& T_scene_sheet) {
  constexpr double h = kHalfSide_m;
  SceneDescription description;
  description.meshes.push_back(
      {"sheet", {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  description.nodes.push_back(
      {"sheet", 0, T_scene_sheet.rotation.toRotationMatrix(), T_scene_sheet.translation_m});
  description.tree.resize(1);
  return std::move(*Scene::compile(std::move(description)));  // nothing that could be refused
}

}  // namespace

FlatSheet::FlatSheet(const Vec3& normal, SeededRandom& random)
    : normal_(normal),
      T_scene_sheet_([&] {
        const double turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
        const Quat turn(Eigen::AngleAxisd(turn_rad, normal));
        const Quat facing = Quat::FromTwoVectors(Vec3::UnitZ(), normal);
        return RigidTransform{(turn * facing).normalized(), random.in_box(kHalfSide_m)};
      }()),
      scene_(compile_sheet(T_scene_sheet_)) {}

Vec3 FlatSheet::below(double depth_m, const Eigen::Vector2d& along_m) const {
  const Vec3 in_sheet_m(kOffDiagonal_m + along_m.x(), -kOffDiagonal_m + along_m.y(), 0.0);
  return T_scene_sheet_.point(in_sheet_m) - depth_m * normal_;
}

}  // namespace palpate
