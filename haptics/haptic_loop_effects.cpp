// The steps of worlds that have effects, one for each union of needs.

#include <array>
#include <utility>

#include "haptics/haptic_loop_steps.h"

namespace palpate {

HapticLoop::Step HapticLoop::step_with_effects(std::uint32_t needs) {
  // The step without any needs is compiled in another file, as if there were no effects.
  static constexpr auto kSteps = []<std::uint32_t... kBelow>(
                                     std::integer_sequence<std::uint32_t, kBelow...>) {
    return std::array<Step, sizeof...(kBelow)>{&HapticLoop::step<kBelow + 1>...};
  }(std::make_integer_sequence<std::uint32_t, kStepNeeds>());
  return kSteps[(needs & kStepNeeds) - 1];
}

}  // namespace palpate
