#include "haptics/effects/effect_types.h"

#include "compiled_effects.h"

namespace palpate {

std::span<const EffectType> compiled_effects() noexcept {
  return CompiledEffects::kTypes;
}

}  // namespace palpate
