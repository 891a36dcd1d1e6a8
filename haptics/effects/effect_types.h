#pragma once

// Builds the run-time table of effects from their types.

#include <array>
#include <cstring>
#include <new>
#include <type_traits>

#include "haptics/effects/effect.h"

namespace palpate {

template <typename Effect>
constexpr EffectDistance effect_distance() {
  if constexpr ((Effect::kNeeds & kNeedsPlace) != 0) {
    return [](const std::byte* p, const std::byte* s, const EffectTick& tick) noexcept {
      return Effect::distance_m(
          *std::launder(reinterpret_cast<const typename Effect::Parameters*>(p)),
          *std::launder(reinterpret_cast<const typename Effect::State*>(s)), tick);
    };
  } else {
    return nullptr;
  }
}

template <typename Effect>
constexpr EffectType effect_type() {
  using Parameters = typename Effect::Parameters;
  using State = typename Effect::State;
  static_assert(std::is_trivially_copyable_v<Parameters> && std::is_trivially_copyable_v<State>,
                "parameters and states are copied as bytes: use arrays of numbers, not Vec3");
  static_assert(alignof(Parameters) <= alignof(double) && alignof(State) <= alignof(double));
  // A table runs only in a scene whose needs include its stage.
  constexpr std::uint32_t kStageNeed =
      Effect::kStage == EffectStage::kSurroundings ? kNeedsSurroundings : kNeedsContact;
  static_assert((Effect::kNeeds & kStageNeed) != 0);
  static_assert(Effect::kStage != EffectStage::kProxy || (Effect::kNeeds & kNeedsStickSlip) != 0);
  return {Effect::kName,
          Effect::kStage,
          Effect::kNeeds,
          sizeof(Parameters),
          sizeof(State),
          [](std::byte* p) noexcept { new (p) Parameters{}; },
          [](std::byte* s) noexcept { new (s) State{}; },
          Effect::kKeys,
          [](const std::byte* p) noexcept {
            return Effect::contradiction(*std::launder(reinterpret_cast<const Parameters*>(p)));
          },
          [](const std::byte* p, std::byte* s, EffectTick& tick) noexcept {
            return Effect::apply(*std::launder(reinterpret_cast<const Parameters*>(p)),
                                 *std::launder(reinterpret_cast<State*>(s)), tick);
          },
          effect_distance<Effect>()};
}

template <typename... Effects>
struct EffectList {
  static_assert(sizeof...(Effects) <= kMostEffects);
  static constexpr std::array<EffectType, sizeof...(Effects)> kTypes = {effect_type<Effects>()...};
  static constexpr std::uint32_t kNeeds = (kNeedsNothing | ... | Effects::kNeeds);
};

}  // namespace palpate
