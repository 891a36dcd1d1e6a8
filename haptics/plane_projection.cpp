#include "haptics/plane_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace palpate {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Normals whose cross product is smaller than their own rounding are parallel: no edge to solve on.
constexpr double kParallelSine = 8 * kEpsilon;

// Likewise for three normals in one plane.
constexpr double kCoplanarVolume = 64 * kEpsilon;

// A plane is violated only by more than the rounding of evaluating it.
constexpr double kViolationRoundoff = 16 * kEpsilon;

// Rounding of the difference of two squared distances, relative to either: 4 for each norm, 8 for
// normals of which the length is 1 to within 2 ulp and counts to the fourth power, doubled.
constexpr double kMonotoneRoundoff = 32 * kEpsilon;

// A face that makes a smaller angle than this (sine) with the plane of motion is parallel to it:
// its in-plane normal would have lost half its digits.
constexpr double kMinInPlaneNormal = 1e-8;  // about the square root of double's epsilon

using Candidate = std::optional<Vec3>;

Candidate on_one(const ContactPlane& i, const Vec3& target) {
  const double multiplier = i.offset_m - i.normal.dot(target);
  if (multiplier < 0.0) return std::nullopt;
  return Vec3(target + multiplier * i.normal);
}

Candidate on_two(const ContactPlane& i, const ContactPlane& j, const Vec3& target) {
  const Vec3 edge = i.normal.cross(j.normal);
  const double sine = edge.norm();
  if (sine <= kParallelSine) return std::nullopt;
  const Vec3 along = edge / sine;
  const Vec3 across = along.cross(i.normal);  // completes i.normal and along to a basis
  const double cosine = i.normal.dot(j.normal);
  const double height = (j.offset_m - cosine * i.offset_m) / sine;
  const double multiplier_j = (height - target.dot(across)) / sine;
  const double multiplier_i = i.offset_m - target.dot(i.normal) - multiplier_j * cosine;
  if (multiplier_i < 0.0 || multiplier_j < 0.0) return std::nullopt;
  return Vec3(i.offset_m * i.normal + height * across + target.dot(along) * along);
}

Candidate on_three(const ContactPlane& i, const ContactPlane& j, const ContactPlane& k,
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

bool satisfies_others(std::span<const ContactPlane> planes, const PlaneProjection& p) {
  const auto used = std::span(p.active).first(static_cast<std::size_t>(p.active_count));
  for (int j = 0; j < static_cast<int>(planes.size()); ++j) {
    if (std::find(used.begin(), used.end(), j) != used.end()) continue;
    const ContactPlane& plane = planes[static_cast<std::size_t>(j)];
    const double tolerance =
        kViolationRoundoff * (p.displacement_m.lpNorm<1>() + std::abs(plane.offset_m));
    if (plane.normal.dot(p.displacement_m) < plane.offset_m - tolerance) return false;
  }
  return true;
}

// Normals that are less than this from lying in a plane or line bear a force in any shares.
constexpr double kDependentNormals = 1e-8;  // half the digits of double

}  // namespace

PlaneProjection project_onto_planes(std::span<const ContactPlane> planes, const Vec3& target,
                                    Feasibility start) noexcept {
  PlaneProjection result;
  const auto accept = [&](const Candidate& y, std::array<int, 3> active, int count) {
    if (!y) return false;
    // The answer is never farther from the target than the feasible y = 0. Where rounding says so,
    // the proxy stays; where more than rounding does, the planes were too ill-conditioned.
    const double gain =
        start == Feasibility::kMustMove ? 0.0 : target.squaredNorm() - (*y - target).squaredNorm();
    if (gain < -kMonotoneRoundoff * target.squaredNorm()) return false;
    result.displacement_m = gain < 0.0 ? Vec3(Vec3::Zero()) : *y;
    result.active = active;
    result.active_count = count;
    result.solved = satisfies_others(planes, result);
    return result.solved;
  };
  const int n = static_cast<int>(planes.size());
  if (accept(target, {}, 0)) return result;
  for (int i = 0; i < n; ++i) {
    if (accept(on_one(planes[i], target), {i}, 1)) return result;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      if (accept(on_two(planes[i], planes[j], target), {i, j}, 2)) return result;
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      for (int k = j + 1; k < n; ++k) {
        if (accept(on_three(planes[i], planes[j], planes[k], target), {i, j, k}, 3)) return result;
      }
    }
  }
  return {};
}

std::optional<ContactPlane> within_plane(const ContactPlane& plane,
                                         const Vec3& motion_plane_normal) noexcept {
  const Vec3 normal = plane.normal - plane.normal.dot(motion_plane_normal) * motion_plane_normal;
  const double in_plane = normal.norm();
  if (in_plane < kMinInPlaneNormal) return std::nullopt;
  return ContactPlane{normal / in_plane, plane.offset_m / in_plane};
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
