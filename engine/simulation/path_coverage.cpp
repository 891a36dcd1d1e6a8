#include "engine/simulation/path_coverage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace palpate {
namespace {

Vec3 middle_of(const std::vector<Vec3>& points_m) {
  Box box{points_m.front(), points_m.front()};
  for (const Vec3& p : points_m) box = box.united({p, p});
  return 0.5 * box.low + 0.5 * box.high;
}

std::vector<Box> boxes_of_segments(const std::vector<Vec3>& curve_m, const Vec3& origin_m) {
  std::vector<Box> boxes;
  for (std::size_t i = 0; i + 1 < curve_m.size(); ++i) {
    const Vec3 from = curve_m[i] - origin_m;
    const Vec3 to = curve_m[i + 1] - origin_m;
    boxes.push_back({from.cwiseMin(to), from.cwiseMax(to)});
  }
  return boxes;
}

}  // namespace

CurveCoverage::CurveCoverage(std::vector<Vec3> curve_m, double near_m)
    : curve_m_(std::move(curve_m)),
      near_m_(near_m),
      middle_m_(curve_m_.empty() ? Vec3(Vec3::Zero()) : middle_of(curve_m_)),
      segments_(boxes_of_segments(curve_m_, middle_m_), 0.0),
      covered_(curve_m_.empty() ? 0 : curve_m_.size() - 1) {}

// Covers the part of each segment inside the ball about a point: the chord of the segment's line,
// clipped to the segment.
void CurveCoverage::add(const Vec3& p) {
  if (covered_.empty()) return;
  struct State {
    CurveCoverage* coverage;
    const Vec3* p;
  } state{this, &p};
  segments_.visit_near(
      p - middle_m_, near_m_, NearSearch::kWithEmbree,
      [](void* s, std::uint32_t segment) {
        static_cast<State*>(s)->coverage->cover_near(segment, *static_cast<State*>(s)->p);
        return true;
      },
      &state);
}

void CurveCoverage::cover_near(std::size_t segment, const Vec3& p) {
  const double length_m = segment_length_m(segment);
  if (length_m == 0.0) return;
  const Vec3 direction = (curve_m_[segment + 1] - curve_m_[segment]) / length_m;
  const Vec3 to_p = p - curve_m_[segment];
  const double foot_m = to_p.dot(direction);
  const double half_chord2_m2 = near_m_ * near_m_ - (to_p - foot_m * direction).squaredNorm();
  if (half_chord2_m2 < 0.0) return;
  const double half_chord_m = std::sqrt(half_chord2_m2);
  const Interval part{std::max(0.0, foot_m - half_chord_m),
                      std::min(length_m, foot_m + half_chord_m)};
  if (part.begin_m < part.end_m) unite(part, covered_[segment]);
}

// Replaces all intervals that the part overlaps by their union.
void CurveCoverage::unite(Interval part, std::vector<Interval>& covered) {
  const auto first = std::partition_point(
      covered.begin(), covered.end(), [&](const Interval& i) { return i.end_m < part.begin_m; });
  auto last = first;
  for (; last != covered.end() && last->begin_m <= part.end_m; ++last) {
    part.begin_m = std::min(part.begin_m, last->begin_m);
    part.end_m = std::max(part.end_m, last->end_m);
  }
  covered.insert(covered.erase(first, last), part);
}

double CurveCoverage::share() const {
  double covered_m = 0.0;
  double length_m = 0.0;
  for (std::size_t i = 0; i < covered_.size(); ++i) {
    length_m += segment_length_m(i);
    for (const Interval& part : covered_[i]) covered_m += part.end_m - part.begin_m;
  }
  return length_m > 0.0 ? std::min(1.0, covered_m / length_m) : 0.0;
}

}  // namespace palpate
