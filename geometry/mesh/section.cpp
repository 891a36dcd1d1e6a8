#include "geometry/mesh/section.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "geometry/mesh/collinear_runs.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNoCut = 0xffffffffu;
constexpr double kMergeRelativeToCoordinates = 32 * 0x1p-53;

using EdgeKey = std::uint64_t;  // its two vertices, the lower one in the high half

EdgeKey edge_key(std::uint32_t u, std::uint32_t v) {
  return static_cast<EdgeKey>(std::min(u, v)) << 32 | std::max(u, v);
}

// The segment where the plane cuts one triangle, directed with the triangle's back on its left. In
// the triangle's orientation, `from` is the edge that crosses the plane downwards and `to` the edge
// that crosses it upwards.
struct Cut {
  std::uint32_t triangle;
  EdgeKey from;
  EdgeKey to;
};

// An end of a segment, on an edge.
struct CutEnd {
  EdgeKey edge;
  std::uint32_t cut;
  bool leaves;  // the segment starts here
  double angle_rad = 0.0;
};

class Section {
 public:
  Section(const std::vector<Vec3>& positions_m, const std::vector<Triangle>& triangles,
          const Vec3& plane_normal, double plane_offset_m)
      : positions_m_(positions_m), triangles_(triangles), normal_(plane_normal) {
    heights_m_.reserve(positions_m.size());
    for (const Vec3& p : positions_m) heights_m_.push_back(normal_.dot(p) - plane_offset_m);
  }

  std::vector<Polyline> curves() {
    cut_triangles();
    link_cuts();
    std::vector<Polyline> curves;
    std::vector<bool> done(cuts_.size(), false);
    for (std::uint32_t c = 0; c < cuts_.size(); ++c) {
      if (!has_previous_[c]) add_curve(c, false, done, curves);
    }
    for (std::uint32_t c = 0; c < cuts_.size(); ++c) {
      if (!done[c]) add_curve(c, true, done, curves);
    }
    return curves;
  }

 private:
  // Zero counts as above, as if the plane were moved down by an infinitesimal amount (simulation of
  // simplicity, Edelsbrunner and Muecke 1990), so that no vertex lies in the plane.
  bool above(std::uint32_t v) const { return heights_m_[v] >= 0.0; }

  void cut_triangles() {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Triangle& v = triangles_[t];
      assert(std::max({v[0], v[1], v[2]}) < positions_m_.size());
      if (above(v[0]) == above(v[1]) && above(v[1]) == above(v[2])) continue;
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
      Cut cut{static_cast<std::uint32_t>(t), 0, 0};
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t from = v[e];
        const std::uint32_t to = v[(e + 1) % 3];
        if (above(from) && !above(to)) cut.from = edge_key(from, to);
        if (!above(from) && above(to)) cut.to = edge_key(from, to);
        largest_m_ = std::max(largest_m_, positions_m_[from].cwiseAbs().maxCoeff());
      }
      cuts_.push_back(cut);
    }
  }

  // Links each segment to the segment that continues it.
  void link_cuts() {
    next_.assign(cuts_.size(), kNoCut);
    has_previous_.assign(cuts_.size(), false);
    std::vector<CutEnd> ends;
    ends.reserve(2 * cuts_.size());
    for (std::uint32_t c = 0; c < cuts_.size(); ++c) {
      ends.push_back({cuts_[c].from, c, true});
      ends.push_back({cuts_[c].to, c, false});
    }
    std::sort(ends.begin(), ends.end(), [](const CutEnd& a, const CutEnd& b) {
      return a.edge != b.edge ? a.edge < b.edge : a.cut < b.cut;
    });
    for (std::size_t begin = 0; begin < ends.size();) {
      std::size_t end = begin + 1;
      while (end < ends.size() && ends[end].edge == ends[begin].edge) ++end;
      const std::size_t count = end - begin;
      if (count == 2 && ends[begin].leaves != ends[begin + 1].leaves) {
        const std::size_t leaving = ends[begin].leaves ? begin : begin + 1;
        link(ends[leaving == begin ? begin + 1 : begin].cut, ends[leaving].cut);
      } else if (count > 2) {
        link_around_edge(ends.begin() + static_cast<std::ptrdiff_t>(begin),
                         ends.begin() + static_cast<std::ptrdiff_t>(end));
      }
      begin = end;
    }
  }

  void link(std::uint32_t arriving, std::uint32_t leaving) {
    next_[arriving] = leaving;
    has_previous_[leaving] = true;
  }

  // Material fills the angle from a leaving segment, counter-clockwise, to an arriving one. Pairs
  // the segments like brackets on a circle, so that an arriving segment turns left around its own
  // material.
  template <typename Iterator>
  void link_around_edge(Iterator begin, Iterator end) {
    const Vec3 u = normal_.unitOrthogonal();
    const Vec3 v = normal_.cross(u);
    for (Iterator it = begin; it != end; ++it) {
      const Vec3 along = normal_.cross(front_of(cuts_[it->cut].triangle));
      const Vec3 away = it->leaves ? along : Vec3(-along);
      it->angle_rad = std::atan2(away.dot(v), away.dot(u));
    }
    std::sort(begin, end, [](const CutEnd& a, const CutEnd& b) {
      if (a.angle_rad != b.angle_rad) return a.angle_rad < b.angle_rad;
      return a.leaves != b.leaves ? a.leaves : a.cut < b.cut;
    });
    std::vector<std::uint32_t> open;
    for (int round = 0; round < 2; ++round) {
      for (Iterator it = begin; it != end; ++it) {
        if (it->leaves) {
          if (round == 0) open.push_back(it->cut);
        } else if (!open.empty() && next_[it->cut] == kNoCut) {
          link(it->cut, open.back());
          open.pop_back();
        }
      }
    }
  }

  Vec3 front_of(std::uint32_t triangle) const {
    const Triangle& t = triangles_[triangle];
    const Vec3& origin_m = positions_m_[t[0]];
    return (positions_m_[t[1]] - origin_m).cross(positions_m_[t[2]] - origin_m).stableNormalized();
  }

  // Computed from the edge's vertex above the plane, so that both triangles at the edge have the
  // same point, and a vertex in the plane is the exact result.
  Vec3 crossing_m(EdgeKey edge) const {
    auto upper = static_cast<std::uint32_t>(edge >> 32);
    auto lower = static_cast<std::uint32_t>(edge);
    if (!above(upper)) std::swap(upper, lower);
    const double share = heights_m_[upper] / (heights_m_[upper] - heights_m_[lower]);
    return positions_m_[upper] + share * (positions_m_[lower] - positions_m_[upper]);
  }

  void add_curve(std::uint32_t first, bool closed, std::vector<bool>& done,
                 std::vector<Polyline>& curves) const {
    std::vector<Vec3> points_m;
    std::uint32_t last = first;
    for (std::uint32_t c = first; c != kNoCut && !done[c]; c = next_[c]) {
      points_m.push_back(crossing_m(cuts_[c].from));
      done[c] = true;
      last = c;
    }
    if (!closed) points_m.push_back(crossing_m(cuts_[last].to));
    points_m = without_collinear_points(std::move(points_m), closed, normal_,
                                        kMergeRelativeToCoordinates * largest_m_);
    if (points_m.size() > 1) curves.push_back({std::move(points_m), closed});
  }

  const std::vector<Vec3>& positions_m_;
  const std::vector<Triangle>& triangles_;
  Vec3 normal_;
  std::vector<double> heights_m_;  // of each position above the plane
  double largest_m_ = 0.0;         // coordinate of a triangle that is cut
  std::vector<Cut> cuts_;
  std::vector<std::uint32_t> next_;  // per cut: the cut that continues it
  std::vector<bool> has_previous_;
};

}  // namespace

double length_m(const Polyline& polyline) {
  const std::vector<Vec3>& points_m = polyline.points_m;
  double sum_m = 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i) {
    sum_m += (points_m[i] - points_m[i - 1]).norm();
  }
  if (polyline.closed) sum_m += (points_m.front() - points_m.back()).norm();
  return sum_m;
}

std::vector<Polyline> plane_section(const std::vector<Vec3>& positions_m,
                                    const std::vector<Triangle>& triangles,
                                    const Vec3& plane_normal, double plane_offset_m) {
  std::vector<Polyline> curves =
      Section(positions_m, triangles, plane_normal, plane_offset_m).curves();
  std::stable_sort(curves.begin(), curves.end(),
                   [](const Polyline& a, const Polyline& b) { return length_m(a) > length_m(b); });
  return curves;
}

}  // namespace palpate
