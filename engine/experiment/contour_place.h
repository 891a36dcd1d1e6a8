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
  // off_m: largest distance of a contact point from the path.
  ContourPlace(const HandPath& path, double along_m, double off_m);

  // A contact: its point, and the direction from the device point to the proxy, which leaves the
  // wall. Returns whether the contact moves or keeps the place: whether it lies on the path at most
  // kReach_m before or after the place.
  bool see(const Vec3& contact_m, const Vec3& outward);

  double along_m() const { return along_m_; }
  const std::vector<double>& lengths_m() const { return lengths_m_; }

  // The farthest that a contact may be ahead (the paper's spheres are 12 mm wide).
  static constexpr double kReach_m = 0.03;
  // The farthest that a contact may be behind the place to keep it.
  static constexpr double kKept_m = 0.01;

 private:
  const HandPath& path_;
  std::vector<double> lengths_m_;
  double off_m_;
  double along_m_;
  std::size_t leg_ = 0;  // of the place
};

// The point at this length along a path whose lengths are HandPath::lengths_m(), and the leg that
// it lies on.
std::size_t leg_at(const std::vector<double>& lengths_m, double along_m);
Vec3 point_along(const HandPath& path, const std::vector<double>& lengths_m, double along_m);

}  // namespace palpate
