#include "engine/experiment/canonical_measures.h"

#include <cmath>
#include <numbers>

#include "engine/experiment/canonical_wall.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Bounds the rounding of a component of N, and of the contact angle in radians. N is a unit vector
// of the scene, turned by a quaternion: four numbers of at most 1 with half an ulp each, squared or
// multiplied, doubled and added, are off by less than 16 ulp of 1 (2^-52). The angle is the
// arctangent of two such components. 2^-47 is twice that.
constexpr double kRounding = 0x1p-47;

constexpr double kFeasible_rad = std::numbers::pi / 6.0;  // Barbagli and Salisbury 2003

}  // namespace

void CanonicalMeasures::on_tick(const TickRecord& record) noexcept {
  loop_ns_ += record.step_ns;
  is_spoilt_ = is_spoilt_ || (record.faults & kFaultsWithoutSample) != 0 ||
               std::abs(record.proxy_scene_m[1]) > kWallHalfLength_m;
  if (!record.contact) return;
  ++contact_ticks_;
  if (record.alpha_rad <= kFeasible_rad + kRounding) ++within_30deg_;
  const Vec3 normal_device = pose_before(record).direction(vec3(record.normal_scene));
  const Vec3 force_N = vec3(record.force_device_N);
  const double into_N = force_N.dot(normal_device);
  into_sum_N_ += into_N;
  along_sum_N_ += (force_N - into_N * normal_device).norm();
  full_sum_N_ += vec3(record.full_force_device_N).norm();
}

// A motor across N commands a force whose f.N is the rounding of N alone.
std::optional<double> CanonicalMeasures::along_over_into() const {
  if (!(into_sum_N_ > kRounding * full_sum_N_)) return std::nullopt;
  return along_sum_N_ / into_sum_N_;
}

std::optional<double> CanonicalMeasures::share_within_30deg() const {
  if (contact_ticks_ == 0) return std::nullopt;
  return static_cast<double>(within_30deg_) / static_cast<double>(contact_ticks_);
}

}  // namespace palpate
