#include "haptics/effects/rendered_force.h"

#include <algorithm>

namespace palpate {
namespace {

// The tangential force that friction allows.
Vec3 friction_force_N(const ProxyState& state, const Vec3& tangential_lag_m,
                      const Vec3& tangential_N, double normal_N) {
  if (state.friction == FrictionState::kSlides) {
    const double lag_m = tangential_lag_m.norm();
    if (lag_m == 0.0) return Vec3::Zero();
    return state.cone.dynamic_friction * normal_N / lag_m * tangential_lag_m;
  }
  const double most_N = state.cone.static_friction * normal_N;
  const double size_N = tangential_N.norm();
  return size_N > most_N ? Vec3(most_N / size_N * tangential_N) : tangential_N;
}

// Rotates v by the smallest rotation from one unit vector to another. Their angle must be less than
// pi.
Vec3 turned(const Vec3& v, const Vec3& from, const Vec3& to) {
  if (from == to) return v;
  // Rodrigues: v + w x v + w x (w x v) / (1 + c), with w = from x to and c = from . to.
  const Vec3 w = from.cross(to);
  const Vec3 wv = w.cross(v);
  return v + wv + w.cross(wv) / (1.0 + from.dot(to));
}

}  // namespace

Vec3 rendered_force_N(const ContactResponse& response, const ProxyState& state, const Vec3& lag_m,
                      const Vec3& damped_m_per_s) noexcept {
  if (!state.is_held && response.height_m == 0.0) {
    // A spring and a damper only: the same as without effects, to the bit.
    return turned(coupling_force_N(response.coupling, lag_m, damped_m_per_s, state.normal),
                  state.normal, response.normal);
  }
  const Vec3 pressed_m = state.pressed_part(lag_m);
  const double penetration_m = pressed_m.norm();
  const double compression_m = std::max(0.0, penetration_m + response.height_m);
  if (compression_m == 0.0) return Vec3::Zero();
  const Vec3 axis = pressed_m / penetration_m;
  const double K = response.coupling.stiffness_N_per_m;
  const double B = response.coupling.damping_Ns_per_m;
  const double damped_axis = damped_m_per_s.dot(axis);
  double normal_N = K * compression_m + B * damped_axis;
  const Vec3 tangential_m = lag_m - pressed_m;
  Vec3 tangential_N = K * tangential_m + B * (damped_m_per_s - damped_axis * axis);
  if (state.is_held) {
    normal_N = std::max(0.0, normal_N);  // no friction if the contact pulls
    tangential_N = friction_force_N(state, tangential_m, tangential_N, normal_N);
  }
  Vec3 force_N = normal_N * axis + tangential_N;
  force_N += std::max(0.0, -force_N.dot(state.normal)) * state.normal;
  return turned(force_N, state.normal, response.normal) - K * compression_m * response.slope;
}

}  // namespace palpate
