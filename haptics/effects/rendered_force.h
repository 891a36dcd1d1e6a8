#pragma once

// The force of a contact that has effects.

#include "haptics/effects/effect_runner.h"
#include "haptics/proxy/proxy_state.h"

namespace palpate {

// The virtual coupling's force on the hand, solver frame, N, in the order of the stages. With d the
// depth, h the height of the surface, N the contact normal and t the proxy's tangential lag:
//
//     press   K (d + h) + B u_n                  stiffness, damping, texture
//     side    K t + B u_t                        friction: mu_k press where the contact slides,
//                                                mu_s press at most where it sticks
//     what pulls along N is left out, as VirtualCoupling has it
//     both turned from N to the felt normal      shading
//     less    K (d + h) grad h                   texture
//
// lag_m: proxy minus goal. damped_m_per_s: u, see VirtualCoupling. Safe on the haptic thread.
Vec3 rendered_force_N(const ContactResponse& response, const ProxyState& state, const Vec3& lag_m,
                      const Vec3& damped_m_per_s) noexcept;

}  // namespace palpate
