#include "haptics/proxy/float_trace.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using Vec3f = Eigen::Vector3f;

constexpr float kUnit = 0x1p-24f;
constexpr float kHeightError = 16 * kUnit;  // see pack_kernels.inl
constexpr float kVolumeError = 32 * kUnit;

Vec3f to_local(const TrianglePack& pack, const Vec3& p) {
  return ((p - Vec3::Map(pack.centre_m)) * pack.per_metre).cast<float>();
}

Vec3f lane_of(const float (&m)[3][TrianglePack::kLanes], int lane) {
  return {m[0][lane], m[1][lane], m[2][lane]};
}

float triple_product(const Vec3f& u, const Vec3f& v, const Vec3f& w) {
  return u.x() * (v.y() * w.z() - v.z() * w.y()) + u.y() * (v.z() * w.x() - v.x() * w.z()) +
         u.z() * (v.x() * w.y() - v.y() * w.x());
}

// Whether the line through p and q certainly misses the triangle.
bool passes_by(const TrianglePack& pack, int lane, const Vec3f& p, const Vec3f& q) {
  const Vec3f d = q - p;
  const Vec3f a = lane_of(pack.a, lane) - p;
  const Vec3f b = lane_of(pack.b, lane) - p;
  const Vec3f c = lane_of(pack.c, lane) - p;
  const float error =
      d.lpNorm<1>() * (kVolumeError * (3 + p.lpNorm<1>()) + 2 * pack.centre_roundoff);
  const float size[3] = {a.lpNorm<1>() + b.lpNorm<1>(), b.lpNorm<1>() + c.lpNorm<1>(),
                         c.lpNorm<1>() + a.lpNorm<1>()};
  const float volume[3] = {triple_product(d, a, b), triple_product(d, b, c),
                           triple_product(d, c, a)};
  bool left = false;
  bool right = false;
  for (int i = 0; i < 3; ++i) {
    left = left || volume[i] > error * size[i];
    right = right || volume[i] < -error * size[i];
  }
  return left && right;
}

}  // namespace

bool trace_point_in_float(const TrianglePack& pack, int lane, const Vec3& p, const Vec3& q,
                          double stand_off_m, TriangleHit& hit) noexcept {
  const Vec3f p_local = to_local(pack, p);
  const Vec3f q_local = to_local(pack, q);
  const Vec3f normal = lane_of(pack.normal, lane);
  const float start = normal.dot(p_local) - pack.height[lane];
  const float end = normal.dot(q_local) - pack.height[lane];
  const float start_bound = kHeightError * (p_local.lpNorm<1>() + 2) + 4 * pack.centre_roundoff;
  const float end_bound = kHeightError * (q_local.lpNorm<1>() + 2) + 4 * pack.centre_roundoff;
  if ((start > start_bound && end > end_bound) || (start < -start_bound && end < -end_bound)) {
    return false;
  }
  if (passes_by(pack, lane, p_local, q_local)) return false;
  const float side = start < 0.0f ? -1.0f : 1.0f;
  const float approach = side * (start - end);
  if (approach <= 0.0f) return false;  // the step leaves the plane or keeps its height
  const double scale_m = 1.0 / pack.per_metre;
  const double meet = std::clamp(static_cast<double>(side * start / approach), 0.0, 1.0);
  hit.meet_fraction = StepFraction(meet);
  hit.fraction = StepFraction(std::max(0.0, meet - stand_off_m / (approach * scale_m)));
  hit.normal = (side * normal).cast<double>().normalized();
  hit.clearance_m = (side * start - hit.fraction.value() * approach) * scale_m;
  hit.feature = TriangleFeature::kFace;
  hit.feature_point = p + meet * (q - p);
  return true;
}

}  // namespace palpate
