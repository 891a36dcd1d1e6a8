#pragma once

// The world as one haptic loop has it now: bodies may move from tick to tick.

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/proxy/contact_world.h"

namespace palpate {

// A copy of the poses of a ContactWorld, whose surfaces it shares. Bodies that have once been moved
// are kept apart: what is remembered or sorted in advance is about those at rest.
//
// No allocation, lock or exception after construction. One thread owns it.
class LiveWorld {
 public:
  // Bodies that may move: each of them is asked at every step of the proxy.
  static constexpr std::size_t kMostMoving = 256;

  explicit LiveWorld(const ContactWorld& world);

  const ContactBody& body(std::uint32_t b) const { return bodies_[b]; }
  std::span<const ContactBody> bodies() const { return bodies_; }
  // Those that have been moved, in the order in which they first were.
  std::span<const std::uint32_t> moving() const { return moving_; }
  bool is_moving(std::uint32_t b) const { return is_moving_[b]; }

  double size_m() const { return size_m_; }
  // Around all surfaces, wherever they have been so far, as told by take_bounds(). Solver frame.
  const Box& bounds_solver() const { return bounds_solver_; }

  // Moves a body. False, and nothing done, if too many move already.
  bool place(std::uint32_t b, const RigidTransform& T_solver_body) noexcept;
  // Makes the bounds hold a body where it is. Apart from place(), whose move may be taken back.
  void take_bounds(std::uint32_t b) noexcept;

  // Calls visit(b) for every body at rest that comes within radius_m of p, in ascending order,
  // until it returns false.
  template <typename Visit>
  void visit_resting_near(const Vec3& p, double radius_m, NearSearch search,
                          Visit visit) const noexcept {
    if (!tree_) return visit_all_resting(0, visit);
    Visitor<Visit> visitor{this, &visit};
    tree_->visit_near(p, radius_m, search, Visitor<Visit>::visit_if_resting, &visitor);
  }

  // Calls visit(b) for every body at rest, from number `first` on, that comes within radius_m of
  // the segment p to p + d, in ascending order, until it returns false. radius_m: of the proxy, and
  // what the world's tree was built for.
  template <typename Visit>
  void visit_resting_along(const Vec3& p, const Vec3& d, double radius_m, std::uint32_t first,
                           Visit visit) const noexcept {
    if (!tree_) return visit_all_resting(first, visit);
    Visitor<Visit> visitor{this, &visit};
    tree_->visit_along(p, d, radius_m, first, Visitor<Visit>::visit_if_resting, &visitor);
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
  void visit_all_resting(std::uint32_t first, Visit& visit) const noexcept {
    for (std::uint32_t b = first; b < bodies_.size(); ++b) {
      if (!is_moving_[b] && !visit(b)) return;
    }
  }

  std::vector<ContactBody> bodies_;
  std::shared_ptr<const BoxTree> tree_;  // of the bodies where they were at first; may be null
  std::vector<std::uint32_t> moving_;
  std::vector<bool> is_moving_;
  Box bounds_solver_;
  double size_m_;
};

}  // namespace palpate
