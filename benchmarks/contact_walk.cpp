#include "benchmarks/contact_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/base/random.h"

namespace palpate::bench {
namespace {

// Turn of the heading from sample to sample (standard deviation): after a centimetre the heading is
// unrelated to the first one.
constexpr double kTurn_rad = 0.1;

// The longest step of the device in a sample.
constexpr double kFarthest_m = 3.0 * kSpherePathStep_m;

class Walk {
 public:
  Walk(const ScannedBody& body, std::uint64_t seed) : body_(body), random_(seed) {
    p_ = ScannedBody::kHalfExtent_m * random_.unit_vector();
    heading_ = random_.unit_vector();
    come_to_surface();
  }

  void step() {
    const double turn_rad = kTurn_rad * random_.normal();
    heading_ = std::cos(turn_rad) * heading_ + std::sin(turn_rad) * normal_.cross(heading_);
    p_ += kSpherePathStep_m * heading_;
    come_to_surface();
  }

  const Vec3& place() const { return p_; }
  const Vec3& normal() const { return normal_; }

 private:
  void come_to_surface() {
    p_ = body_.surface_near(p_);
    normal_ = body_.outwards(p_);
    heading_ = (heading_ - heading_.dot(normal_) * normal_).normalized();
  }

  const ScannedBody& body_;
  SeededRandom random_;
  Vec3 p_;
  Vec3 normal_;
  Vec3 heading_;  // along the surface, unit
};

}  // namespace

DevicePath contact_walk(const ScannedBody& body, const WalkStyle& style, std::size_t samples) {
  Walk walk(body, style.seed);
  const auto device_at = [&](double height_m) -> Vec3 {
    return walk.place() + (style.proxy_radius_m + height_m) * walk.normal();
  };
  DevicePath path;
  const double above_m = std::max(style.swing.high_m, 0.0) + 5.0 * kSpherePathStep_m;
  for (double height_m = above_m; height_m > style.swing.high_m; height_m -= kSpherePathStep_m) {
    path.lead_in_m.push_back(device_at(height_m));
  }
  Vec3 device_m = path.lead_in_m.back();
  const double middle_m = 0.5 * (style.swing.high_m + style.swing.low_m);
  const double swing_m = 0.5 * (style.swing.high_m - style.swing.low_m);
  for (std::size_t n = 0; n < samples; ++n) {
    const double turns = static_cast<double>(n) * kSpherePathPeriod_s / style.swing.period_s;
    walk.step();
    const Vec3 to = device_at(middle_m + swing_m * std::cos(2.0 * std::numbers::pi * turns));
    const Vec3 way = to - device_m;
    device_m = way.norm() <= kFarthest_m ? to : Vec3(device_m + kFarthest_m * way.normalized());
    path.timed_m.push_back(device_m);
  }
  return path;
}

}  // namespace palpate::bench
