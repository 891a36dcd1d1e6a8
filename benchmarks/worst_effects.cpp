#include "benchmarks/worst_effects.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "haptics/effects/effect_program.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/viscosity.h"

namespace palpate::bench {
namespace {

// As in engine/scene/scene_effects.h.
constexpr std::size_t kMostPlaces = 256;

template <typename Effect>
EffectProgramBuilder::Entry entry_of(const typename Effect::Parameters& parameters) {
  const auto effects = compiled_effects();
  const auto effect = std::find_if(effects.begin(), effects.end(), [](const EffectType& type) {
    return type.name == Effect::kName;
  });
  EffectProgramBuilder::Entry entry{static_cast<std::uint16_t>(effect - effects.begin()), {}};
  entry.parameters.resize(sizeof parameters);
  std::memcpy(entry.parameters.data(), &parameters, sizeof parameters);
  return entry;
}

// The map from the solver frame to the frame of a body's index.
AffineMap map_index_solver(const ContactBody& body) {
  const auto index_of = [&](const Vec3& p) { return body.to_index(body.to_body(p)); };
  AffineMap map;
  map.translation_m = index_of(Vec3::Zero());
  for (int k = 0; k < 3; ++k) map.linear.col(k) = index_of(Vec3::Unit(k)) - map.translation_m;
  return map;
}

std::shared_ptr<const EffectProgram> program_of(const ContactWorld& world, EffectKind kind) {
  EffectProgramBuilder builder;
  builder.program.bodies.resize(world.bodies.size());
  const std::size_t count = std::min(world.bodies.size(), kMostPlaces);
  for (std::uint32_t b = 0; b < count; ++b) {
    const ContactBody& body = world.bodies[b];
    if (kind == EffectKind::kMagnets) {
      builder.program.magnets.push_back({b, 0, body.index});
      builder.add_surroundings(
          entry_of<MagnetEffect>({1.0, 2.0 * world.size_m, &builder.program.magnets.back()}));
    } else {
      MediumRegion region;
      region.shape = MediumRegion::Shape::kThrough;
      region.index = body.index;
      region.p_region_solver = map_index_solver(body);
      builder.program.media.push_back(region);
      builder.add_surroundings(entry_of<ViscosityEffect>({1.0, &builder.program.media.back()}));
    }
  }
  return std::make_shared<const EffectProgram>(std::move(builder).finish());
}

}  // namespace

std::string_view name_of(EffectKind kind) {
  return kind == EffectKind::kNone ? "none" : kind == EffectKind::kMagnets ? "magnets" : "media";
}

WorstEffects::WorstEffects(const WorstInput& input, EffectKind kind,
                           const GodObjectSettings& settings)
    : world_(input.world) {
  if (kind == EffectKind::kNone) return;
  world_.effects = program_of(world_, kind);
  runner_ = std::make_unique<EffectRunner>(world_, settings, CouplingSettings{}, false);
}

WorkUnits WorstEffects::run(const LiveWorld& world, const ProxyState& state) {
  if (!runner_) return 0;
  EffectMotion motion;
  motion.dt_s = motion.longest_dt_s = 1e-3;
  motion.velocity_m_per_s = Vec3(0.1, 0.0, 0.0);
  runner_->begin_tick();
  runner_->surroundings_force_N(world, state, Vec3::Zero(), motion);
  runner_->end_tick();
  return runner_->work().used();
}

}  // namespace palpate::bench
