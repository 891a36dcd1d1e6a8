#pragma once

// The body whose scans are measured: a machine's housing, 0.2 m long, with flanges, bolts, cooling
// fins, a thin lid, pipes, bores and rivets. Small features on large ones, and thin parts, as real
// scans have them and smooth spheres do not.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::bench {

// A solid told by a function: negative inside, zero on the surface, and nowhere larger than the
// distance to the surface. Its own frame, metres. Deterministic.
class ScannedBody {
 public:
  ScannedBody();

  // How far p is from the surface, at least.
  double distance_m(const Vec3& p) const { return distance_m(p, all_); }
  // The direction in which that grows: on the surface, its normal.
  Vec3 outwards(const Vec3& p) const { return outwards(p, all_); }

  // A place of the surface, about the nearest to p.
  Vec3 surface_near(Vec3 p) const;

  // The parts that decide within radius_m of p, and the same by them alone.
  struct Parts {
    std::vector<std::uint32_t> solid;
    std::vector<std::uint32_t> bores;
  };
  Parts parts_near(const Vec3& p, double radius_m) const;
  double distance_m(const Vec3& p, const Parts& parts) const;
  Vec3 outwards(const Vec3& p, const Parts& parts) const;

  // All of it is within so much of the origin, along each axis.
  static constexpr double kHalfExtent_m = 0.1;

 private:
  enum class Shape : std::uint8_t { kBox, kCylinder, kRing, kBall };
  struct Part {
    Shape shape;
    Vec3 centre_m;
    Vec3 half_m;     // a box: its extents; cylinders and rings: radius, half the height, tube
    int axis = 0;    // of cylinders and rings
    double round_m;  // radius of its edges
  };

  void add_block();
  void add_flanges();
  void add_fins_and_lid();
  void add_pipes();
  void add_rivets();
  static double distance_to_part_m(const Part& part, const Vec3& p);

  std::vector<Part> parts_;
  std::vector<Part> bores_;  // taken away from all of them
  Parts all_;
};

}  // namespace palpate::bench
