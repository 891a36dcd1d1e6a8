#pragma once

// The kinematics of a planar five-bar linkage (a pantograph) with two motors at its base.

#include <array>
#include <optional>

#include "geometry/base/types.h"

namespace palpate {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

// The lengths of the links, > 0. The defaults are those of the example of the maker of hAPI boards;
// other kits differ.
struct FiveBarLinks {
  double base_m = 0.02;      // between the joints of the motors
  double proximal_m = 0.05;  // from each motor to its elbow
  double distal_m = 0.07;    // from each elbow to the tip
};

// Device frame: the first motor's joint is the origin, the second one's lies at x = base_m. Angles
// are counter-clockwise from x. The linkage works with its elbows outwards, and the tip lies to the
// left of the line from the first elbow to the second. Of the two points at which the distal links
// can meet, this is the one with the larger y as long as the second elbow lies to the right of the
// first.
//
// Thread-safety: immutable. No function allocates or throws.
class FiveBar {
 public:
  explicit FiveBar(const FiveBarLinks& links) noexcept : links_(links) {}

  // The position of the tip. No value if the angles are not finite or the distal links cannot meet.
  std::optional<Vec2> forward(const Vec2& joints_rad) const noexcept;

  // The angles at which the tip is at p_m, elbows outwards. No value if p_m is out of reach, not
  // finite, or to the right of the line from the first elbow to the second. The first angle is
  // above, the second one below the direction from its motor to the tip, which lies in (-pi, pi].
  std::optional<Vec2> inverse(const Vec2& p_m) const noexcept;

  // The derivative of forward(), m/rad: tip velocity = J . joint speeds, and torques = J^T . force,
  // so that force . velocity = torques . joint speeds. No value where forward() has none or the
  // distal links are parallel.
  std::optional<Mat2> jacobian(const Vec2& joints_rad) const noexcept;

  const FiveBarLinks& links() const noexcept { return links_; }

 private:
  std::array<Vec2, 2> elbows(const Vec2& joints_rad) const noexcept;

  FiveBarLinks links_;
};

// The ratio of the singular values of a matrix, at least 1; infinite for a matrix without full
// rank.
double condition_number(const Mat2& m) noexcept;

// Near a singular pose, small errors of the angles turn the force, and the motors cannot push in
// one direction. The force is therefore multiplied by this factor: 1 up to a condition of
// kFullForceCondition, 0 from kNoForceCondition on, and linear in the logarithm of the condition
// between them.
inline constexpr double kFullForceCondition = 10.0;
inline constexpr double kNoForceCondition = 20.0;
double singularity_factor(double condition) noexcept;

}  // namespace palpate
