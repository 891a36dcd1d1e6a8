#pragma once

// The place of a contact on a contour.

#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"

namespace palpate {

// Follows a contact along a path. The place moves to contacts at most kReach_m ahead of it; it
// never moves back, and never to another part of the path. Scene frame. No allocation after
// construction; one thread owns an object of this class. The path must outlive the object.
class ContourPlace {
 public:
  // sphere_radius_m: the radius of the spheres that mark the ends of a trial. A contact point lies
  // on the path if its distance from the path is at most kOffPath times this radius.
  ContourPlace(const HandPath& path, double along_m, double sphere_radius_m);

  // Processes a contact, given by its point and by its outward direction, which is the direction
  // from the device point to the proxy. Returns whether the contact lies on the path, at most
  // kReach_m ahead of the place and at most kKept_m behind the place. Such a contact moves the
  // place or confirms it.
  bool see(const Vec3& contact_m, const Vec3& outward);

  double along_m() const { return along_m_; }

  static constexpr double kOffPath = 1.0 / 8;
  // The largest distance ahead of the place at which a contact moves the place.
  static constexpr double kReach_m = 0.03;
  // The largest distance behind the place at which a contact confirms the place.
  static constexpr double kKept_m = 0.01;

 private:
  const HandPath& path_;
  std::vector<double> lengths_m_;
  double off_m_;
  double along_m_;
  std::size_t leg_;  // of the place
};

}  // namespace palpate
