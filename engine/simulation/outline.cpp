#include "engine/simulation/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "engine/simulation/free_chains.h"
#include "geometry/mesh/collinear_runs.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNoChain = 0xffffffffu;

// Each end is compared with at most this many beginnings on either side of it in x, which keeps the
// search O(n) for many loose ends.
constexpr std::size_t kMostGapsCompared = 64;

// Joins open outlines whose ends are near each other.
class GapJoiner {
 public:
  GapJoiner(std::vector<Outline> open, double small_m)
      : open_(std::move(open)),
        small_m_(small_m),
        next_(open_.size(), kNoChain),
        has_previous_(open_.size(), false) {}

  std::vector<Outline> run() {
    for (const Gap& gap : gaps()) {
      if (next_[gap.from] != kNoChain || has_previous_[gap.to]) continue;
      next_[gap.from] = gap.to;
      has_previous_[gap.to] = true;
    }
    std::vector<Outline> joined;
    std::vector<bool> is_done(open_.size(), false);
    for (const bool closed : {false, true}) {
      for (std::uint32_t i = 0; i < open_.size(); ++i) {
        if (!is_done[i] && (closed || !has_previous_[i])) {
          joined.push_back(joined_from(i, closed, is_done));
        }
      }
    }
    return joined;
  }

 private:
  struct Gap {
    double width_m;
    std::uint32_t from, to;
  };
  const Vec3& begin_of(std::uint32_t i) const { return open_[i].curve.points_m.front(); }
  const Vec3& end_of(std::uint32_t i) const { return open_[i].curve.points_m.back(); }

  // All gaps up to small_m, narrowest first.
  std::vector<Gap> gaps() const {
    std::vector<std::uint32_t> by_x(open_.size());
    for (std::uint32_t i = 0; i < by_x.size(); ++i) by_x[i] = i;
    std::stable_sort(by_x.begin(), by_x.end(), [&](std::uint32_t a, std::uint32_t b) {
      return begin_of(a).x() < begin_of(b).x();
    });
    std::vector<Gap> gaps;
    for (std::uint32_t i = 0; i < open_.size(); ++i) {
      const Vec3& end = end_of(i);
      const auto from_here =
          std::lower_bound(by_x.begin(), by_x.end(), end.x(),
                           [&](std::uint32_t k, double x) { return begin_of(k).x() < x; });
      const auto here = static_cast<std::size_t>(from_here - by_x.begin());
      const std::size_t first = here - std::min(here, kMostGapsCompared);
      const std::size_t last = std::min(by_x.size(), here + kMostGapsCompared);
      for (std::size_t n = first; n < last; ++n) {
        const double width_m = (begin_of(by_x[n]) - end).norm();
        // A single outline is not closed on itself: the size of the region that it would enclose is
        // unknown.
        if (by_x[n] != i && width_m <= small_m_) gaps.push_back({width_m, i, by_x[n]});
      }
    }
    std::stable_sort(gaps.begin(), gaps.end(),
                     [](const Gap& a, const Gap& b) { return a.width_m < b.width_m; });
    return gaps;
  }

  Outline joined_from(std::uint32_t first, bool closed, std::vector<bool>& is_done) const {
    Outline whole{{{}, closed}, true};
    std::vector<Vec3>& points_m = whole.curve.points_m;
    for (std::uint32_t i = first; i != kNoChain && !is_done[i]; i = next_[i]) {
      is_done[i] = true;
      const Outline& part = open_[i];
      points_m.insert(points_m.end(), part.curve.points_m.begin(), part.curve.points_m.end());
      whole.has_two_sides = whole.has_two_sides && part.has_two_sides;
    }
    return whole;
  }

  std::vector<Outline> open_;
  double small_m_;
  std::vector<std::uint32_t> next_;
  std::vector<bool> has_previous_;
};

// Leaves out points at which the outline continues straight past another curve.
Outline outline_of(const FreeChain& chain, const Vec3& plane_normal, double merged_m) {
  Outline outline{{{}, chain.closed}, chain.has_two_sides};
  bool meets_another = false;
  for (const ChainPoint& point : chain.points) {
    outline.curve.points_m.push_back(point.p_m);
    meets_another = meets_another || point.is_junction;
  }
  if (meets_another) {
    outline.curve.points_m = without_collinear_points(std::move(outline.curve.points_m),
                                                      chain.closed, plane_normal, merged_m);
  }
  return outline;
}

}  // namespace

std::optional<std::vector<Outline>> outlines(const std::vector<Polyline>& curves,
                                             const Vec3& plane_normal, double small_m) {
  const FreeChains free = free_chains(curves, plane_normal);
  if (free.gave_up) return std::nullopt;
  std::vector<Outline> found;
  std::vector<Outline> open;
  for (const FreeChain& chain : free.chains) {
    Outline outline = outline_of(chain, plane_normal, free.merged_m);
    if (outline.curve.points_m.size() < 2) continue;
    (chain.closed ? found : open).push_back(std::move(outline));
  }
  for (Outline& outline : GapJoiner(std::move(open), small_m).run()) {
    found.push_back(std::move(outline));
  }
  std::vector<std::pair<double, std::size_t>> by_length;
  for (std::size_t i = 0; i < found.size(); ++i)
    by_length.emplace_back(-length_m(found[i].curve), i);
  std::sort(by_length.begin(), by_length.end());
  std::vector<Outline> longest_first;
  for (const auto& [length, i] : by_length) longest_first.push_back(std::move(found[i]));
  return longest_first;
}

}  // namespace palpate
