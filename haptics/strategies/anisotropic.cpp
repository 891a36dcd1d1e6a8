#include "haptics/strategies/anisotropic.h"

#include <algorithm>
#include <cmath>

#include "haptics/effects/damping.h"
#include "haptics/effects/effect_program.h"
#include "haptics/effects/stiffness.h"
#include "haptics/proxy/contact_world.h"
#include "haptics/proxy/setting_errors.h"
#include "haptics/strategies/strategy_step.h"

namespace palpate {
namespace {

class AnisotropicStep final : public StrategyStep {
 public:
  std::optional<ProxyState> move_proxy(GodObject& god_object, const Vec3& goal_solver_m,
                                       const std::optional<Vec3>& motion_plane_normal,
                                       const StrategyTick& tick) noexcept override {
    const AnisotropicNorm norm =
        anisotropic_norm(tick.settings.strategy->parameter, tick.actuation, tick.R_device_scene);
    if (norm.is_euclidean()) return std::nullopt;
    return god_object.move_in_norm(goal_solver_m, motion_plane_normal, norm);
  }

  std::optional<StrategyForce> force(const Vec3& force_N,
                                     const StrategyTick& tick) noexcept override {
    return StrategyForce{tick.R_device_scene * tick.proxy.pressed_part(force_N),
                         tick.actuation.actuated_part(tick.R_device_scene * force_N)};
  }

  // The spring stores K/2 |lag|_W^2. |lag|_W grows by at most |dx|_W, which is at most |dx| times
  // the root of the larger one of 1 and E.
  CountedSpring counted_spring(const Vec3& lag_m,
                               const StrategyTick& tick) const noexcept override {
    const double anisotropy = tick.settings.strategy->parameter;
    const AnisotropicNorm norm = anisotropic_norm(anisotropy, tick.actuation, tick.R_device_scene);
    const double factor = std::max(1.0, anisotropy);
    return {factor, norm.length(lag_m) / std::sqrt(factor)};
  }
};

}  // namespace

std::unique_ptr<StrategyStep> make_anisotropic_step(const ActuationModel&, const HapticSettings&) {
  return std::make_unique<AnisotropicStep>();
}

std::optional<Error> check_anisotropic(const ContactWorld& world, const HapticSettings& settings) {
  const std::string is_name = "is " + name_of(*settings.strategy);
  if (settings.god_object.radius_m > 0.0) {
    return invalid_argument("strategy",
                            is_name + ", which is for a point, but the proxy's radius is " +
                                digits_of(settings.god_object.radius_m) + " m",
                            "use radius 0 or another strategy");
  }
  if (!world.effects) return std::nullopt;
  for (const EffectCall& call : world.effects->calls) {
    const std::string_view effect = compiled_effects()[call.effect].name;
    if (effect == StiffnessEffect::kName || effect == DampingEffect::kName) continue;
    return invalid_argument("strategy",
                            is_name + ", which renders no effect but stiffness and damping, but " +
                                "the scene declares " + std::string(effect),
                            "use another strategy, or a scene without this effect");
  }
  return std::nullopt;
}

}  // namespace palpate
