#include "haptics/proxy/plane_projection.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/exact/orientation.h"

namespace palpate {
namespace {

// Two normals are parallel if the length of their cross product is within its rounding. Their
// planes then have no common line.
constexpr double kParallelSine = 16 * kUnitRoundoff;

// Three normals lie in one plane if their triple product is within its rounding.
constexpr double kCoplanarVolume = 128 * kUnitRoundoff;

// Rounding of the component of a target along a plane, relative to the target: for each axis, 3 for
// the product with the normal and 2 for the subtraction.
constexpr double kCancelled = 16 * kUnitRoundoff;

// A plane counts as violated only beyond the rounding of its evaluation.
constexpr double kViolationRoundoff = 32 * kUnitRoundoff;

// Rounding of the difference of two squared distances, relative to either: 4 for each norm, and 8
// for normals whose length is 1 to within 2 ulp and enters with the fourth power; all doubled.
constexpr double kMonotoneRoundoff = 64 * kUnitRoundoff;

// A face counts as parallel to the plane of motion if the sine of the angle between them is smaller
// than this: its normal in that plane would have lost half of its digits.
constexpr double kMinInPlaneNormal = 1e-8;  // about the square root of double's epsilon

// Largest number of exchanges per plane. The distance to the target increases with every exchange,
// so no basis occurs twice, and few exchanges are usually needed. Only sets of planes constructed
// for the purpose need more than this.
constexpr int kMostExchangesPerPlane = 4;

// Where two planes meet, as seen from the first one.
struct CrossingLine {
  double sine;  // of the angle between the planes
  Vec3 across;  // unit, in the first plane, away from the second
  Vec3 along;   // unit, in both planes

  Vec3 part_along(const Vec3& target) const { return target.dot(along) * along; }
};

// The same for two lines in a plane of motion, which meet in a point.
struct CrossingPoint {
  double sine;
  Vec2 across;

  static Vec2 part_along(const Vec2&) { return Vec2::Zero(); }
};

inline std::optional<CrossingLine> crossing(const Vec3& i, const Vec3& j) {
  const double sine = i.cross(j).norm();
  if (sine <= kParallelSine) return std::nullopt;
  const Vec3 along = crossing_line(i, j);
  return CrossingLine{sine, along.cross(i), along};
}

inline std::optional<CrossingPoint> crossing(const Vec2& i, const Vec2& j) {
  const double turn = i.x() * j.y() - i.y() * j.x();
  const double sine = std::abs(turn);
  if (sine <= kParallelSine) return std::nullopt;
  return CrossingPoint{sine, turn > 0.0 ? Vec2(-i.y(), i.x()) : Vec2(i.y(), -i.x())};
}

template <typename Vec>
inline std::optional<Vec> on_one(const HalfSpace<Vec>& i, const Vec& target) {
  const double multiplier = i.offset_m - i.normal.dot(target);
  if (multiplier < 0.0) return std::nullopt;
  const Vec y = target + multiplier * i.normal;
  const bool is_rounding = y.squaredNorm() <= kCancelled * kCancelled * target.squaredNorm();
  return is_rounding ? Vec(i.offset_m * i.normal) : y;
}

template <typename Vec>
std::optional<Vec> on_two(const HalfSpace<Vec>& i, const HalfSpace<Vec>& j, const Vec& target) {
  const auto place = crossing(i.normal, j.normal);
  if (!place) return std::nullopt;
  const double cosine = i.normal.dot(j.normal);
  const double height = (j.offset_m - cosine * i.offset_m) / place->sine;
  const double multiplier_j = (height - target.dot(place->across)) / place->sine;
  const double multiplier_i = i.offset_m - target.dot(i.normal) - multiplier_j * cosine;
  if (multiplier_i < 0.0 || multiplier_j < 0.0) return std::nullopt;
  return Vec(i.offset_m * i.normal + height * place->across + place->part_along(target));
}

std::optional<Vec3> on_three(const ContactPlane& i, const ContactPlane& j, const ContactPlane& k,
                             const Vec3& target) {
  const Vec3 jk = j.normal.cross(k.normal);
  const Vec3 ki = k.normal.cross(i.normal);
  const Vec3 ij = i.normal.cross(j.normal);
  const double volume = i.normal.dot(jk);
  if (std::abs(volume) <= kCoplanarVolume) return std::nullopt;
  const Vec3 y = (i.offset_m * jk + j.offset_m * ki + k.offset_m * ij) / volume;
  const Vec3 push = (y - target) / volume;
  if (push.dot(jk) < 0.0 || push.dot(ki) < 0.0 || push.dot(ij) < 0.0) return std::nullopt;
  return y;
}

// The amount by which a displacement violates a plane beyond the rounding of its evaluation;
// positive if it does.
template <typename Vec>
double violation_m(const HalfSpace<Vec>& plane, const Vec& y_m) {
  const double roundoff_m =
      kViolationRoundoff * (y_m.template lpNorm<1>() + std::abs(plane.offset_m));
  return plane.offset_m - plane.normal.dot(y_m) - roundoff_m;
}

// A basis: the active planes in ascending order and the displacement that lies on all of them.
template <typename Vec>
bool has(const Projection<Vec>& basis, int plane) {
  const auto end = basis.active.begin() + basis.active_count;
  return std::find(basis.active.begin(), end, plane) != end;
}

// Computes the point on all planes of the basis that is nearest to the target. True if every plane
// pushes.
template <typename Vec>
bool solve(std::span<const HalfSpace<Vec>> planes, const Vec& target, Projection<Vec>& basis) {
  const auto plane = [&](std::size_t i) -> const HalfSpace<Vec>& {
    return planes[static_cast<std::size_t>(basis.active[i])];
  };
  std::optional<Vec> y;
  if (basis.active_count == 1) {
    y = on_one(plane(0), target);
  } else if (basis.active_count == 2) {
    y = on_two(plane(0), plane(1), target);
  } else if constexpr (Vec::SizeAtCompileTime == 3) {
    y = on_three(plane(0), plane(1), plane(2), target);
  }
  if (y) basis.displacement_m = *y;
  return y.has_value();
}

// The index of the most violated plane, or -1.
template <typename Vec>
int most_violated(std::span<const HalfSpace<Vec>> planes, const Projection<Vec>& basis) {
  int most = -1;
  double by_m = 0.0;
  for (int i = 0; i < static_cast<int>(planes.size()); ++i) {
    if (has(basis, i)) continue;
    const double v_m = violation_m(planes[static_cast<std::size_t>(i)], basis.displacement_m);
    if (v_m <= by_m) continue;
    most = i;
    by_m = v_m;
  }
  return most;
}

// The basis for the planes of `basis` and the plane `added`, which `basis` violates. Planes of
// `basis` that are not in the new basis are satisfied to within slack_m.
template <typename Vec>
std::optional<Projection<Vec>> exchange(std::span<const HalfSpace<Vec>> planes, const Vec& target,
                                        const Projection<Vec>& basis, int added, double slack_m) {
  const auto holds_for_all = [&](const Projection<Vec>& next) {
    for (int i = 0; i < basis.active_count; ++i) {
      const int other = basis.active[static_cast<std::size_t>(i)];
      if (has(next, other)) continue;
      if (violation_m(planes[static_cast<std::size_t>(other)], next.displacement_m) > slack_m) {
        return false;
      }
    }
    return true;
  };
  // Bases of the added plane and zero or one other, and in three coordinates also two others, whose
  // bits are set in `chosen`.
  constexpr std::array kSubsetsBySize{0b000, 0b001, 0b010, 0b100, 0b011, 0b101, 0b110};
  constexpr std::size_t kSubsets = Vec::SizeAtCompileTime == 3 ? kSubsetsBySize.size() : 3;
  for (const int chosen : std::span(kSubsetsBySize).template first<kSubsets>()) {
    if (chosen >> basis.active_count != 0) continue;
    Projection<Vec> next;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if ((chosen >> i & 1) != 0) next.active[count++] = basis.active[i];
    }
    std::size_t at = count;  // of the added plane, in ascending order
    for (; at > 0 && next.active[at - 1] > added; --at) next.active[at] = next.active[at - 1];
    next.active[at] = added;
    next.active_count = static_cast<int>(count) + 1;
    if (solve(planes, target, next) && holds_for_all(next)) return next;
  }
  return std::nullopt;
}

// Rounding of the target's part along a plane.
template <typename Vec>
double rounding_m(const Vec& target) {
  return kCancelled * target.norm();
}

// Whether the displacement keeps the planes of its own basis. Points on one or two planes do;
// rounding may displace the point in which three planes meet that nearly have a common direction.
template <typename Vec>
[[gnu::noinline]] bool keeps_own_planes(std::span<const HalfSpace<Vec>> planes, const Vec& target,
                                        const Projection<Vec>& basis) {
  return std::all_of(basis.active.begin(), basis.active.begin() + basis.active_count, [&](int i) {
    const auto& plane = planes[static_cast<std::size_t>(i)];
    return violation_m(plane, basis.displacement_m) <= rounding_m(target);
  });
}

// The gain of a displacement from the feasible y = 0: |target|^2 - |y - target|^2. The difference
// of the two squares loses the gain of a displacement that is shorter than 1e-8 of the target; the
// product loses it only at 1e-16. A displacement along one plane is first freed of the component
// across the plane that the rounding of the target has left in it.
template <typename Vec>
[[gnu::noinline, gnu::cold]] double gain_of_little(std::span<const HalfSpace<Vec>> planes,
                                                   const Vec& target, Projection<Vec>& basis) {
  Vec& y = basis.displacement_m;
  if (basis.active_count == 1) {
    const HalfSpace<Vec>& plane = planes[static_cast<std::size_t>(basis.active[0])];
    y += (plane.offset_m - plane.normal.dot(y)) * plane.normal;
  }
  return y.dot(2.0 * target - y);
}

// Rejects a solution that is farther from the target than the feasible y = 0. If the difference is
// within rounding, the solution is y = 0; if it is larger, the planes were ill-conditioned and the
// problem is not solved.
template <typename Vec>
inline void keep_near(std::span<const HalfSpace<Vec>> planes, Projection<Vec>& basis,
                      const Vec& target, Feasibility start) {
  const double gain = start == Feasibility::kMustMove
                          ? 0.0
                          : target.squaredNorm() - (basis.displacement_m - target).squaredNorm();
  if (gain < -kMonotoneRoundoff * target.squaredNorm()) {
    basis = {};
    return;
  }
  const bool is_precise = start == Feasibility::kAtStartPrecise;
  if (gain < 0.0 && !(is_precise && gain_of_little(planes, target, basis) >= 0.0)) {
    basis.displacement_m.setZero();
  }
  basis.solved = true;
}

template <typename Vec>
Projection<Vec> nearest_of_all(std::span<const HalfSpace<Vec>> planes, const Vec& target,
                               Feasibility start) {
  Projection<Vec> basis;
  basis.displacement_m = target;
  if (planes.size() == 1) {  // the most frequent case
    const bool is_violated = violation_m(planes[0], target) > 0.0;
    const std::optional<Vec> y = is_violated ? on_one(planes[0], target) : target;
    if (!y) return {};
    basis.displacement_m = *y;
    basis.active_count = is_violated ? 1 : 0;
    keep_near(planes, basis, target, start);
    return basis;
  }
  int left = kMostExchangesPerPlane * static_cast<int>(planes.size());
  while (static_cast<std::size_t>(basis.active_count) < planes.size()) {
    const int added = most_violated(planes, basis);
    if (added < 0) break;
    if (left-- == 0) return {};
    if (basis.active_count == 0) {
      basis.active = {added, 0, 0};
      basis.active_count = 1;
      if (!solve(planes, target, basis)) return {};
      continue;
    }
    auto next = exchange(planes, target, basis, added, 0.0);
    if (!next) {
      // If planes nearly coincide, each solution may violate the others by its own rounding.
      const auto& violated = planes[static_cast<std::size_t>(added)];
      if (violation_m(violated, basis.displacement_m) <= rounding_m(target)) break;
      next = exchange(planes, target, basis, added, rounding_m(target));
      if (!next) return {};
    }
    basis = *next;
  }
  if (basis.active_count == 3 && !keeps_own_planes(planes, target, basis)) return {};
  keep_near(planes, basis, target, start);
  return basis;
}

// Normals count as linearly dependent if their triple product is smaller than this; the shares in
// which they bear a force are then undetermined.
constexpr double kDependentNormals = 1e-8;  // half the digits of double

}  // namespace

PlaneProjection project_onto_planes(std::span<const ContactPlane> planes, const Vec3& target,
                                    Feasibility start) noexcept {
  return nearest_of_all(planes, target, start);
}

Projection<Vec2> project_onto_planes(std::span<const HalfSpace<Vec2>> planes, const Vec2& target,
                                     Feasibility start) noexcept {
  return nearest_of_all(planes, target, start);
}

PlaneProjection project_within(const MotionPlane& motion_plane,
                               std::span<const ContactPlane> planes, const Vec3& target,
                               Feasibility start) noexcept {
  std::array<HalfSpace<Vec2>, kMaxContactPlanes> lines;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    lines[i] = {motion_plane.to_plane(planes[i].normal), planes[i].offset_m};
  }
  const Projection<Vec2> nearest =
      project_onto_planes(std::span<const HalfSpace<Vec2>>(lines).first(planes.size()),
                          motion_plane.to_plane(target), start);
  const bool is_free = nearest.solved && nearest.active_count == 0;
  return {is_free ? target : motion_plane.to_solver(nearest.displacement_m), nearest.active,
          nearest.active_count, nearest.solved};
}

std::optional<ContactPlane> within_plane(const ContactPlane& plane,
                                         const MotionPlane& motion_plane) noexcept {
  const Vec2 normal = motion_plane.to_plane(plane.normal);
  const double in_plane = normal.norm();
  if (in_plane < kMinInPlaneNormal) return std::nullopt;
  return ContactPlane{motion_plane.to_solver(normal / in_plane), plane.offset_m / in_plane};
}

std::array<double, 3> bearing_parts(const Vec3& lag_m, std::span<const Vec3> n) noexcept {
  std::array<double, 3> parts{};
  if (n.size() == 1) {
    parts[0] = std::max(0.0, n[0].dot(lag_m));
    return parts;
  }
  Mat3 columns;
  columns.col(0) = n[0];
  columns.col(1) = n[1];
  const Vec3 across = n[0].cross(n[1]);
  columns.col(2) = n.size() == 3 ? n[2] : Vec3(across.normalized());
  if (std::abs(columns.determinant()) > kDependentNormals) {
    const Vec3 along = columns.inverse() * lag_m;
    for (std::size_t i = 0; i < n.size(); ++i) {
      parts[i] = std::max(0.0, along[static_cast<Eigen::Index>(i)]);
    }
    return parts;
  }
  for (std::size_t i = 0; i < n.size(); ++i) {
    parts[i] = lag_m.norm() / static_cast<double>(n.size());
  }
  return parts;
}

std::array<double, 3> bearing_shares(const Vec3& lag_m, std::span<const Vec3> n) noexcept {
  std::array<double, 3> shares{1.0};
  if (n.size() == 1) return shares;
  shares = bearing_parts(lag_m, n);
  const double sum_m = shares[0] + shares[1] + shares[2];
  for (std::size_t i = 0; i < n.size(); ++i) {
    shares[i] = sum_m > 0.0 ? shares[i] / sum_m : 1.0 / static_cast<double>(n.size());
  }
  return shares;
}

}  // namespace palpate
