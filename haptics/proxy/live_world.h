#pragma once

// The current poses of a world's bodies in one haptic loop. Bodies may move from tick to tick.

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/proxy/contact_world.h"

namespace palpate {

// A copy of the poses of a ContactWorld; the surfaces are shared. Bodies that have ever moved are
// listed separately, since the tree over the bodies and the candidate cache cover only bodies at
// rest.
//
// Safe on the haptic thread: no allocation, lock or exception after construction. Not thread-safe:
// one thread owns an instance.
class LiveWorld {
 public:
  // Largest number of bodies that may move. Every step of the proxy tests each of them.
  static constexpr std::size_t kMostMoving = 256;

  // Shares the surfaces, stretches and corners of the world, which must outlive this object.
  explicit LiveWorld(const ContactWorld& world);

  const ContactBody& body(std::uint32_t b) const { return bodies_[b]; }
  std::span<const ContactBody> bodies() const { return bodies_; }
  // The bodies that have moved, in the order of their first moves.
  std::span<const std::uint32_t> moving() const { return moving_; }
  bool is_moving(std::uint32_t b) const { return is_moving_[b]; }

  double size_m() const { return size_m_; }
  // A box around all surfaces at their initial poses and around every body passed to
  // extend_bounds(), at the pose that the body had in that call. Solver frame, m.
  const Box& bounds_solver() const { return bounds_solver_; }

  // Moves a body. Returns false and changes nothing if kMostMoving bodies have moved already.
  bool place(std::uint32_t b, const RigidTransform& T_solver_body) noexcept;
  // Extends the bounds to contain a body at its current pose. This is not part of place(), because
  // a move by place() may be undone.
  void extend_bounds(std::uint32_t b) noexcept;

  // Calls visit(b) for every body at rest whose box comes within radius_m of p, in ascending order,
  // until visit returns false. A small world has no tree; there, every body at rest is visited.
  // Returns the work of the search in the tree.
  template <typename Visit>
  QueryWork visit_resting_near(const Vec3& p, double radius_m, NearSearch search,
                               Visit visit) const noexcept {
    if (!tree_) return visit_all_resting(0, visit);
    Visitor<Visit> visitor{this, &visit};
    return tree_->visit_near(p, radius_m, search, Visitor<Visit>::visit_if_resting, &visitor);
  }

  // Calls visit(b) for every body at rest, from number `first` on, whose box comes within radius_m
  // of the segment p to p + d, in ascending order, until visit returns false. A small world has no
  // tree; there, every body at rest from `first` on is visited. radius_m: at most the sweep radius
  // that the world's tree was built for. Returns the work of the search in the tree.
  template <typename Visit>
  QueryWork visit_resting_along(const Vec3& p, const Vec3& d, double radius_m, std::uint32_t first,
                                Visit visit) const noexcept {
    if (!tree_) return visit_all_resting(first, visit);
    Visitor<Visit> visitor{this, &visit};
    return tree_->visit_along(p, d, radius_m, first, Visitor<Visit>::visit_if_resting, &visitor);
  }

 private:
  template <typename Visit>
  struct Visitor {
    const LiveWorld* world;
    Visit* visit;

    static bool visit_if_resting(void* state, std::uint32_t b) {
      const auto& v = *static_cast<Visitor*>(state);
      return v.world->is_moving_[b] || (*v.visit)(b);
    }
  };

  template <typename Visit>
  QueryWork visit_all_resting(std::uint32_t first, Visit& visit) const noexcept {
    for (std::uint32_t b = first; b < bodies_.size(); ++b) {
      if (!is_moving_[b] && !visit(b)) break;
    }
    return {};
  }

  std::vector<ContactBody> bodies_;
  std::shared_ptr<const BoxTree> tree_;  // over the bodies at their initial poses; may be null
  std::vector<std::uint32_t> moving_;
  std::vector<bool> is_moving_;
  Box bounds_solver_;
  double size_m_;
};

}  // namespace palpate
