#include "engine/simulation/ball_outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "engine/simulation/free_chains.h"
#include "geometry/mesh/collinear_runs.h"

namespace palpate {
namespace {

// Detail below this share of the radius is left out of an outline. It hardly affects where the ball
// can be, and leaving it out limits how many legs of an offset curve meet.
constexpr double kLeftOut = 1.0 / 256;

// The largest angle of a leg that approximates an arc; its error is 1/800 of the radius. For the
// smaller, preparatory balls the coarse angle is used, with an error of a fiftieth of their radius.
constexpr double kLegRad = std::numbers::pi / 32;
constexpr double kCoarseLegRad = std::numbers::pi / 8;

// The part of an outline that the ball touches while its centre is on a leg of the offset curve.
enum class Touched : std::uint8_t { kSegment, kCorner, kNothing };
struct FirstTouch {
  Touched what;
  Vec3 corner_m;  // kCorner
  Vec3 outward;   // kSegment: unit
};

// The approximate distance between segments, as if they were spread evenly along curves or over a
// square. A ball of this radius meets few segments at a time.
double spacing_m(const std::vector<Outline>& outlines) {
  double whole_m = 0.0;
  double count = 1.0;
  Eigen::AlignedBox3d box;
  for (const Outline& outline : outlines) {
    whole_m += length_m(outline.curve);
    count += static_cast<double>(outline.curve.points_m.size());
    for (const Vec3& p : outline.curve.points_m) box.extend(p);
  }
  if (box.isEmpty()) return 0.0;
  return std::min(whole_m / count, 0.25 * box.sizes().maxCoeff() / std::sqrt(count));
}

class BallRoller {
 public:
  BallRoller(const Vec3& plane_normal, double radius_m, double leg_rad)
      : normal_(plane_normal), radius_m_(radius_m), leg_rad_(leg_rad) {}

  // Adds the offset curve of an outline, at the distance of the radius. The offset curve crosses
  // itself at concave corners of the outline; by winding number it still encloses the region that
  // the ball's centre cannot enter (Chen and McMains 2005).
  void add(const Outline& outline) {
    std::vector<Vec3> points = without_collinear_points(
        outline.curve.points_m, outline.curve.closed, normal_, kLeftOut * radius_m_);
    if (points.size() < 2 || is_hollow_too_narrow(outline.curve)) return;
    if (!outline.curve.closed) {  // along both sides
      for (std::size_t i = points.size() - 1; i-- > 1;) points.push_back(Vec3(points[i]));
    }
    Polyline offset{{}, true};
    touches_.emplace_back();
    const std::size_t n = points.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 out = outward(points[(i + n - 1) % n], points[i]);
      add_corner(points[i], out, outward(points[i], points[(i + 1) % n]), offset);
    }
    offset_.push_back(std::move(offset));
  }

  std::optional<std::vector<Outline>> outlines() const {
    std::vector<Outline> found;
    const FreeChains free = free_chains(offset_, normal_);
    if (free.gave_up) return std::nullopt;
    for (const FreeChain& chain : free.chains) {
      if (!chain.closed) continue;
      Polyline touched{without_collinear_points(touched_on(chain), true, normal_, free.merged_m),
                       true};
      if (touched.points_m.size() > 1) found.push_back({std::move(touched), false});
    }
    std::stable_sort(found.begin(), found.end(), [](const Outline& a, const Outline& b) {
      return length_m(a.curve) > length_m(b.curve);
    });
    return found;
  }

 private:
  // Whether the curve encloses a hollow that is too narrow for the ball; such a hollow is ignored.
  bool is_hollow_too_narrow(const Polyline& curve) const {
    if (!curve.closed) return false;
    const std::vector<Vec3>& points_m = curve.points_m;
    const Vec3 u = normal_.unitOrthogonal();
    const Vec3 v = normal_.cross(u);
    double twice_area_m2 = 0.0;
    Eigen::AlignedBox2d box;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
      const Vec3 a = points_m[i] - points_m[0];
      const Vec3 b = points_m[(i + 1) % points_m.size()] - points_m[0];
      twice_area_m2 += a.cross(b).dot(normal_);
      box.extend(Eigen::Vector2d(a.dot(u), a.dot(v)));
    }
    return twice_area_m2 < 0.0 && box.sizes().minCoeff() < 2.0 * radius_m_;
  }

  Vec3 outward(const Vec3& from, const Vec3& to) const {
    return (to - from).cross(normal_).normalized();
  }

  // The angle from one direction to another, positive to the left.
  double turn_rad(const Vec3& from, const Vec3& to) const {
    return std::atan2(from.cross(to).dot(normal_), from.dot(to));
  }
  Vec3 turned(const Vec3& direction, double angle_rad) const {
    return std::cos(angle_rad) * direction + std::sin(angle_rad) * normal_.cross(direction);
  }

  // The offset curve follows an arc around a convex corner and passes through a concave corner;
  // then it follows the next segment.
  void add_corner(const Vec3& corner_m, const Vec3& before, const Vec3& after, Polyline& offset) {
    const auto add_leg = [&](const Vec3& from, const FirstTouch& touch) {
      offset.points_m.push_back(from);
      touches_.back().push_back(touch);
    };
    // A curve that turns back goes around an end; a slit of zero width is ignored.
    const double rad = turn_rad(before, after);
    const bool turns_back = before.cross(after).norm() < kTurnsBack && before.dot(after) < 0.0;
    if (rad >= 0.0 || turns_back) {
      const double whole_rad = std::abs(rad);
      const double legs = std::ceil(whole_rad / leg_rad_);
      for (double k = 0.0; k < legs; ++k) {
        const Vec3 out = k == 0.0 ? before : turned(before, k / legs * whole_rad);
        add_leg(corner_m + radius_m_ * out, {Touched::kCorner, corner_m, Vec3::Zero()});
      }
    } else {
      add_leg(corner_m + radius_m_ * before, {Touched::kNothing, corner_m, Vec3::Zero()});
      add_leg(corner_m, {Touched::kNothing, corner_m, Vec3::Zero()});
    }
    add_leg(corner_m + radius_m_ * after, {Touched::kSegment, corner_m, after});
  }

  // The points that the ball touches, in order, with an arc of the ball between the point that it
  // leaves and the next.
  std::vector<Vec3> touched_on(const FreeChain& chain) const {
    std::vector<Vec3> touched;
    const std::size_t n = chain.points.size();
    for (std::size_t i = 0; i < n; ++i) {
      const ChainPoint& here = chain.points[i];
      const ChainPoint& before = chain.points[(i + n - 1) % n];
      const Vec3 left = place(before, here.p_m) - here.p_m;
      const Vec3 next = place(here, here.p_m) - here.p_m;
      touched.push_back(here.p_m + left);
      add_arc(here.p_m, left, next, touched);
      touched.push_back(here.p_m + next);
    }
    return touched;
  }

  Vec3 place(const ChainPoint& on, const Vec3& centre_m) const {
    const FirstTouch& touch = touches_[on.curve][on.segment];
    return touch.what == Touched::kSegment ? Vec3(centre_m - radius_m_ * touch.outward)
                                           : touch.corner_m;
  }

  // Adds an arc around the centre, clockwise.
  void add_arc(const Vec3& centre_m, const Vec3& from, const Vec3& to,
               std::vector<Vec3>& points) const {
    const double rad = turn_rad(from, to);
    if (rad >= -leg_rad_) return;
    const double legs = std::ceil(-rad / leg_rad_);
    for (double k = 1.0; k < legs; ++k) points.push_back(centre_m + turned(from, k / legs * rad));
  }

  // Directions whose sine is below this count as parallel; it covers the rounding of merged points.
  // A slit mistaken for an end adds only points inside the region that the ball cannot enter.
  static constexpr double kTurnsBack = 0x1p-20;

  Vec3 normal_;
  double radius_m_;
  double leg_rad_;
  std::vector<Polyline> offset_;
  std::vector<std::vector<FirstTouch>> touches_;  // by curve and segment
};

// Arcs of a ball that bridges a gap from both sides may cross. Returns the outlines of the union of
// the regions that all curves enclose, which are solid for a larger ball.
std::optional<std::vector<Outline>> uncrossed(const std::vector<Outline>& touched,
                                              const Vec3& plane_normal) {
  std::vector<Polyline> curves;
  for (const Outline& outline : touched) curves.push_back(outline.curve);
  std::vector<Outline> whole;
  const FreeChains free = free_chains(curves, plane_normal);
  if (free.gave_up) return std::nullopt;
  for (const FreeChain& chain : free.chains) {
    if (!chain.closed || chain.is_sheet) continue;
    whole.push_back({{{}, true}, false});
    for (const ChainPoint& p : chain.points) whole.back().curve.points_m.push_back(p.p_m);
  }
  return whole;
}

}  // namespace

std::optional<std::vector<Outline>> ball_outlines(const std::vector<Outline>& found,
                                                  const Vec3& plane_normal, double radius_m) {
  // The parts of the outlines that a large ball touches are among those that a smaller ball
  // touches. The radius is therefore doubled step by step, so that each ball meets few segments at
  // a time.
  std::vector<Outline> touched = found;
  const double first_m = spacing_m(found);
  double r_m = radius_m;
  while (first_m > 0.0 && r_m > first_m) r_m *= 0.5;
  for (;; r_m *= 2.0) {
    BallRoller roller(plane_normal, r_m, r_m == radius_m ? kLegRad : kCoarseLegRad);
    for (const Outline& outline : touched) roller.add(outline);
    std::optional<std::vector<Outline>> reached = roller.outlines();
    if (!reached || r_m == radius_m || reached->empty()) return reached;
    auto whole = uncrossed(*reached, plane_normal);
    if (!whole) return std::nullopt;
    touched = std::move(*whole);
  }
}

}  // namespace palpate
