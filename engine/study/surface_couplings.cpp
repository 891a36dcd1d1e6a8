#include "engine/study/surface_couplings.h"

#include <cstring>
#include <optional>

#include "engine/material_effects.h"
#include "haptics/effects/damping.h"
#include "haptics/effects/effect_program.h"
#include "haptics/effects/stiffness.h"

namespace palpate {
namespace {

// The parameters of an effect among the calls of a material; nothing if it is not called for.
template <typename Effect>
std::optional<typename Effect::Parameters> parameters_of(const EffectProgram& program,
                                                         const MaterialCalls& material) {
  const std::optional<std::uint16_t> number = effect_number(Effect::kName);
  for (const std::uint32_t call : material.calls) {
    if (!number || program.calls[call].effect != *number) continue;
    typename Effect::Parameters parameters;
    std::memcpy(&parameters, program.parameters.data() + program.calls[call].parameters,
                sizeof parameters);
    return parameters;
  }
  return std::nullopt;
}

}  // namespace

std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop) {
  std::vector<SurfaceCoupling> couplings{{"surfaces without their own", loop}};
  const auto& program = scene.world().effects;
  if (!program) return couplings;
  for (const MaterialCalls& material : scene.material_calls()) {
    const auto stiffness = parameters_of<StiffnessEffect>(*program, material);
    const auto damping = parameters_of<DampingEffect>(*program, material);
    if (!stiffness && !damping) continue;
    SurfaceCoupling own{material.material, loop};
    if (stiffness) own.coupling.stiffness_N_per_m = stiffness->stiffness_N_per_m;
    if (damping) own.coupling.damping_Ns_per_m = damping->damping_Ns_per_m;
    couplings.push_back(std::move(own));
  }
  return couplings;
}

Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceMechanics& device,
                                                     const ServoTiming& timing) {
  std::vector<CouplingVerdict> verdicts;
  for (const SurfaceCoupling& surface : couplings) {
    const auto limits = stability_limits(device, surface.coupling.damping_Ns_per_m, timing);
    if (!limits) return limits.error();
    const double stiffness = surface.coupling.stiffness_N_per_m;
    verdicts.push_back(
        {surface, *limits, limits->is_passive(stiffness), limits->is_stable(stiffness)});
  }
  return verdicts;
}

}  // namespace palpate
