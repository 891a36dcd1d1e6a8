#include "benchmarks/scanned_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::bench {
namespace {

// Step of a numerical derivative: far above the rounding of distances, far below any feature.
constexpr double kDifference_m = 1e-6;

// The function is smaller than the true distance only near bores: a few steps are enough.
constexpr int kStepsToSurface = 4;

// The distance to a rectangle from a point outside it by x and y (negative: inside).
double distance_to_corner_m(double x, double y) {
  return std::hypot(std::max(x, 0.0), std::max(y, 0.0)) + std::min(std::max(x, y), 0.0);
}

// A point on a circle about the x axis.
Vec3 about_x(double x_m, double radius_m, double turns) {
  const double angle_rad = 2.0 * std::numbers::pi * turns;
  return {x_m, radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad)};
}

}  // namespace

ScannedBody::ScannedBody() {
  add_block();
  add_flanges();
  add_fins_and_lid();
  add_pipes();
  add_rivets();
  for (std::uint32_t i = 0; i < parts_.size(); ++i) all_.solid.push_back(i);
  for (std::uint32_t i = 0; i < bores_.size(); ++i) all_.bores.push_back(i);
}

void ScannedBody::add_block() {
  parts_.push_back({Shape::kBox, {0.0, 0.0, 0.0}, {0.062, 0.042, 0.034}, 0, 0.006});
  bores_.push_back({Shape::kCylinder, {0.0, 0.0, 0.0}, {0.009, 0.2, 0.0}, 0, 0.0});
  bores_.push_back({Shape::kCylinder, {0.02, 0.0, -0.01}, {0.004, 0.2, 0.0}, 1, 0.0});
}

void ScannedBody::add_flanges() {
  constexpr int kBolts = 8;
  for (const double side : {-1.0, 1.0}) {
    parts_.push_back({Shape::kCylinder, {side * 0.068, 0.0, 0.0}, {0.046, 0.004, 0.0}, 0, 0.001});
    parts_.push_back({Shape::kCylinder, {side * 0.085, 0.0, 0.0}, {0.014, 0.014, 0.0}, 0, 0.002});
    for (int bolt = 0; bolt < kBolts; ++bolt) {
      const Vec3 head = about_x(side * 0.0735, 0.039, (bolt + 0.5) / kBolts);
      parts_.push_back({Shape::kCylinder, head, {0.0032, 0.0016, 0.0}, 0, 0.0003});
      bores_.push_back({Shape::kCylinder, head, {0.0011, 0.003, 0.0}, 0, 0.0});
    }
  }
}

// Fins of 1 mm and a lid of 0.8 mm that protrudes beyond them.
void ScannedBody::add_fins_and_lid() {
  constexpr int kFins = 11;
  for (int fin = 0; fin < kFins; ++fin) {
    const double x_m = 0.01 * (fin - kFins / 2);
    parts_.push_back({Shape::kBox, {x_m, 0.0, 0.042}, {0.0005, 0.036, 0.01}, 0, 0.0002});
  }
  parts_.push_back({Shape::kBox, {0.0, 0.0, -0.0365}, {0.07, 0.05, 0.0004}, 0, 0.0001});
}

void ScannedBody::add_pipes() {
  for (const double x_m : {-0.035, 0.0, 0.035}) {
    parts_.push_back({Shape::kRing, {x_m, 0.042, 0.0}, {0.02, 0.0, 0.0035}, 0, 0.0});
  }
}

void ScannedBody::add_rivets() {
  for (int i = 0; i < 14; ++i) {
    for (int j = 0; j < 6; ++j) {
      const Vec3 place(0.008 * (i - 6.5), -0.042, 0.009 * (j - 2.5));
      parts_.push_back({Shape::kBall, place, {0.0009, 0.0, 0.0}, 0, 0.0});
    }
  }
}

double ScannedBody::distance_to_part_m(const Part& part, const Vec3& p) {
  const Vec3 from = p - part.centre_m;
  const double along_m = std::abs(from[part.axis]);
  const double across_m = std::hypot(from[(part.axis + 1) % 3], from[(part.axis + 2) % 3]);
  switch (part.shape) {
    case Shape::kBox: {
      const Vec3 beyond = from.cwiseAbs() - part.half_m + Vec3::Constant(part.round_m);
      return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0) - part.round_m;
    }
    case Shape::kCylinder:
      return distance_to_corner_m(across_m - part.half_m[0] + part.round_m,
                                  along_m - part.half_m[1] + part.round_m) -
             part.round_m;
    case Shape::kRing:
      return std::hypot(across_m - part.half_m[0], along_m) - part.half_m[2];
    case Shape::kBall:
      return from.norm() - part.half_m[0];
  }
  return std::numeric_limits<double>::infinity();
}

double ScannedBody::distance_m(const Vec3& p, const Parts& parts) const {
  double distance = std::numeric_limits<double>::infinity();
  for (const std::uint32_t i : parts.solid) {
    distance = std::min(distance, distance_to_part_m(parts_[i], p));
  }
  for (const std::uint32_t i : parts.bores) {
    distance = std::max(distance, -distance_to_part_m(bores_[i], p));
  }
  return distance;
}

// A part that is farther from p than the nearest part by more than twice the radius is the nearest
// part of no point within the radius. A bore as far away as that removes nothing there.
ScannedBody::Parts ScannedBody::parts_near(const Vec3& p, double radius_m) const {
  std::vector<double> distances_m;
  for (const Part& part : parts_) distances_m.push_back(distance_to_part_m(part, p));
  const double nearest_m = *std::min_element(distances_m.begin(), distances_m.end());
  Parts near;
  for (const std::uint32_t i : all_.solid) {
    if (distances_m[i] <= nearest_m + 2.0 * radius_m) near.solid.push_back(i);
  }
  for (const std::uint32_t i : all_.bores) {
    if (-distance_to_part_m(bores_[i], p) >= nearest_m - 2.0 * radius_m) near.bores.push_back(i);
  }
  return near;
}

Vec3 ScannedBody::outwards(const Vec3& p, const Parts& parts) const {
  Vec3 slope;
  for (int k = 0; k < 3; ++k) {
    const Vec3 step = kDifference_m * Vec3::Unit(k);
    slope[k] = distance_m(p + step, parts) - distance_m(p - step, parts);
  }
  const double length = slope.norm();
  return length > 0.0 ? Vec3(slope / length) : Vec3(Vec3::UnitZ());
}

Vec3 ScannedBody::surface_near(Vec3 p) const {
  for (int step = 0; step < kStepsToSurface; ++step) p -= distance_m(p) * outwards(p);
  return p;
}

}  // namespace palpate::bench
