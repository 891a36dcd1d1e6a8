#include "tests/haptics/proxy/reference_god_object.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace palpate::test {
namespace {

// 30 roundings of coordinates of the scene's size, magnified by planes that meet at 0.1 deg:
// 1 / sin = 573.
constexpr Wide kRoundoffPerSize = 30 * 573 * std::numeric_limits<Wide>::epsilon();

// Largest number of pieces of a path; a proxy that has not come to rest by then never does.
constexpr int kMostPieces = 1000;

ReferenceSurface::Face make_face(const std::array<WideVec3, 3>& corners, Wide sign) {
  ReferenceSurface::Face face{corners, {}, {}};
  const WideVec3 front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  face.normal = sign * front;
  for (std::size_t e = 0; e < 3; ++e) {
    face.inward[e] = front.cross(corners[(e + 1) % 3] - corners[e]).normalized();
  }
  return face;
}

// The point on all planes that is nearest to the goal, if every plane pushes the point.
std::optional<WideVec3> on_all(const std::vector<const ReferencePlane*>& planes,
                               const WideVec3& goal) {
  using Matrix = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
  const auto n = static_cast<Eigen::Index>(planes.size());
  if (n == 0) return goal;
  Matrix normals(3, n);
  Eigen::Matrix<Wide, Eigen::Dynamic, 1> depths(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ReferencePlane& plane = *planes[static_cast<std::size_t>(i)];
    normals.col(i) = plane.normal;
    depths(i) = plane.offset_m - plane.normal.dot(goal);
  }
  const Eigen::FullPivLU<Matrix> gram(normals.transpose() * normals);
  if (!gram.isInvertible()) return std::nullopt;
  const Eigen::Matrix<Wide, Eigen::Dynamic, 1> pushes = gram.solve(depths);
  if ((pushes.array() < 0).any()) return std::nullopt;
  return WideVec3(goal + normals * pushes);
}

}  // namespace

ReferenceSurface::ReferenceSurface(const std::vector<Vec3>& positions_m,
                                   const std::vector<Triangle>& triangles, Side side) {
  WideVec3 low = positions_m.front().cast<Wide>();
  WideVec3 high = low;
  Wide edges_m = 0;
  for (const Triangle& t : triangles) {
    const std::array<WideVec3, 3> corners{positions_m[t[0]].cast<Wide>(),
                                          positions_m[t[1]].cast<Wide>(),
                                          positions_m[t[2]].cast<Wide>()};
    faces_.push_back(make_face(corners, side == Side::kOutside ? 1 : -1));
    for (const WideVec3& p : corners) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    edges_m += (corners[1] - corners[0]).norm();
  }
  roundoff_m_ = kRoundoffPerSize * (high - low).maxCoeff();
  cell_m_ = 2 * edges_m / static_cast<Wide>(triangles.size());
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const auto& [a, b, c] = faces_[f].corners;
    const auto from = cell_at(a.cwiseMin(b).cwiseMin(c));
    const auto to = cell_at(a.cwiseMax(b).cwiseMax(c));
    for (auto x = from[0]; x <= to[0]; ++x) {
      for (auto y = from[1]; y <= to[1]; ++y) {
        for (auto z = from[2]; z <= to[2]; ++z) cells_[cell_of({x, y, z})].push_back(f);
      }
    }
  }
}

std::array<std::int64_t, 3> ReferenceSurface::cell_at(const WideVec3& p) const {
  return {static_cast<std::int64_t>(std::floor(p.x() / cell_m_)),
          static_cast<std::int64_t>(std::floor(p.y() / cell_m_)),
          static_cast<std::int64_t>(std::floor(p.z() / cell_m_))};
}

std::uint64_t ReferenceSurface::cell_of(const std::array<std::int64_t, 3>& cell) const {
  constexpr std::int64_t kMiddle = 1 << 20;  // 21 bits an axis
  std::uint64_t key = 0;
  for (const std::int64_t i : cell) key = key << 21 | static_cast<std::uint64_t>(i + kMiddle);
  return key;
}

const std::vector<std::uint32_t>& ReferenceSurface::faces_around(const WideVec3& a,
                                                                 const WideVec3& b) const {
  const WideVec3 margin = WideVec3::Constant(roundoff_m_);
  const auto from = cell_at(a.cwiseMin(b) - margin);
  const auto to = cell_at(a.cwiseMax(b) + margin);
  found_.clear();
  for (auto x = from[0]; x <= to[0]; ++x) {
    for (auto y = from[1]; y <= to[1]; ++y) {
      for (auto z = from[2]; z <= to[2]; ++z) {
        const auto cell = cells_.find(cell_of({x, y, z}));
        if (cell == cells_.end()) continue;
        found_.insert(found_.end(), cell->second.begin(), cell->second.end());
      }
    }
  }
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  return found_;
}

Wide ReferenceSurface::height_m(std::uint32_t face, const WideVec3& p) const {
  return faces_[face].normal.dot(p - faces_[face].corners[0]);
}

bool ReferenceSurface::is_over(std::uint32_t face, const WideVec3& p) const {
  const Face& f = faces_[face];
  for (std::size_t e = 0; e < 3; ++e) {
    if (f.inward[e].dot(p - f.corners[e]) < -roundoff_m_) return false;
  }
  return true;
}

WideVec3 ReferenceSurface::project(std::uint32_t face, const WideVec3& p, Wide height) const {
  return p + (height - height_m(face, p)) * faces_[face].normal;
}

std::optional<NearestFeasible> nearest_feasible(const std::vector<ReferencePlane>& planes,
                                                const WideVec3& goal, Wide roundoff_m) {
  const auto violates_none = [&](const WideVec3& p) {
    return std::all_of(planes.begin(), planes.end(), [&](const ReferencePlane& plane) {
      return plane.normal.dot(p) >= plane.offset_m - roundoff_m;
    });
  };
  // Subsets as bit patterns; a subset comes before every larger one that contains it.
  for (std::uint64_t subset = 0; subset < std::uint64_t{1} << planes.size(); ++subset) {
    std::vector<const ReferencePlane*> chosen;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      if (subset >> i & 1) chosen.push_back(&planes[i]);
    }
    if (chosen.size() > 3) continue;
    const auto p = on_all(chosen, goal);
    if (!p || !violates_none(*p)) continue;
    NearestFeasible nearest{*p, {}};
    for (const ReferencePlane* plane : chosen) nearest.active.push_back(*plane);
    return nearest;
  }
  return std::nullopt;
}

bool ReferenceGodObject::move_to(const WideVec3& goal) {
  std::vector<ReferencePlane> planes;
  for (const ReferencePlane& plane : active_) {
    if (surface_->is_over(plane.face, proxy_)) planes.push_back(plane);
  }
  bool began_empty = planes.empty();
  WideVec3 round_start = proxy_;
  for (int piece = 0; piece < kMostPieces; ++piece) {
    const auto nearest = nearest_feasible(planes, goal, surface_->roundoff_m());
    if (!nearest) return false;
    active_ = nearest->active;
    if (const auto hit = first_hit(nearest->point)) {
      proxy_ += hit->fraction * (nearest->point - proxy_);
      planes.push_back(plane_of(hit->face));
      continue;
    }
    proxy_ = nearest->point;
    const bool moved = (proxy_ - round_start).norm() > surface_->roundoff_m();
    if (settled() || (began_empty && !moved)) return true;
    planes.clear();
    began_empty = true;
    round_start = proxy_;
  }
  return false;
}

// The first face that the segment from the proxy crosses from the proxy's side.
std::optional<ReferenceGodObject::Hit> ReferenceGodObject::first_hit(const WideVec3& to) const {
  std::optional<Hit> first;
  for (const std::uint32_t face : surface_->faces_around(proxy_, to)) {
    const Wide start_m = surface_->height_m(face, proxy_);
    const Wide end_m = surface_->height_m(face, to);
    const Wide roundoff_m = surface_->roundoff_m();
    if (start_m < -roundoff_m || end_m >= -roundoff_m) continue;
    const Wide above_m = std::max<Wide>(0, start_m);
    const Wide fraction = above_m / (above_m - end_m);
    if (first && first->fraction <= fraction) continue;
    if (surface_->is_over(face, proxy_ + fraction * (to - proxy_))) first = Hit{fraction, face};
  }
  return first;
}

ReferencePlane ReferenceGodObject::plane_of(std::uint32_t face) const {
  const ReferenceSurface::Face& f = surface_->faces()[face];
  return {face, f.normal, f.normal.dot(f.corners[0])};
}

bool ReferenceGodObject::settled() const {
  return std::all_of(active_.begin(), active_.end(), [&](const ReferencePlane& plane) {
    return surface_->is_over(plane.face, proxy_);
  });
}

// Adds violated planes one after the other, the most violated first. Each increases the distance
// from the goal, so that the search ends.
NearestFeasible nearest_inside_convex(const ReferenceSurface& surface, const WideVec3& goal,
                                      Wide offset_m, Wide reach_m) {
  const WideVec3 reach = WideVec3::Constant(reach_m);
  const std::vector<std::uint32_t> nearby = surface.faces_around(goal - reach, goal + reach);
  NearestFeasible nearest{goal, {}};
  for (;;) {
    Wide worst_m = offset_m - surface.roundoff_m();
    std::optional<std::uint32_t> worst;
    for (const std::uint32_t face : nearby) {
      const Wide height_m = surface.height_m(face, nearest.point);
      if (height_m >= worst_m) continue;
      worst_m = height_m;
      worst = face;
    }
    if (!worst) return nearest;
    const ReferenceSurface::Face& f = surface.faces()[*worst];
    nearest.active.push_back({*worst, f.normal, f.normal.dot(f.corners[0]) + offset_m});
    const auto next = nearest_feasible(nearest.active, goal, surface.roundoff_m());
    if (!next) {
      ADD_FAILURE() << "no nearest point among " << nearest.active.size() << " planes";
      return nearest;
    }
    nearest = *next;
  }
}

}  // namespace palpate::test
