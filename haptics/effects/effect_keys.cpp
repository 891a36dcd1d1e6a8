#include "haptics/effects/effect_keys.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "compiled_effects.h"  // of the library, which has all effects

namespace palpate {
namespace {

template <typename... Effects>
constexpr auto names_of(EffectList<Effects...>) {
  std::array<EffectKeyName, (std::size(Effects::kKeys) + ... + 0)> names;
  auto next = names.begin();
  const auto add = [&](std::string_view effect, std::span<const ParameterKey> keys) {
    const bool has_declaring_key = std::any_of(keys.begin(), keys.end(), [](const auto& key) {
      return key.role == ParameterKey::Role::kDeclares;
    });
    for (const ParameterKey& key : keys) *next++ = {key.key, effect, has_declaring_key};
  };
  (add(Effects::kName, Effects::kKeys), ...);
  return names;
}

constexpr auto kNames = names_of(CompiledEffects());

}  // namespace

std::span<const EffectKeyName> effect_key_names() noexcept {
  return kNames;
}

}  // namespace palpate
