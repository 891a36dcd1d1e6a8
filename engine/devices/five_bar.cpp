#include "engine/devices/five_bar.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

double cross(const Vec2& u, const Vec2& v) {
  return u.x() * v.y() - u.y() * v.x();
}

Vec2 turned_left(const Vec2& v) {
  return {-v.y(), v.x()};
}

// The point at the distances from_a and from_b of a and b, to the left of the way from a to b.
std::optional<Vec2> meeting_point(const Vec2& a, const Vec2& b, double from_a, double from_b) {
  const Vec2 way = b - a;
  const double length2 = way.squaredNorm();
  const double along = 0.5 * ((from_a * from_a - from_b * from_b) / length2 + 1.0);
  const double beside2 = from_a * from_a / length2 - along * along;
  if (!(beside2 >= 0.0) || !std::isfinite(beside2)) return std::nullopt;
  return Vec2(a + along * way + std::sqrt(beside2) * turned_left(way));
}

// The direction of `to` from `from`, on the turn that is nearest to `near_rad`.
double angle_near(const Vec2& from, const Vec2& to, double near_rad) {
  const Vec2 way = to - from;
  const Vec2 near(std::cos(near_rad), std::sin(near_rad));
  return near_rad + std::atan2(cross(near, way), near.dot(way));
}

}  // namespace

std::array<Vec2, 2> FiveBar::elbows(const Vec2& joints_rad) const noexcept {
  const double l = links_.proximal_m;
  return {Vec2(l * std::cos(joints_rad[0]), l * std::sin(joints_rad[0])),
          Vec2(links_.base_m + l * std::cos(joints_rad[1]), l * std::sin(joints_rad[1]))};
}

std::optional<Vec2> FiveBar::forward(const Vec2& joints_rad) const noexcept {
  const auto [first, second] = elbows(joints_rad);
  return meeting_point(first, second, links_.distal_m, links_.distal_m);
}

std::optional<Vec2> FiveBar::inverse(const Vec2& p_m) const noexcept {
  const Vec2 first_motor = Vec2::Zero();
  const Vec2 second_motor(links_.base_m, 0.0);
  const auto first = meeting_point(first_motor, p_m, links_.proximal_m, links_.distal_m);
  const auto second = meeting_point(p_m, second_motor, links_.distal_m, links_.proximal_m);
  if (!first || !second || cross(*second - *first, p_m - *first) < 0.0) return std::nullopt;
  const double to_first = std::atan2(p_m.y(), p_m.x());
  const double to_second = std::atan2(p_m.y(), p_m.x() - links_.base_m);
  return Vec2(angle_near(first_motor, *first, to_first),
              angle_near(second_motor, *second, to_second));
}

// The lengths of the distal links are constant: (tip - elbow) . (tip velocity - elbow velocity) = 0
// for each of them.
std::optional<Mat2> FiveBar::jacobian(const Vec2& joints_rad) const noexcept {
  const auto tip = forward(joints_rad);
  if (!tip) return std::nullopt;
  const auto [first, second] = elbows(joints_rad);
  const Vec2 u = *tip - first;
  const Vec2 v = *tip - second;
  const double area = cross(u, v);
  if (area == 0.0) return std::nullopt;
  const double first_rate = u.dot(turned_left(first));
  const double second_rate = v.dot(turned_left(second - Vec2(links_.base_m, 0.0)));
  Mat2 jacobian;
  jacobian.col(0) = first_rate / area * Vec2(v.y(), -v.x());
  jacobian.col(1) = second_rate / area * Vec2(-u.y(), u.x());
  return jacobian;
}

// The singular values s >= t are half the sum and half the difference of two lengths: of the part
// of m that turns and of the part that mirrors.
double condition_number(const Mat2& m) noexcept {
  const double turning = std::hypot(m(0, 0) + m(1, 1), m(1, 0) - m(0, 1));
  const double mirroring = std::hypot(m(0, 0) - m(1, 1), m(1, 0) + m(0, 1));
  const double largest = 0.5 * (turning + mirroring);
  const double det = std::abs(m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));  // s t
  if (!(det > 0.0) || !std::isfinite(largest)) return std::numeric_limits<double>::infinity();
  return std::max(1.0, largest * largest / det);
}

double singularity_factor(double condition) noexcept {
  if (condition <= kFullForceCondition) return 1.0;
  if (!(condition < kNoForceCondition)) return 0.0;
  return std::log(kNoForceCondition / condition) /
         std::log(kNoForceCondition / kFullForceCondition);
}

}  // namespace palpate
