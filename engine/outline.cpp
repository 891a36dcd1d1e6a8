#include "engine/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

using Point = Eigen::Vector2d;

// Places that are looked at: farther apart than small where there would be more.
constexpr double kMostPlaces = 20000.0;

// How far in front of a curve it is asked for other solids, in what is small: far beyond rounding.
constexpr double kJustInFront = 1e-3;

// Halvings of the distance of two places, one free and one hidden.
constexpr int kHalvings = 40;

// A curve in the plane, by the way along it.
class PlaneCurve {
 public:
  PlaneCurve(const Polyline& curve, const Vec3& u, const Vec3& v) : curve_(&curve) {
    std::vector<Vec3> points_m = curve.points_m;
    if (curve.closed) points_m.push_back(points_m.front());
    for (const Vec3& p : points_m) {
      points_.emplace_back(p.dot(u), p.dot(v));
      low_ = low_.cwiseMin(points_.back());
      high_ = high_.cwiseMax(points_.back());
      const bool is_first = points_.size() == 1;
      length_m_.push_back(is_first ? 0.0
                                   : length_m_.back() +
                                         (points_.back() - points_[points_.size() - 2]).norm());
    }
  }

  bool is_closed() const { return curve_->closed; }
  const Polyline& curve() const { return *curve_; }
  double length_m() const { return length_m_.back(); }

  // How often it goes round a point. An open one goes straight back to its beginning: what a shell
  // has behind it is hidden, what it has in front is not, whichever way it is bent.
  int winding(const Point& p) const {
    if ((p.array() < low_.array()).any() || (p.array() > high_.array()).any()) return 0;
    int winding = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point a = points_[i] - p;
      const Point b = points_[(i + 1) % points_.size()] - p;
      if ((a.y() <= 0.0) == (b.y() <= 0.0)) continue;
      const double side = a.x() * b.y() - a.y() * b.x();
      if (b.y() > 0.0 && side > 0.0) ++winding;
      if (b.y() <= 0.0 && side < 0.0) --winding;
    }
    return winding;
  }

  // To the right of a place.
  Point in_front(double along_m, double distance_m) const {
    const std::size_t i = segment(along_m);
    const Point way = (points_[i + 1] - points_[i]).normalized();
    return points_[i] + (along_m - length_m_[i]) * way + distance_m * Point(way.y(), -way.x());
  }

  // From one place to another; beyond the end of a closed one from its beginning again.
  std::vector<Vec3> part(double from_m, double to_m) const {
    std::vector<Vec3> part{place(from_m)};
    const std::size_t segments = points_.size() - 1;
    for (std::size_t lap = 0; lap < 2; ++lap) {
      for (std::size_t i = 1; i <= segments; ++i) {
        const double at_m = length_m_[i] + static_cast<double>(lap) * length_m();
        if (at_m > from_m && at_m < to_m) part.push_back(corner(i));
      }
    }
    part.push_back(place(to_m));
    return part;
  }

 private:
  std::size_t segment(double along_m) const {
    const auto after = std::upper_bound(length_m_.begin() + 1, length_m_.end() - 1, along_m);
    return static_cast<std::size_t>(after - length_m_.begin()) - 1;
  }
  Vec3 corner(std::size_t i) const { return curve_->points_m[i % curve_->points_m.size()]; }
  Vec3 place(double along_m) const {
    const double on_m = along_m > length_m() ? along_m - length_m() : along_m;
    const std::size_t i = segment(on_m);
    const double segment_m = length_m_[i + 1] - length_m_[i];
    const double part = segment_m > 0.0 ? (on_m - length_m_[i]) / segment_m : 0.0;
    return corner(i) + part * (corner(i + 1) - corner(i));
  }

  const Polyline* curve_;
  std::vector<Point> points_;  // closed: the first one again at the end
  std::vector<double> length_m_;
  Point low_ = Point::Constant(std::numeric_limits<double>::infinity());
  Point high_ = -low_;
};

class OutlineFinder {
 public:
  OutlineFinder(const std::vector<Polyline>& curves, const Vec3& plane_normal, double small_m)
      : small_m_(small_m) {
    const Vec3 u = plane_normal.unitOrthogonal();
    const Vec3 v = plane_normal.cross(u);
    double length_m = 0.0;
    for (const Polyline& curve : curves) {
      curves_.emplace_back(curve, u, v);
      length_m += curves_.back().length_m();
    }
    step_m_ = std::max(small_m, length_m / kMostPlaces);
  }

  std::vector<Outline> run() {
    for (const PlaneCurve& curve : curves_) take_free_parts(curve);
    join();
    const auto length = [](const Outline& o) { return length_m(o.curve); };
    std::stable_sort(found_.begin(), found_.end(),
                     [&](const Outline& a, const Outline& b) { return length(a) > length(b); });
    return std::move(found_);
  }

 private:
  bool is_free(const PlaneCurve& curve, double along_m) const {
    const double on_m = along_m > curve.length_m() ? along_m - curve.length_m() : along_m;
    const Point p = curve.in_front(on_m, kJustInFront * small_m_);
    int winding = 0;
    for (const PlaneCurve& other : curves_) winding += other.winding(p);
    return winding <= 0;
  }

  void take_free_parts(const PlaneCurve& curve) {
    const double whole_m = curve.length_m();
    const auto steps = static_cast<std::size_t>(std::max(1.0, std::ceil(whole_m / step_m_)));
    const double step_m = whole_m / static_cast<double>(steps);
    std::vector<bool> free;
    for (std::size_t i = 0; i < steps; ++i) {
      free.push_back(is_free(curve, (static_cast<double>(i) + 0.5) * step_m));
    }
    const auto hidden = std::find(free.begin(), free.end(), false);
    if (hidden == free.end()) {
      (curve.is_closed() ? found_ : parts_).push_back({curve.curve(), !curve.is_closed()});
      return;
    }
    // Around a closed one from a place that is hidden; along an open one from its beginning.
    const auto first = curve.is_closed() ? static_cast<std::size_t>(hidden - free.begin()) : 0;
    const auto middle_m = [&](std::size_t n) {
      return (static_cast<double>(first + n) + 0.5) * step_m;
    };
    for (std::size_t n = 0; n < steps; ++n) {
      if (!free[(first + n) % steps]) continue;
      std::size_t last = n;
      while (last + 1 < steps && free[(first + last + 1) % steps]) ++last;
      const double from_m = n == 0 ? 0.0 : border(curve, middle_m(n), middle_m(n - 1));
      const bool is_end = !curve.is_closed() && last + 1 == steps;
      const double to_m = is_end ? whole_m : border(curve, middle_m(last), middle_m(last + 1));
      if (to_m - from_m > small_m_) {
        parts_.push_back({{curve.part(from_m, to_m), false}, !curve.is_closed()});
      }
      n = last;
    }
  }

  // Between a place that is free and one that is hidden.
  double border(const PlaneCurve& curve, double free_m, double hidden_m) const {
    for (int i = 0; i < kHalvings; ++i) {
      const double middle_m = 0.5 * (free_m + hidden_m);
      (is_free(curve, middle_m) ? free_m : hidden_m) = middle_m;
    }
    return free_m;
  }

  // Where one part ends another begins, if the one entered the other there.
  void join() {
    std::vector<bool> is_taken(parts_.size(), false);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (is_taken[i]) continue;
      is_taken[i] = true;
      Outline whole = parts_[i];
      auto& points_m = whole.curve.points_m;
      bool is_joined = false;
      for (bool grows = true; grows;) {
        grows = false;
        for (std::size_t k = 0; k < parts_.size(); ++k) {
          if (is_taken[k]) continue;
          const auto& others_m = parts_[k].curve.points_m;
          const bool is_after = (others_m.front() - points_m.back()).norm() <= small_m_;
          const bool is_before = (others_m.back() - points_m.front()).norm() <= small_m_;
          if (!is_after && !is_before) continue;
          if (is_after) points_m.insert(points_m.end(), others_m.begin() + 1, others_m.end());
          if (!is_after) points_m.insert(points_m.begin(), others_m.begin(), others_m.end() - 1);
          whole.has_two_sides = whole.has_two_sides && parts_[k].has_two_sides;
          is_taken[k] = grows = is_joined = true;
        }
      }
      if (is_joined && points_m.size() > 3 &&
          (points_m.front() - points_m.back()).norm() <= small_m_) {
        points_m.pop_back();
        whole.curve.closed = true;
      }
      found_.push_back(std::move(whole));
    }
  }

  double small_m_;
  double step_m_ = 0.0;
  std::vector<PlaneCurve> curves_;
  std::vector<Outline> parts_;
  std::vector<Outline> found_;
};

}  // namespace

std::vector<Outline> outlines(const std::vector<Polyline>& curves, const Vec3& plane_normal,
                              double small_m) {
  return OutlineFinder(curves, plane_normal, small_m).run();
}

}  // namespace palpate
