#pragma once

// The force of a contact that has effects.

#include "haptics/effects/effect_runner.h"
#include "haptics/proxy/proxy_state.h"

namespace palpate {

// Returns the virtual coupling's force on the hand, solver frame, N. Its terms are computed in the
// order of the stages. In these terms, d is the penetration depth, h is the height of the surface,
// N is the contact normal and t is the proxy's tangential lag:
//
//     normal      K (d + h) + B u_n      stiffness, damping, texture
//     tangential  K t + B u_t            friction limits it: to mu_k times the normal force while
//                                        the contact slides, to at most mu_s times while it sticks.
//                                        With the spring alone, it is K t except after a capped
//                                        tick
//     sum         without any part that pulls along N, as in VirtualCoupling
//     rotation    of the sum from N to the rendered normal          shading
//     minus       K (d + h) grad h                                  texture
//
// lag_m: proxy minus goal, m. damped_m_per_s: u, see VirtualCoupling. No state; safe on any thread.
Vec3 rendered_force_N(const ContactResponse& response, const ProxyState& state, const Vec3& lag_m,
                      const Vec3& damped_m_per_s) noexcept;

}  // namespace palpate
