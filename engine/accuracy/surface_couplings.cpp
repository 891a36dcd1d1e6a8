#include "engine/accuracy/surface_couplings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "engine/devices/stiffness_zones.h"
#include "engine/scene/material_effects.h"
#include "haptics/effects/damping.h"
#include "haptics/effects/effect_program.h"
#include "haptics/effects/stiffness.h"
#include "haptics/effects/texture.h"

namespace palpate {
namespace {

// A scene whose materials have changed.
struct ChangedScene {
  const EffectProgram& program;
  double scale;  // from lengths of the file to metres
  std::span<const MaterialChange> changes;
};

// The parameters of an effect among the calls of a material; nothing if the material does not
// declare the effect.
template <typename Effect>
std::optional<typename Effect::Parameters> parameters_of(const ChangedScene& scene,
                                                         const MaterialCalls& material) {
  const EffectProgram& program = scene.program;
  const std::optional<std::uint16_t> number = effect_number(Effect::kName);
  for (const std::uint32_t call : material.calls) {
    if (!number || program.calls[call].effect != *number) continue;
    typename Effect::Parameters parameters;
    std::memcpy(&parameters, program.parameters.data() + program.calls[call].parameters,
                sizeof parameters);
    for (const ParameterKey& key : compiled_effects()[*number].keys) {
      for (const MaterialChange& change : scene.changes) {
        if (change.material != material.material || change.key != key.key) continue;
        const double number_m = change.value * (key.scales_as_length ? scene.scale : 1.0);
        std::memcpy(reinterpret_cast<std::byte*>(&parameters) + key.offset, &number_m,
                    sizeof number_m);
      }
    }
    return parameters;
  }
  return std::nullopt;
}

// Largest gradients of the texture coordinates, over all triangles with the texture.
struct UvGradients {
  double u_per_m = 0.0;
  double v_per_m = 0.0;
};

UvGradients largest_gradients(const ContactWorld& world, std::uint32_t texture_call) {
  const EffectProgram& program = *world.effects;
  UvGradients largest;
  for (std::size_t b = 0; b < program.bodies.size(); ++b) {
    const double units_per_metre = std::abs(world.bodies[b].units_per_metre);
    const SurfaceAttributes* attributes = program.bodies[b].attributes;
    if (!attributes) continue;
    for (std::size_t slot = 0; slot < attributes->texture_uv.size(); ++slot) {
      const std::uint32_t material =
          program.material(static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(slot));
      const EffectTable& table =
          program.materials[material].tables[static_cast<std::size_t>(EffectStage::kSurface)];
      if (texture_call < table.first || texture_call >= table.first + table.count) continue;
      const auto& [grad_u, grad_v] = attributes->texture_uv[slot].gradient;
      largest.u_per_m = std::max(largest.u_per_m, units_per_metre * grad_u.norm());
      largest.v_per_m = std::max(largest.v_per_m, units_per_metre * grad_v.norm());
    }
  }
  return largest;
}

// Largest second derivative of the Catmull-Rom spline through four consecutive values, between the
// two middle values. It is linear there, so its maximum is at one of them.
double spline_curvature(const std::array<double, 4>& v) {
  return std::max(std::abs(2.0 * v[0] - 5.0 * v[1] + 4.0 * v[2] - v[3]),
                  std::abs(-v[0] + 4.0 * v[1] - 5.0 * v[2] + 2.0 * v[3]));
}

// Largest curvature of the map along its rows or its columns, per texel squared.
double map_curvature(const HeightMap& map, bool is_along_u) {
  const double du = is_along_u ? 1.0 / map.width() : 0.0;
  const double dv = is_along_u ? 0.0 : 1.0 / map.height();
  double most = 0.0;
  for (std::uint32_t row = 0; row < map.height(); ++row) {
    for (std::uint32_t column = 0; column < map.width(); ++column) {
      const double u = (column + 0.5) / map.width();
      const double v = (row + 0.5) / map.height();
      std::array<double, 4> values{};
      for (int i = 0; i < 4; ++i) {
        values[static_cast<std::size_t>(i)] = map.value(u + (i - 1) * du, v + (i - 1) * dv, 0.0);
      }
      most = std::max(most, spline_curvature(values));
    }
  }
  return most;
}

double relief_per_m(const ContactWorld& world, std::uint32_t texture_call,
                    const TextureEffect::Parameters& texture, MapCurvatures& known) {
  const UvGradients gradients = largest_gradients(world, texture_call);
  const double columns_per_m = gradients.u_per_m * texture.map->width();
  const double rows_per_m = gradients.v_per_m * texture.map->height();
  const HeightMap& map = *texture.map;
  auto [found, is_new] = known.try_emplace(&map);
  if (is_new) found->second = {map_curvature(map, true), map_curvature(map, false)};
  const auto [along_u, along_v] = found->second;
  return texture.height_m *
         std::max(along_u * columns_per_m * columns_per_m, along_v * rows_per_m * rows_per_m);
}

// 0 if the material has no texture.
double relief_of(const ContactWorld& world, const ChangedScene& scene,
                 const MaterialCalls& material, MapCurvatures& known) {
  const std::optional<std::uint16_t> number = effect_number(TextureEffect::kName);
  for (const std::uint32_t call : material.calls) {
    if (!number || scene.program.calls[call].effect != *number) continue;
    const auto texture = parameters_of<TextureEffect>(scene, material);
    if (texture && texture->map) return relief_per_m(world, call, *texture, known);
  }
  return 0.0;
}

}  // namespace

std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop,
                                          std::span<const MaterialChange> changes,
                                          MapCurvatures* known) {
  MapCurvatures of_this_call;
  std::vector<SurfaceCoupling> couplings{{"surfaces without their own", loop}};
  const auto& program = scene.world().effects;
  if (!program) return couplings;
  const ChangedScene changed{*program, scene.statistics().scale, changes};
  for (const MaterialCalls& material : scene.material_calls()) {
    const auto stiffness = parameters_of<StiffnessEffect>(changed, material);
    const auto damping = parameters_of<DampingEffect>(changed, material);
    const double relief =
        relief_of(scene.world(), changed, material, known ? *known : of_this_call);
    if (!stiffness && !damping && relief == 0.0) continue;
    SurfaceCoupling own{material.material, loop, relief};
    if (stiffness) own.coupling.stiffness_N_per_m = stiffness->stiffness_N_per_m;
    if (damping) own.coupling.damping_Ns_per_m = damping->damping_Ns_per_m;
    couplings.push_back(std::move(own));
  }
  return couplings;
}

Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceDescription& device,
                                                     const ServoTiming& timing, double depth_m) {
  std::vector<CouplingVerdict> verdicts;
  for (const SurfaceCoupling& surface : couplings) {
    const auto limits =
        stability_limits(wall_mechanics(device), surface.coupling.damping_Ns_per_m, timing);
    if (!limits) return limits.error();
    const auto zones = stiffness_zones(device, surface.coupling.damping_Ns_per_m, timing.period_s,
                                       surface.coupling.velocity);
    if (!zones) return zones.error();
    const double stiffness = surface.effective_stiffness_N_per_m(depth_m);
    verdicts.push_back({surface, stiffness, *limits, limits->is_passive(stiffness),
                        limits->is_stable(stiffness), *zones});
  }
  return verdicts;
}

}  // namespace palpate
