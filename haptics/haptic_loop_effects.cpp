// The steps of worlds with effects: one for each union of needs that the compiled effects can have.

#include <array>
#include <utility>

#include "compiled_effects.h"
#include "haptics/haptic_loop_steps.h"

namespace palpate {

HapticLoop::Step HapticLoop::step_with_effects(std::uint32_t needs) {
  constexpr auto step_for = []<std::uint32_t kNeeds>() -> Step {
    // The step without needs is compiled in haptic_loop.cpp, as in a program without effects.
    if constexpr (kNeeds == kNeedsNothing || (kNeeds & ~CompiledEffects::kNeeds) != 0) {
      return nullptr;
    } else {
      return &HapticLoop::step<kNeeds>;
    }
  };
  static constexpr auto kSteps = [=
  ]<std::uint32_t... kNeeds>(std::integer_sequence<std::uint32_t, kNeeds...>) {
    return std::array<Step, sizeof...(kNeeds)>{step_for.template operator()<kNeeds>()...};
  }
  (std::make_integer_sequence<std::uint32_t, kStepNeeds + 1>());
  return kSteps[needs & kStepNeeds];
}

}  // namespace palpate
