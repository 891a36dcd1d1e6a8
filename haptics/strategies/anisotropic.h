#pragma once

// The strategy `anisotropic:E`, after Lobo and Otaduy, IEEE Transactions on Haptics 13(4), 2020.
//
// Theirs is the idea: an anisotropic metric of the proxy's constrained minimisation accounts for
// the directions that a device cannot push. Their equations were not at hand. Ours are the metric W
// below, the force, its certificate, and the range of E.
//
// With W = I + (E - 1)(I - P), P the projection on the actuated span, the proxy p is the local
// minimum of (p - x)'W(p - x) that is reached from the last p; F = K (p - x) plus the damper of all
// strategies, and the commanded force is f = P F. E below 1 weakens what cannot be pushed; E above
// 1 seeks the proxy along the motors. On a plane at angle a to the motors, at depth d,
//
//     |f| = K d cos a / (cos^2 a + sin^2 a / E).
//
// Each committed segment crosses no triangle and keeps the stand-off (GodObject::move_in_norm). The
// lag in the norm of W never grows in a tick with a fixed mesh, and the certificate of passivity
// holds for F_W = K W (p - x), E_W = K/2 (p - x)'W(p - x) and |dx| in that norm; f = P F_W. The
// Euclidean lag may grow, and nothing is promised about it; f is a projection and has no
// certificate, as with `mask`.
//
// The record's full force is the part of F in the span of the normals of the pressed planes, so
// that ghost and missing force mean the same as for the other strategies. On one plane that is
// (F.N)N. In a corner, where N is the average of several normals, (F.N)N would be shorter than the
// force that `mask` records for the same contact.
//
// The safety governor counts the spring with this norm, too (CountedSpring): it stores E_W.
//
// Scope: a point proxy, no friction, no effect beside stiffness and damping, a scene that A4 does
// not turn. check_settings() refuses settings and worlds beyond it.

#include <array>
#include <span>

#include "haptics/a4/actuation.h"
#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// The norm of W in solver axes. R_device_scene: of the scene's pose.
inline AnisotropicNorm anisotropic_norm(double anisotropy, const ActuationModel& actuation,
                                        const Mat3& R_device_scene) noexcept {
  std::array<Vec3, 3> axes;
  const auto count = static_cast<std::size_t>(actuation.actuators());
  for (std::size_t i = 0; i < count; ++i) {
    axes[i] = R_device_scene.transpose() * actuation.actuated_axis(static_cast<int>(i));
  }
  return AnisotropicNorm(anisotropy, std::span(axes).first(count));
}

std::unique_ptr<StrategyStep> make_anisotropic_step(const ActuationModel& actuation,
                                                    const HapticSettings& settings);
std::optional<Error> check_anisotropic(const ContactWorld& world, const HapticSettings& settings);

inline constexpr StrategyType kAnisotropicStrategy{
    .name = "anisotropic",
    .parameter = StrategyParameter{.symbol = "E",
                                   .least = 1.0 / 16,
                                   .most = 16.0,
                                   .example = 0.25,
                                   .meaning = "E below 1 weakens what the motors cannot push"},
    .make_step = make_anisotropic_step,
    .check = check_anisotropic};

}  // namespace palpate
