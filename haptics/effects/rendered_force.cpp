#include "haptics/effects/rendered_force.h"

#include <algorithm>

namespace palpate {
namespace {

// What friction makes of a force along the surface.
Vec3 held_side_N(const ProxyState& state, const Vec3& tangential_lag_m, const Vec3& side_N,
                 double press_N) {
  if (state.friction == FrictionState::kSlides) {
    const double lag_m = tangential_lag_m.norm();
    if (lag_m == 0.0) return Vec3::Zero();
    return state.cone.dynamic_friction * press_N / lag_m * tangential_lag_m;
  }
  const double most_N = state.cone.static_friction * press_N;
  const double size_N = side_N.norm();
  return size_N > most_N ? Vec3(most_N / size_N * side_N) : side_N;
}

// Turns v as the shortest turn from one unit vector to another does, which are less than half a
// circle apart.
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
    // A spring and a damper: as in bare contact, to the bit.
    return turned(coupling_force_N(response.coupling, lag_m, damped_m_per_s, state.normal),
                  state.normal, response.normal);
  }
  const Vec3 pressed_m = state.pressed_part(lag_m);
  const double depth_m = pressed_m.norm();
  const double deep_m = std::max(0.0, depth_m + response.height_m);
  if (deep_m == 0.0) return Vec3::Zero();
  const Vec3 axis = pressed_m / depth_m;
  const double K = response.coupling.stiffness_N_per_m;
  const double B = response.coupling.damping_Ns_per_m;
  const double damped_axis = damped_m_per_s.dot(axis);
  double press_N = K * deep_m + B * damped_axis;
  const Vec3 tangential_m = lag_m - pressed_m;
  Vec3 side_N = K * tangential_m + B * (damped_m_per_s - damped_axis * axis);
  if (state.is_held) {
    press_N = std::max(0.0, press_N);  // friction has no cone for a pull
    side_N = held_side_N(state, tangential_m, side_N, press_N);
  }
  Vec3 force_N = press_N * axis + side_N;
  force_N += std::max(0.0, -force_N.dot(state.normal)) * state.normal;
  return turned(force_N, state.normal, response.normal) - K * deep_m * response.slope;
}

}  // namespace palpate
