#pragma once

// The tolerances for rounding in judgements of a proxy.

#include <cstddef>
#include <optional>
#include <span>

#include "geometry/base/types.h"
#include "tests/helpers/floating_point.h"

namespace palpate::test {

// The distance, in ulps, by which a sphere may come nearer to a triangle than its radius, because
// positions and distances are rounded.
inline constexpr double kNearUlps = 64;

// The tolerance for steps that must not increase the distance to the goal: the increase that is
// still accepted. It allows for the rounding of the projection (relative) and of the coordinates of
// the step's corner (in ulps).
inline constexpr double kFartherRelative = 32 * kEpsilon;
inline constexpr double kFartherUlps = 4;

// A part of a path that ends farther from the goal than it begins.
struct Farther {
  std::size_t piece;  // the piece; 0 for the whole path of a sphere
  double by_m;
};

// The first piece of a point's path that increases the distance to the goal. For a sphere, only the
// whole path is judged, since a sphere moves round obstacles. length: the norm that the proxy moves
// in; round_m: the rounding of coordinates.
template <typename Norm>
std::optional<Farther> moves_away(std::span<const Vec3> path, const Vec3& goal, double radius_m,
                                  double round_m, Norm length) {
  const std::size_t stride = radius_m > 0.0 && path.size() > 1 ? path.size() - 1 : 1;
  for (std::size_t i = 0; i + stride < path.size(); i += stride) {
    const double before_m = length(path[i] - goal);
    const double by_m = length(path[i + stride] - goal) - before_m;
    if (by_m > kFartherRelative * before_m + kFartherUlps * round_m) return Farther{i, by_m};
  }
  return std::nullopt;
}
inline std::optional<Farther> moves_away(std::span<const Vec3> path, const Vec3& goal,
                                         double radius_m, double round_m) {
  return moves_away(path, goal, radius_m, round_m, [](const Vec3& v) { return v.norm(); });
}

// Smallest depth that counts as an overlap for a user, relative to the scene's size.
inline constexpr double kOverlapPerSize = 1e-9;

}  // namespace palpate::test
