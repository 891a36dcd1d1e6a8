#include "engine/trials/canonical/canonical_measures.h"

#include <cmath>
#include <numbers>

#include "engine/trials/canonical/canonical_wall.h"
#include "haptics/proxy/contact_world.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Bounds the rounding of a component of N, and of the contact angle in radians. The normal of a
// triangle is a unit vector of the scene, turned by a quaternion: four numbers of at most 1 with
// half an ulp each, squared or multiplied, doubled and added, are off by less than 16 ulp of 1
// (2^-52). The angle is the arctangent of two such components. 2^-47 is twice that.
constexpr double kRounding = 0x1p-47;

// A proxy keeps the contact plane of a face within this many stand-offs (kNearPerStandOff of
// god_object_steps.h).
constexpr double kContactStandOffs = 2.0;

// The largest angle between N and the wall's normal, and the largest error of the contact angle.
// The front of the plate is two triangles. A sphere that rolls from one to the other may still
// touch the edge of the first, and N then points from the edge to the centre. The centre is at
// least r over the face and at most r + c from the edge, c = kContactStandOffs stand-offs, so that
// N is off by at most acos(r / (r + c)) <= sqrt(2 c / r). N of a point is the normal of a triangle.
double normal_error_rad(double radius_m) {
  if (radius_m == 0.0) return kRounding;
  const double size_m = 2.0 * kWallHalfLength_m;
  const double c_m = kContactStandOffs * SolverScale::of(size_m, radius_m).stand_off_m;
  return kRounding + std::sqrt(2.0 * c_m / radius_m);
}

constexpr double kFeasible_rad = std::numbers::pi / 6.0;  // Barbagli and Salisbury 2003

}  // namespace

CanonicalMeasures::CanonicalMeasures(double proxy_radius_m)
    : normal_error_rad_(normal_error_rad(proxy_radius_m)) {}

void CanonicalMeasures::on_tick(const TickRecord& record) noexcept {
  loop_ns_ += record.step_ns;
  is_spoilt_ = is_spoilt_ || (record.faults & kFaultsWithoutSample) != 0 ||
               std::abs(record.proxy_scene_m[1]) > kWallHalfLength_m;
  if (!record.contact) return;
  ++contact_ticks_;
  if (record.alpha_rad <= kFeasible_rad + normal_error_rad_) ++within_30deg_;
  const Vec3 normal_device = pose_before(record).direction(vec3(record.normal_scene));
  const Vec3 force_N = vec3(record.force_device_N);
  const double into_N = force_N.dot(normal_device);
  into_sum_N_ += into_N;
  along_sum_N_ += (force_N - into_N * normal_device).norm();
  full_sum_N_ += vec3(record.full_force_device_N).norm();
}

// A motor across the wall's normal commands a force only because N is off by an angle e: the full
// force F has the part F e along the motor, and this the part F e^2 along N. To this comes the
// rounding of N.
std::optional<double> CanonicalMeasures::along_over_into() const {
  const double least_share = kRounding + normal_error_rad_ * normal_error_rad_;
  if (!(into_sum_N_ > least_share * full_sum_N_)) return std::nullopt;
  return along_sum_N_ / into_sum_N_;
}

std::optional<double> CanonicalMeasures::share_within_30deg() const {
  if (contact_ticks_ == 0) return std::nullopt;
  return static_cast<double>(within_30deg_) / static_cast<double>(contact_ticks_);
}

}  // namespace palpate
