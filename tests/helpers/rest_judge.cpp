#include "tests/helpers/rest_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace palpate::test {
namespace {

using Wide = long double;
using Wide3 = ExactJudge::Wide3;

constexpr Wide kWideEpsilon = std::numeric_limits<Wide>::epsilon();
constexpr Wide kDoubleEpsilon = std::numeric_limits<double>::epsilon();
constexpr Wide kInfinity = std::numeric_limits<Wide>::infinity();

// A triangle counts as one stand-off away if its distance differs from a stand-off only by the
// rounding of a stop, which is that of the proxy's coordinates and of heights above faces in
// double. For a point this is 1.4e-3 stand-offs. It matters at convex edges: a proxy that is x
// stand-offs too high may descend past the edge by sqrt(2 x).
constexpr Wide kTouchUlps = 64;

// An escape may come nearer to a triangle by the rounding of its end's coordinates and of a body's
// pose.
constexpr Wide kWayUlps = 8;

// The rounding of slopes of unit vectors in long double.
constexpr Wide kSlopeUlps = 16;

// The rotation of a contact direction by its rounding to double, times the distance in sizes
// (friction uses such rounded directions); also the rotation of the intersection line of two
// planes, times the sine of the angle between them.
constexpr Wide kTurnUlps = 4;

// Two normals that differ by less are treated as equal.
constexpr Wide kSameNormal = 1e-15L;

// The most obstacles that may bend a descent.
constexpr int kMostBends = 64;

// The planes of triangles within this many stand-offs of the proxy are tried, the nearest first.
constexpr Wide kNearStandOffs = 64;
constexpr std::size_t kMostPlanes = 64;
constexpr std::size_t kMostCorners = 24;

constexpr int kBisections = 24;

// A triangle near the proxy. Solver frame.
struct Near {
  std::size_t body;
  std::size_t triangle;
  Wide distance_m;
  Wide3 away;    // unit, from the triangle's nearest point to the proxy
  Wide3 normal;  // of the triangle's plane
  Wide slope_error;
  bool is_over;  // the proxy is over the triangle, not beside it
};

// A constraint: no escape may approach the wall.
struct Wall {
  Wide3 away;  // unit; in the plane of motion, if any
  Wide slope_error;
};

// A direction to try.
struct Slide {
  Wide3 direction;  // unit
  Wide hold_m = 0;  // the part of the lag that friction holds
};

// The point where a triangle stops an escape.
struct Stop {
  Wide length_m = kInfinity;
  Wide3 away = Wide3::Zero();  // unit, from the triangle
};

struct Frame {
  Eigen::Matrix<Wide, 3, 3> R_solver_body;
  Wide3 proxy_body;
};

Eigen::Matrix<Wide, 3, 3> wide_rotation(const Quat& q) {
  return Eigen::Quaternion<Wide>(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
}

// The parameter s at which the ray x + s u enters the ball of this radius around the origin; x is
// outside. For vectors across an edge, the ball stands for the cylinder around the edge.
Wide entry_of_ball(const Wide3& x, const Wide3& u, Wide radius) {
  const Wide a = u.squaredNorm();
  if (a == 0) return kInfinity;
  const Wide middle = -x.dot(u) / a;
  if (middle < 0) return kInfinity;
  const Wide3 nearest = x + middle * u;
  const Wide half_chord2 = radius * radius - nearest.squaredNorm();
  if (half_chord2 <= 0) return kInfinity;
  return std::max<Wide>(0, middle - std::sqrt(half_chord2 / a));
}

class Search {
 public:
  Search(std::span<const JudgedBody> bodies, const Rest& rest, double size_m, double radius_m,
         double stand_off_m, double tolerance_m)
      : bodies_(bodies), rest_(rest), proxy_(rest.proxy.cast<Wide>()), tolerance_m_(tolerance_m) {
    const Wide extent_m = std::max<Wide>(
        {static_cast<Wide>(size_m), static_cast<Wide>(radius_m), proxy_.cwiseAbs().maxCoeff()});
    ulp_m_ = kDoubleEpsilon * extent_m;
    round_m_ = kWayUlps * ulp_m_;
    radius_m_ = static_cast<Wide>(radius_m);
    keep_m_ = radius_m_ + static_cast<Wide>(stand_off_m);
    touch_m_ = keep_m_ + kTouchUlps * ulp_m_;
    near_m_ = keep_m_ + (kNearStandOffs - 1) * static_cast<Wide>(stand_off_m);
    lag_ = rest.goal.cast<Wide>() - proxy_;
    if (rest_.motion_plane_normal) {
      motion_normal_ = rest_.motion_plane_normal->cast<Wide>().normalized();
      lag_ -= lag_.dot(*motion_normal_) * *motion_normal_;
    }
    lag_m_ = lag_.norm();
    for (const JudgedBody& body : bodies_) {
      const auto R = wide_rotation(body.T_solver_body.rotation);
      const Wide3 from_body = proxy_ - body.T_solver_body.translation_m.cast<Wide>();
      frames_.push_back({R, R.transpose() * from_body});
    }
  }

  Verdict judge() {
    if (lag_m_ <= tolerance_m_) return {std::nullopt, true};
    find_near();
    if (auto escape = try_slide({lag_ / lag_m_}, "straight")) return {escape, true};
    if (gain_of(steepest(cone_)) <= tolerance_m_) return {std::nullopt, true};
    if (auto escape = is_held() ? slide_on_touched_surfaces() : descend()) return {escape, true};
    if (auto escape = slide_on_planes()) return {escape, true};
    return {std::nullopt, false};
  }

 private:
  bool is_held() const { return rest_.static_friction > 0.0; }

  Near nearness(std::size_t body, std::size_t triangle) const {
    const ExactJudge& judge = *bodies_[body].judge;
    const Corners& t = judge.triangles()[triangle];
    const ExactJudge::Directions& d = judge.directions(triangle);
    const Frame& frame = frames_[body];
    const std::array<const Vec3*, 3> corners = {&t.a, &t.b, &t.c};
    bool is_over = true;
    Wide3 from_nearest = Wide3::Zero();
    Wide distance_m = kInfinity;
    Wide arm_m = 0;  // the size of the coordinates whose rounding is in from_nearest
    for (std::size_t e = 0; e < 3; ++e) {
      const Wide3 to_proxy = frame.proxy_body - corners[e]->cast<Wide>();
      is_over = is_over && d.outward[e].dot(to_proxy) <= 0;
      const Wide at = std::clamp<Wide>(d.along[e].dot(to_proxy), 0, d.length_m[e]);
      const Wide3 across = to_proxy - at * d.along[e];
      if (across.norm() < distance_m) {
        distance_m = across.norm();
        from_nearest = across;
      }
      arm_m = std::max(arm_m, to_proxy.norm());
    }
    Near near{body, triangle, distance_m, {}, frame.R_solver_body * d.normal, 0, is_over};
    if (is_over) {
      const Wide height_m = d.normal.dot(frame.proxy_body - t.a.cast<Wide>());
      near.distance_m = std::abs(height_m);
      near.away = height_m < 0 ? Wide3(-near.normal) : near.normal;
      near.slope_error = kSlopeUlps * kWideEpsilon;
    } else {
      near.away = frame.R_solver_body * (from_nearest / distance_m);
      near.slope_error = kSlopeUlps * kWideEpsilon * (1 + arm_m / distance_m);
    }
    return near;
  }

  // The direction projected on the plane of motion; nothing if its part in the plane is negligible.
  std::optional<Wide3> in_motion_plane(const Wide3& direction) const {
    if (!motion_normal_) return direction;
    const Wide3 part = direction - direction.dot(*motion_normal_) * *motion_normal_;
    const Wide norm = part.norm();
    // A constraint along this part would bend the whole lag by less than rounding.
    if (norm * lag_m_ <= round_m_ / 2 || norm <= kDoubleEpsilon) return std::nullopt;
    return part / norm;
  }

  void find_near() {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const ExactJudge& judge = *bodies_[b].judge;
      const Vec3 p = frames_[b].proxy_body.cast<double>();
      const double reach = static_cast<double>(near_m_ + round_m_);
      for (std::size_t i = 0; i < judge.triangles().size(); ++i) {
        const ExactJudge::Bounds& box = judge.bounds(i);
        if (((box.low - p).array() > reach).any() || ((p - box.high).array() > reach).any()) {
          continue;
        }
        if (judge.certainly_farther(p, p, i, reach)) continue;
        const Near near = nearness(b, i);
        if (near.distance_m <= near_m_) near_.push_back(near);
      }
    }
    std::sort(near_.begin(), near_.end(),
              [](const Near& a, const Near& b) { return a.distance_m < b.distance_m; });
    for (const Near& near : near_) {
      if (near.distance_m > touch_m_) break;
      add_wall(near.away, near.slope_error, cone_);
      if (near.is_over) continue;
      turn_m_ = std::max(turn_m_, kTurnUlps * ulp_m_ / near.distance_m * lag_m_);
    }
  }

  // Adds a wall to the cone. False if the wall is already there or constrains nothing.
  bool add_wall(const Wide3& away, Wide slope_error, std::vector<Wall>& cone) const {
    const std::optional<Wide3> part = in_motion_plane(away);
    if (!part) return false;
    for (Wall& wall : cone) {
      if ((wall.away - *part).norm() > kSameNormal) continue;
      wall.slope_error = std::max(wall.slope_error, slope_error);
      return false;
    }
    cone.push_back({*part, slope_error});
    return true;
  }

  // The direction of steepest descent among those that approach no wall. The candidates are the
  // projections of the lag onto no plane, one plane, or the line of two planes; the longest
  // projection that approaches no wall wins. Nothing if no candidate is long enough.
  std::optional<Slide> steepest(const std::vector<Wall>& cone) const {
    std::optional<Slide> best;
    Wide best_m = 0;
    const auto offer = [&](const Wide3& part, std::size_t i, std::size_t j, Wide hold_m,
                           Wide error) {
      const Wide part_m = part.norm();
      if (!is_worth_it(part_m)) return;
      const Wide3 direction = part / part_m;
      // Several pairs of walls may share one line; each pair holds along it.
      if (best && (direction - best->direction).norm() <= kSameNormal + error) {
        best->hold_m = std::max(best->hold_m, hold_m);
        return;
      }
      if (part_m <= best_m) return;
      for (std::size_t k = 0; k < cone.size(); ++k) {
        if (k == i || k == j) continue;
        if (direction.dot(cone[k].away) < -(cone[k].slope_error + error)) return;
      }
      best_m = part_m;
      best = Slide{direction, hold_m};
    };
    const std::size_t none = cone.size();
    offer(lag_, none, none, 0, 0);
    if (best) return best;
    for (std::size_t i = 0; i < cone.size(); ++i) {
      const Wide press_m = -lag_.dot(cone[i].away);
      if (press_m <= 0) continue;
      offer(part_across(cone[i].away), i, i, held_by_one_m(press_m), kSlopeUlps * kWideEpsilon);
    }
    for (std::size_t i = 0; i < cone.size() && !motion_normal_; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Wide3 line = cone[i].away.cross(cone[j].away);
        const Wide sine = line.norm();
        if (sine <= kSameNormal) continue;
        const Wide3 unit = line / sine;
        offer(lag_.dot(unit) * unit, i, j, held_by_two_m(cone[i].away, cone[j].away),
              kSlopeUlps * kWideEpsilon / sine);
      }
    }
    return best;
  }

  // The part of the lag in a plane. The projection is applied twice, because the remaining part may
  // be as small as the rounding of the removed one.
  Wide3 part_across(const Wide3& normal) const {
    const Wide3 part = lag_ - lag_.dot(normal) * normal;
    return part - part.dot(normal) * normal;
  }

  // True if an escape along this part of the lag could gain more than the tolerance. Otherwise the
  // direction of the part is not meaningful.
  bool is_worth_it(Wide part_m) const { return part_m * part_m > tolerance_m_ * lag_m_; }

  Wide held_m(Wide press_m) const { return static_cast<Wide>(rest_.static_friction) * press_m; }

  // The part of the lag that friction holds along one plane.
  Wide held_by_one_m(Wide press_m) const { return is_held() ? held_m(press_m) + turn_m_ : 0; }

  // The part that friction holds along the line of two planes: each plane holds by the load it
  // bears.
  Wide held_by_two_m(const Wide3& n, const Wide3& m) const {
    if (rest_.static_friction == 0.0) return 0;
    const Wide cosine = n.dot(m);
    const Wide sine2 = n.cross(m).squaredNorm();  // 1 - cosine^2 loses all digits in a narrow slit
    const Wide on_n = -lag_.dot(n);
    const Wide on_m = -lag_.dot(m);
    const Wide part_n = std::max<Wide>(0, (on_n - cosine * on_m) / sine2);
    const Wide part_m = std::max<Wide>(0, (on_m - cosine * on_n) / sine2);
    const Wide across_m = std::hypot(on_n, (on_m - cosine * on_n) / std::sqrt(sine2));
    const Wide rounding_m = kTurnUlps * kDoubleEpsilon / std::sqrt(sine2) * lag_m_;
    return std::max(held_m(part_n + part_m), held_m(across_m) + rounding_m) + turn_m_;
  }

  // The length of a slide without obstacles. Friction holds at least by the part of the lag across
  // the slide, whichever planes bear it.
  Wide length_of(const Slide& slide) const {
    const Wide along_m = lag_.dot(slide.direction);
    const Wide across_m = (lag_ - along_m * slide.direction).norm();
    return along_m - std::max(slide.hold_m, held_m(across_m));
  }
  Wide gain_of(const Slide& slide, Wide length_m) const {
    // |lag|^2 - |lag - s u|^2 = s (2 lag . u - s)
    const Wide left_m = (lag_ - length_m * slide.direction).norm();
    return length_m * (2 * lag_.dot(slide.direction) - length_m) / (lag_m_ + left_m);
  }
  Wide gain_of(const std::optional<Slide>& slide) const {
    if (!slide || length_of(*slide) <= 0) return 0;
    return gain_of(*slide, length_of(*slide));
  }

  // The smallest distance that an escape may have from a triangle. null: the triangle is not near
  // the proxy.
  Wide allowed_m(const Near* near) const {
    return near && near->distance_m <= touch_m_ ? near->distance_m - round_m_ / 2 : touch_m_;
  }

  const Near* near_of(std::size_t body, std::size_t triangle) const {
    for (const Near& near : near_) {
      if (near.body == body && near.triangle == triangle) return &near;
    }
    return nullptr;
  }

  void stop_at(std::size_t body, std::size_t i, const Wide3& u, Wide keep_m, Stop& stop) const {
    const ExactJudge& judge = *bodies_[body].judge;
    const Corners& t = judge.triangles()[i];
    const ExactJudge::Directions& d = judge.directions(i);
    const Frame& frame = frames_[body];
    const std::array<const Vec3*, 3> corners = {&t.a, &t.b, &t.c};
    std::array<Wide3, 3> x;
    for (std::size_t e = 0; e < 3; ++e) x[e] = frame.proxy_body - corners[e]->cast<Wide>();
    const auto take = [&](Wide at, const Wide3& away) {
      if (at >= stop.length_m) return;
      stop.length_m = at;
      stop.away = frame.R_solver_body * away.normalized();
    };
    const Wide height_m = d.normal.dot(x[0]);
    const Wide climb = d.normal.dot(u);
    if (height_m * climb < 0 && std::abs(height_m) >= keep_m) {
      const Wide at = (std::abs(height_m) - keep_m) / std::abs(climb);
      bool is_over = true;
      for (std::size_t e = 0; e < 3; ++e) is_over &= d.outward[e].dot(x[e] + at * u) <= 0;
      if (is_over) take(at, height_m < 0 ? Wide3(-d.normal) : d.normal);
    }
    for (std::size_t e = 0; e < 3; ++e) {
      const Wide3& along = d.along[e];
      const Wide3 x_across = x[e] - along.dot(x[e]) * along;
      const Wide3 u_across = u - along.dot(u) * along;
      const Wide at =
          x_across.norm() >= keep_m ? entry_of_ball(x_across, u_across, keep_m) : kInfinity;
      if (at < kInfinity) {
        const Wide along_m = along.dot(x[e] + at * u);
        if (along_m >= 0 && along_m <= d.length_m[e]) take(at, x_across + at * u_across);
      }
      const Wide at_corner = entry_of_ball(x[e], u, keep_m);
      if (at_corner < kInfinity) take(at_corner, x[e] + at_corner * u);
    }
  }

  // Finds the first obstacle of an escape of this length.
  Stop first_stop(const Wide3& direction, Wide length_m) const {
    Stop stop;
    stop.length_m = length_m;
    for (const Near& near : near_) {
      if (near.distance_m > touch_m_) break;
      const Wide slope = direction.dot(near.away);
      if (slope < -near.slope_error && -slope * length_m > round_m_ / 2) return {0, near.away};
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const ExactJudge& judge = *bodies_[b].judge;
      const Wide3 u = frames_[b].R_solver_body.transpose() * direction;
      const Vec3 p = frames_[b].proxy_body.cast<double>();
      const Vec3 q = (frames_[b].proxy_body + length_m * u).cast<double>();
      const double reach = static_cast<double>(touch_m_ + round_m_);
      const Vec3 low = p.cwiseMin(q) - Vec3::Constant(reach);
      const Vec3 high = p.cwiseMax(q) + Vec3::Constant(reach);
      for (std::size_t i = 0; i < judge.triangles().size(); ++i) {
        const ExactJudge::Bounds& box = judge.bounds(i);
        if ((box.low.array() > high.array()).any() || (box.high.array() < low.array()).any()) {
          continue;
        }
        if (judge.certainly_farther(p, q, i, reach)) continue;
        stop_at(b, i, u, allowed_m(near_of(b, i)), stop);
      }
    }
    return stop;
  }

  std::optional<Escape> try_slide(const Slide& slide, const char* kind,
                                  Stop* stop_found = nullptr) {
    const Wide length_m = length_of(slide);
    if (length_m <= 0 || gain_of(slide, length_m) <= tolerance_m_) return std::nullopt;
    const Stop stop = first_stop(slide.direction, length_m);
    if (stop_found) *stop_found = stop;
    if (gain_of(slide, stop.length_m) <= tolerance_m_) return std::nullopt;
    // Also try to stop a little before the obstacle, where rounding is not decisive.
    for (const Wide less : {Wide(0), round_m_, stop.length_m / 1024}) {
      const Wide part = std::max<Wide>(0, stop.length_m - less);
      const Vec3 to = (proxy_ + part * slide.direction).cast<double>();
      const Wide gain_m = gain_to(to);
      if (gain_m > tolerance_m_ && is_way(to)) {
        return Escape{rest_.proxy, to, static_cast<double>(gain_m), kind};
      }
    }
    return std::nullopt;
  }

  Wide gain_to(const Vec3& to) const {
    const Wide3 left = rest_.goal.cast<Wide>() - to.cast<Wide>();
    const Wide3 from = rest_.goal.cast<Wide>() - proxy_;
    return from.norm() - left.norm();
  }

  // Checks the definition of an escape (rest_judge.h).
  bool is_way(const Vec3& to) const {
    if (motion_normal_ && std::abs(motion_normal_->dot(to.cast<Wide>() - proxy_)) > round_m_) {
      return false;
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const JudgedBody& body = bodies_[b];
      const ExactJudge& judge = *body.judge;
      const bool is_here = body.T_solver_body.rotation.coeffs() == Quat::Identity().coeffs() &&
                           body.T_solver_body.translation_m.isZero(0.0);
      const Vec3 p = is_here ? rest_.proxy : Vec3(frames_[b].proxy_body.cast<double>());
      const Vec3 q = is_here ? to : body.T_solver_body.inverse_point(to);
      const double reach = static_cast<double>(keep_m_);
      const Vec3 low = p.cwiseMin(q) - Vec3::Constant(reach);
      const Vec3 high = p.cwiseMax(q) + Vec3::Constant(reach);
      for (std::size_t i = 0; i < judge.triangles().size(); ++i) {
        const ExactJudge::Bounds& box = judge.bounds(i);
        if ((box.low.array() > high.array()).any() || (box.high.array() < low.array()).any()) {
          continue;
        }
        if (judge.certainly_farther(p, q, i, reach)) continue;
        const Wide least_m = std::min(nearness(b, i).distance_m, keep_m_) - round_m_;
        if (judge.distance_m(p, q, i) < least_m) return false;
      }
    }
    return true;
  }

  std::optional<Escape> descend() {
    std::vector<Wall> cone = cone_;
    std::optional<Slide> blocked;
    for (int bend = 0; bend < kMostBends; ++bend) {
      const std::optional<Slide> slide = steepest(cone);
      if (blocked && slide) {
        if (auto escape = try_tangent(*blocked, *slide)) return escape;
      }
      if (gain_of(slide) <= tolerance_m_) return std::nullopt;
      Stop stop;
      if (auto escape =
              try_slide(*slide, bend == 0 ? "steepest" : "steepest beside the obstacles", &stop)) {
        return escape;
      }
      if (!add_wall(stop.away, kSlopeUlps * kWideEpsilon, cone)) return std::nullopt;
      blocked = slide;
    }
    return std::nullopt;
  }

  // Under friction, only touched surfaces can be slid along, and they also hold the proxy.
  std::optional<Escape> slide_on_touched_surfaces() {
    if (cone_.empty()) return std::nullopt;
    const std::optional<Slide> slide = steepest(cone_);
    return slide ? try_slide(*slide, "along the touched surfaces") : std::nullopt;
  }

  // Searches between a blocked and a free direction for the one nearest to the blocked direction
  // that passes the obstacle.
  std::optional<Escape> try_tangent(const Slide& blocked, const Slide& free) {
    Wide low = 0;
    Wide high = 1;
    for (int i = 0; i < kBisections; ++i) {
      const Wide middle = (low + high) / 2;
      const Wide3 u = (1 - middle) * blocked.direction + middle * free.direction;
      if (u.norm() < kSameNormal) return std::nullopt;
      const Slide slide{u.normalized(), std::max(blocked.hold_m, free.hold_m)};
      const Wide length_m = length_of(slide);
      if (length_m <= 0 || gain_of(slide, length_m) <= tolerance_m_) {
        high = middle;
        continue;
      }
      if (auto escape = try_slide(slide, "past an obstacle")) return escape;
      low = middle;
    }
    return std::nullopt;
  }

  // The normals of the planes through the proxy that pass an edge at the smallest allowed distance.
  std::vector<Wide3> tangents_to_edges(const Near& near) const {
    const ExactJudge& judge = *bodies_[near.body].judge;
    const Corners& t = judge.triangles()[near.triangle];
    const ExactJudge::Directions& d = judge.directions(near.triangle);
    const Frame& frame = frames_[near.body];
    const std::array<const Vec3*, 3> corners = {&t.a, &t.b, &t.c};
    const Wide keep_m = allowed_m(&near) + round_m_ / 4;
    std::vector<Wide3> normals;
    for (std::size_t e = 0; e < 3; ++e) {
      const Wide3 to_proxy = frame.proxy_body - corners[e]->cast<Wide>();
      const Wide3 across = to_proxy - d.along[e].dot(to_proxy) * d.along[e];
      const Wide distance_m = across.norm();
      if (distance_m > near_m_ || distance_m <= keep_m) continue;
      const Wide cosine = keep_m / distance_m;
      const Wide sine = std::sqrt(1 - cosine * cosine);
      const Wide3 out = across / distance_m;
      const Wide3 beside = d.along[e].cross(out);
      normals.push_back(frame.R_solver_body * (cosine * out + sine * beside));
      normals.push_back(frame.R_solver_body * (cosine * out - sine * beside));
    }
    return normals;
  }

  // The corners near the proxy that are farther than the smallest allowed distance, as unit vectors
  // from the corner to the proxy, with the sine of the angle at which a segment just passes.
  struct FreeCorner {
    Wide3 out;
    Wide sine;
  };
  std::vector<FreeCorner> free_corners() const {
    std::vector<FreeCorner> corners;
    for (const Near& near : near_) {
      const Corners& t = bodies_[near.body].judge->triangles()[near.triangle];
      const Frame& frame = frames_[near.body];
      const Wide keep_m = allowed_m(&near) + round_m_ / 4;
      for (const Vec3* corner : {&t.a, &t.b, &t.c}) {
        const Wide3 to_proxy = frame.proxy_body - corner->cast<Wide>();
        const Wide distance_m = to_proxy.norm();
        if (distance_m > near_m_ || distance_m <= keep_m) continue;
        const Wide3 out = frame.R_solver_body * (to_proxy / distance_m);
        const auto is_same = [&](const FreeCorner& c) { return (c.out - out).norm() < 1e-9L; };
        if (std::any_of(corners.begin(), corners.end(), is_same)) continue;
        corners.push_back({out, keep_m / distance_m});
        if (corners.size() >= kMostCorners) return corners;
      }
    }
    return corners;
  }

  // The directions in the plane with this normal that just pass the corner.
  std::optional<Escape> slide_past(const FreeCorner& corner, const Wide3& normal) {
    const Wide3 out = corner.out - corner.out.dot(normal) * normal;
    const Wide cosine = std::sqrt(1 - corner.sine * corner.sine) / out.norm();
    if (!(cosine < 1)) return std::nullopt;
    const Wide sine = std::sqrt(1 - cosine * cosine);
    const Wide3 beside = normal.cross(out.normalized());
    for (const Wide side : {sine, -sine}) {
      const Wide3 u = side * beside - cosine * out.normalized();
      if (auto escape = try_slide({u.normalized()}, "past a corner")) return escape;
    }
    return std::nullopt;
  }

  std::optional<Escape> slide_past_corners(const std::vector<Wide3>& normals) {
    if (is_held()) return std::nullopt;
    for (const FreeCorner& corner : free_corners()) {
      if (motion_normal_) {
        if (auto escape = slide_past(corner, *motion_normal_)) return escape;
        continue;
      }
      const Wide3 across = lag_.cross(corner.out);
      if (across.norm() > 0) {
        if (auto escape = slide_past(corner, across.normalized())) return escape;
      }
      for (const Wide3& normal : normals) {
        if (auto escape = slide_past(corner, normal)) return escape;
      }
    }
    return std::nullopt;
  }

  std::optional<Escape> slide_on_planes() {
    std::vector<Wide3> normals;
    const auto add = [&](const Wide3& normal) {
      const std::optional<Wide3> part = in_motion_plane(normal);
      if (!part) return;
      for (const Wide3& other : normals) {
        if ((other - *part).norm() <= kSameNormal || (other + *part).norm() <= kSameNormal) return;
      }
      normals.push_back(*part);
    };
    for (const Near& near : near_) {
      if (is_held() && near.distance_m > touch_m_) break;
      if (!is_held() || radius_m_ == 0) add(near.normal);
      add(near.away);
      if (normals.size() >= kMostPlanes) break;
    }
    for (const Near& near : near_) {
      if (is_held() || normals.size() >= kMostPlanes) break;
      for (const Wide3& normal : tangents_to_edges(near)) add(normal);
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const Wide3 part = part_across(normals[i]);
      if (!is_worth_it(part.norm())) continue;
      const Slide slide{part.normalized(), held_by_one_m(std::abs(lag_.dot(normals[i])))};
      if (auto escape = try_slide(slide, "along a plane")) return escape;
    }
    for (std::size_t i = 0; i < normals.size() && !motion_normal_; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Wide3 line = normals[i].cross(normals[j]);
        if (line.norm() <= kSameNormal) continue;
        const Wide3 unit = line.normalized() * (line.dot(lag_) < 0 ? -1 : 1);
        // The sign of the lag determines the side from which each plane is pressed.
        const auto pressed = [&](const Wide3& n) { return lag_.dot(n) > 0 ? Wide3(-n) : n; };
        const Slide slide{unit, held_by_two_m(pressed(normals[i]), pressed(normals[j]))};
        if (auto escape = try_slide(slide, "along a line")) return escape;
      }
    }
    return slide_past_corners(normals);
  }

  std::span<const JudgedBody> bodies_;
  Rest rest_;
  Wide3 proxy_;
  Wide tolerance_m_;
  Wide radius_m_ = 0;
  Wide ulp_m_ = 0;
  Wide round_m_ = 0;
  Wide turn_m_ = 0;   // change of the lag by the rounding of directions
  Wide keep_m_ = 0;   // distance to keep from triangles: radius and stand-off
  Wide touch_m_ = 0;  // keep_m_ and the rounding of stops
  Wide near_m_ = 0;
  Wide3 lag_ = Wide3::Zero();  // from the proxy to the goal
  Wide lag_m_ = 0;
  std::optional<Wide3> motion_normal_;
  std::vector<Frame> frames_;
  std::vector<Near> near_;  // nearest first
  std::vector<Wall> cone_;  // of the touched triangles
};

}  // namespace

std::string hex(const Vec3& p) {
  char text[128];
  std::snprintf(text, sizeof text, "{%a, %a, %a}", p.x(), p.y(), p.z());
  return text;
}

std::string to_text(const Escape& escape) {
  char text[160];
  std::snprintf(text, sizeof text, "%s, %.4g m long, ends %.4g m nearer to the goal: from ",
                escape.kind, (escape.to - escape.from).norm(), escape.gain_m);
  return text + hex(escape.from) + " to " + hex(escape.to);
}

RestJudge::RestJudge(double size_m, double radius_m, double stand_off_m)
    : size_m_(std::max(size_m, radius_m)), radius_m_(radius_m), stand_off_m_(stand_off_m) {}

Verdict RestJudge::judged(std::span<const JudgedBody> bodies, const Rest& rest) const {
  return Search(bodies, rest, size_m_, radius_m_, stand_off_m_, tolerance_m()).judge();
}

std::optional<Escape> RestJudge::escape_from(const ExactJudge& judge, const Rest& rest) const {
  const JudgedBody body{&judge, {}};
  return escape_from(std::span(&body, 1), rest);
}

}  // namespace palpate::test
