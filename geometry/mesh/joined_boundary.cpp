#include "geometry/mesh/joined_boundary.h"

#include <utility>

#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/point_tree.h"
#include "geometry/mesh/surface_parts.h"

namespace palpate {
namespace {

// The search for what may be within a bound covers this much more than the bound, which is computed
// from the coordinates of one of the two positions only.
constexpr double kSearchMargin = 1 + 0x1p-10;

}  // namespace

JoinedBoundary::JoinedBoundary(const WeldedSurface& surface, const GapLimit& limit)
    : surface_(surface),
      limit_(limit),
      reach_m_(Vec3::Zero()),
      vertices_(boundary_vertices(surface)),
      extents_m_(part_extents_m(surface, vertices_)),
      sets_(vertices_.size()) {
  if (limit.most_m > 0.0) {
    reach_m_ = limit.most_m * limit.linear.inverse().rowwise().norm();
  }
  find_faces();
}

void JoinedBoundary::find_faces() {
  std::vector<bool> is_on_boundary(surface_.positions().size(), false);
  for (const std::uint32_t v : vertices_) is_on_boundary[v] = true;
  for (std::uint32_t f = 0; f < surface_.face_count(); ++f) {
    const auto [a, b, c] = surface_.faces()[f];
    if (is_on_boundary[a] || is_on_boundary[b] || is_on_boundary[c]) faces_.push_back(f);
  }
}

Vec3 JoinedBoundary::search_m(const BoundaryEdge& edge) {
  const Vec3 bound_m = join_bound_m(joined(edge.from), joined(edge.to),
                                    std::max(extents_m_[edge.from], extents_m_[edge.to]));
  return kSearchMargin * bound_m.cwiseMax(reach_m_);
}

std::vector<std::uint32_t> JoinedBoundary::merged_vertices() {
  std::vector<std::uint32_t> into = vertices_;
  std::vector<bool> has_several(vertices_.size(), false);
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    if (sets_.lowest(v) != v) has_several[sets_.lowest(v)] = true;
  }
  std::vector<std::uint32_t> sets;
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    if (has_several[v]) sets.push_back(v);
  }
  if (sets.empty()) return into;
  take_unused(sets, into);
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    const std::uint32_t lowest = sets_.lowest(v);
    const Vec3& p = surface_.positions()[into[lowest]];
    if (!counts_as_one(position(v), p, extent_m(v, lowest))) {
      into[lowest] = vertices_[lowest];
    }
  }
  return into;
}

// Replaces the lowest vertices of the sets by unused vertices of lower numbers near them.
void JoinedBoundary::take_unused(const std::vector<std::uint32_t>& sets,
                                 std::vector<std::uint32_t>& into) const {
  std::vector<bool> is_used(surface_.positions().size(), false);
  for (const Triangle& face : surface_.faces()) {
    for (const std::uint32_t v : face) is_used[v] = true;
  }
  std::vector<Vec3> positions;
  positions.reserve(sets.size());
  for (const std::uint32_t v : sets) positions.push_back(position(v));
  const PointTree tree(std::move(positions));
  const double largest_m = *std::max_element(extents_m_.begin(), extents_m_.end());
  for (std::uint32_t u = 0; u < is_used.size(); ++u) {
    if (is_used[u]) continue;
    const Vec3& p = surface_.positions()[u];
    const Vec3 search = kSearchMargin * join_bound_m(p, p, largest_m).cwiseMax(reach_m_);
    std::uint32_t near = kNone;
    std::size_t visits = 0;
    tree.visit_box({p - search, p + search}, [&](std::uint32_t i) {
      if (++visits > kMostNear) near = kSeveral;
      if (counts_as_one(p, position(sets[i]), extents_m_[sets[i]])) {
        near = near == kNone ? sets[i] : kSeveral;
      }
      return near != kSeveral;
    });
    if (near < kSeveral && u < into[near]) into[near] = u;
  }
}

}  // namespace palpate
