#pragma once

// Effect programs that are assembled directly, without a scene.

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/effects/effect_program.h"
#include "haptics/effects/friction.h"

namespace palpate::test {

template <typename Effect>
std::uint16_t effect_number() {
  const auto types = compiled_effects();
  const auto found = std::find_if(types.begin(), types.end(), [](const EffectType& type) {
    return type.name == Effect::kName;
  });
  return static_cast<std::uint16_t>(found - types.begin());
}

template <typename Effect>
EffectProgramBuilder::Entry effect_entry(const typename Effect::Parameters& parameters) {
  EffectProgramBuilder::Entry entry{effect_number<Effect>(), {}};
  entry.parameters.resize(sizeof parameters);
  std::memcpy(entry.parameters.data(), &parameters, sizeof parameters);
  return entry;
}

// Bodies with one material each.
class EffectBodies {
 public:
  EffectProgramBuilder builder;

  // Adds a body whose whole surface has these effects. attributes: those that the effects need.
  void add_body(const std::vector<EffectProgramBuilder::Entry>& entries,
                SurfaceAttributes attributes = {}) {
    EffectProgram& program = builder.program;
    program.attributes.push_back(std::move(attributes));
    program.bodies.push_back(
        {&program.attributes.back(), static_cast<std::uint32_t>(program.material_of_part.size())});
    program.material_of_part.push_back(builder.add_material(entries));
  }
  // Adds a body without effects.
  void add_body_without_effects() { builder.program.bodies.emplace_back(); }

  std::shared_ptr<const EffectProgram> finish() {
    return std::make_shared<const EffectProgram>(std::move(builder).finish());
  }
};

inline std::shared_ptr<const EffectProgram> with_friction(double static_friction,
                                                          double dynamic_friction) {
  EffectBodies bodies;
  bodies.add_body({effect_entry<FrictionEffect>({static_friction, dynamic_friction, nullptr})});
  return bodies.finish();
}

}  // namespace palpate::test
