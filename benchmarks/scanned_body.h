#pragma once

// The scanned body: a machine's housing, 0.2 m long, with flanges, bolts, cooling fins, a thin lid,
// pipes, bores and rivets. Like real scans and unlike smooth spheres, it has small features on
// large ones, and thin parts.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::bench {

// A solid defined by a function that is negative inside, zero on the surface and, outside, never
// larger than the distance to the surface. Frame of the body, metres. Deterministic.
class ScannedBody {
 public:
  ScannedBody();

  // A lower bound of the distance from p to the surface.
  double distance_m(const Vec3& p) const { return distance_m(p, all_); }
  // The direction of growing distance; on the surface, the normal.
  Vec3 outwards(const Vec3& p) const { return outwards(p, all_); }

  // A point of the surface, approximately the nearest to p.
  Vec3 surface_near(Vec3 p) const;

  // The parts that determine the distance within radius_m of p. The overloads below use only these
  // parts.
  struct Parts {
    std::vector<std::uint32_t> solid;
    std::vector<std::uint32_t> bores;
  };
  Parts parts_near(const Vec3& p, double radius_m) const;
  double distance_m(const Vec3& p, const Parts& parts) const;
  Vec3 outwards(const Vec3& p, const Parts& parts) const;

  // The body lies within this distance of the origin along each axis.
  static constexpr double kHalfExtent_m = 0.1;

 private:
  enum class Shape : std::uint8_t { kBox, kCylinder, kRing, kBall };
  struct Part {
    Shape shape;
    Vec3 centre_m;
    Vec3 half_m;     // half extents of a box; other shapes: radius, half height, tube radius
    int axis = 0;    // axis of a cylinder or ring
    double round_m;  // radius of its edges
  };

  void add_block();
  void add_flanges();
  void add_fins_and_lid();
  void add_pipes();
  void add_rivets();
  static double distance_to_part_m(const Part& part, const Vec3& p);

  std::vector<Part> parts_;
  std::vector<Part> bores_;  // subtracted from the union of the parts
  Parts all_;
};

}  // namespace palpate::bench
