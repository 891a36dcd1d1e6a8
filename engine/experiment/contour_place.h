#pragma once

// The place of a contact on a contour.

#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"

namespace palpate {

// Follows a contact along a path. The place moves to contacts at most kReach_m ahead of it; it
// never moves back, and never to another part of the path. Scene frame. No allocation after
// construction; one thread owns it. The path must outlive it.
class ContourPlace {
 public:
  // sphere_radius_m: of the spheres that mark the ends of a trial. A contact point lies on the path
  // if its distance from the path is at most kOffPath times this radius.
  ContourPlace(const HandPath& path, double along_m, double sphere_radius_m);

  // A contact: its point, and the direction from the device point to the proxy, which leaves the
  // wall. Returns whether the contact moves or keeps the place: whether it lies on the path, at
  // most kReach_m ahead of the place and at most kKept_m behind it.
  bool see(const Vec3& contact_m, const Vec3& outward);

  double along_m() const { return along_m_; }

  static constexpr double kOffPath = 1.0 / 8;
  // The farthest that a contact may be ahead of the place to move it.
  static constexpr double kReach_m = 0.03;
  // The farthest that a contact may be behind the place to keep it.
  static constexpr double kKept_m = 0.01;

 private:
  const HandPath& path_;
  std::vector<double> lengths_m_;
  double off_m_;
  double along_m_;
  std::size_t leg_;  // of the place
};

}  // namespace palpate
