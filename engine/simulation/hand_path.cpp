#include "engine/simulation/hand_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

// A point nearer to the previous tested point than this share of the tolerance is not tested
// separately, which bounds the cost for fine meshes.
constexpr double kFinest = 1.0 / 16;

double distance_to_segment_m(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - part * along).norm();
}

class Simplifier {
 public:
  Simplifier(const HandPath& path, double tolerance_m) : path_(path), tolerance_m_(tolerance_m) {}

  HandPath run() {
    HandPath simple;
    std::vector<std::size_t> kept{0};
    const std::size_t last = path_.points.size() - 1;
    while (kept.back() < last) kept.push_back(end_of_leg(kept.back()));
    for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
      HandPath::Point point = path_.points[kept[k]];
      point.inward = mean_inward(kept[k], kept[k + 1]);
      simple.points.push_back(point);
    }
    simple.points.push_back(path_.points[last]);
    simple.points.back().inward = simple.points[simple.points.size() - 2].inward;
    for (std::size_t k = 1; k + 1 < kept.size(); ++k) {
      simple.points[k].fold_rad = fold_rad(simple, k, kept[k]);
    }
    return simple;
  }

 private:
  // The farthest point that a single leg from `from` can reach.
  std::size_t end_of_leg(std::size_t from) const {
    const auto& points = path_.points;
    const Vec3& start = points[from].p_m;
    std::size_t end = from + 1;
    std::vector<std::size_t> between;
    Vec3 tested_m = start;
    while (end + 1 < points.size() && !points[end].is_turn) {
      if ((points[end].p_m - tested_m).norm() > kFinest * tolerance_m_) {
        between.push_back(end);
        tested_m = points[end].p_m;
      }
      const Vec3& next = points[end + 1].p_m;
      const bool turns_back = (next - points[end].p_m).dot(points[end].p_m - start) < 0.0;
      const bool is_near = std::all_of(between.begin(), between.end(), [&](std::size_t i) {
        return distance_to_segment_m(points[i].p_m, start, next) <= (1.0 - kFinest) * tolerance_m_;
      });
      if (!is_near || (turns_back && (points[end].p_m - start).norm() > tolerance_m_)) break;
      ++end;
    }
    return end;
  }

  Vec3 mean_inward(std::size_t from, std::size_t to) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = from; i < to; ++i) {
      sum += (path_.points[i + 1].p_m - path_.points[i].p_m).norm() * path_.points[i].inward;
    }
    return sum.isZero(0.0) ? path_.points[from].inward : Vec3(sum.normalized());
  }

  double fold_rad(const HandPath& simple, std::size_t k, std::size_t in_path) const {
    const Vec3& before = simple.points[k - 1].inward;
    const Vec3& after = simple.points[k].inward;
    const double angle_rad = std::atan2(before.cross(after).norm(), before.dot(after));
    const Vec3 in = (simple.points[k].p_m - simple.points[k - 1].p_m).normalized();
    const Vec3 out = (simple.points[k + 1].p_m - simple.points[k].p_m).normalized();
    double sign = before.dot(out) - after.dot(in);
    if (angle_rad > kTurnsBackRad) sign = fold_near_rad(in_path);
    return std::copysign(angle_rad, sign);
  }

  // The sum of the fold angles of all edges near the point where the legs meet.
  double fold_near_rad(std::size_t i) const {
    const auto& points = path_.points;
    const auto is_near = [&](std::size_t k) {
      return (points[k].p_m - points[i].p_m).norm() <= 2.0 * tolerance_m_;
    };
    double sum_rad = points[i].fold_rad;
    for (std::size_t k = i; k-- > 0 && is_near(k);) sum_rad += points[k].fold_rad;
    for (std::size_t k = i + 1; k < points.size() && is_near(k); ++k) sum_rad += points[k].fold_rad;
    return sum_rad;
  }

  const HandPath& path_;
  double tolerance_m_;
};

}  // namespace

std::vector<double> HandPath::lengths_m() const {
  std::vector<double> lengths_m{0.0};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    lengths_m.push_back(lengths_m.back() + (points[i + 1].p_m - points[i].p_m).norm());
  }
  return lengths_m;
}

std::size_t leg_at(const std::vector<double>& lengths_m, double along_m) {
  const auto after = std::upper_bound(lengths_m.begin() + 1, lengths_m.end() - 1, along_m);
  return static_cast<std::size_t>(after - lengths_m.begin()) - 1;
}

Vec3 point_along(const HandPath& path, const std::vector<double>& lengths_m, double along_m) {
  const std::size_t leg = leg_at(lengths_m, along_m);
  const Vec3& from = path.points[leg].p_m;
  return from + (along_m - lengths_m[leg]) * (path.points[leg + 1].p_m - from).normalized();
}

double nearest_along_m(const HandPath& path, const std::vector<double>& lengths_m,
                       const Vec3& p_m) {
  double nearest_m = 0.0;
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const double length_m = lengths_m[i + 1] - lengths_m[i];
    if (length_m == 0.0) continue;
    const Vec3& from = path.points[i].p_m;
    const Vec3 tangent = (path.points[i + 1].p_m - from) / length_m;
    const double at_m = std::clamp((p_m - from).dot(tangent), 0.0, length_m);
    const double distance_m = (p_m - from - at_m * tangent).norm();
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    nearest_m = lengths_m[i] + at_m;
  }
  return nearest_m;
}

HandPath other_side(HandPath path) {
  for (HandPath::Point& point : path.points) {
    point.inward = -point.inward;
    point.fold_rad = -point.fold_rad;
  }
  return path;
}

HandPath repeated(const HandPath& path, int laps) {
  HandPath all = path;
  for (int lap = 1; lap < laps; ++lap) {
    all.points.pop_back();  // the first point of the next lap
    all.points.insert(all.points.end(), path.points.begin(), path.points.end());
  }
  return all;
}

HandPath to_and_fro(const HandPath& path, int laps) {
  const std::size_t last = path.points.size() - 1;
  HandPath back;
  for (std::size_t i = last + 1; i-- > 0;) {
    HandPath::Point point = path.points[i];
    point.inward = path.points[i > 0 ? i - 1 : 0].inward;
    point.is_turn = point.is_turn || i == last;
    back.points.push_back(point);
  }
  HandPath forth = path;
  forth.points.front().is_turn = true;
  HandPath all = path;
  for (int lap = 1; lap < laps; ++lap) {
    const HandPath& next = lap % 2 == 1 ? back : forth;
    all.points.pop_back();
    all.points.insert(all.points.end(), next.points.begin(), next.points.end());
  }
  return all;
}

HandPath simplified(const HandPath& path, double tolerance_m) {
  return path.points.size() < 3 ? path : Simplifier(path, tolerance_m).run();
}

std::vector<Vec3> places_along(const HandPath& path, double spacing_m) {
  const std::vector<double> lengths_m = path.lengths_m();
  const double whole_m = lengths_m.back();
  const double count = std::max(1.0, std::ceil(whole_m / spacing_m));
  std::vector<Vec3> places;
  std::size_t leg = 0;
  for (double n = 0.0; n <= count; ++n) {
    const double at_m = n / count * whole_m;
    while (leg + 2 < lengths_m.size() && lengths_m[leg + 1] < at_m) ++leg;
    const double leg_m = lengths_m[leg + 1] - lengths_m[leg];
    const double part = leg_m > 0.0 ? std::min(1.0, (at_m - lengths_m[leg]) / leg_m) : 0.0;
    const Vec3& from = path.points[leg].p_m;
    places.push_back(from + part * (path.points[leg + 1].p_m - from));
  }
  return places;
}

}  // namespace palpate
