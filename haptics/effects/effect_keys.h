#pragma once

// The parameter keys of all effects of the project, including effects that are not in a program.

#include <span>
#include <string_view>

namespace palpate {

struct EffectKeyName {
  std::string_view key;
  std::string_view effect;
  bool zero_is_none = true;  // the value 0 does not declare the effect
};

// In the order of PALPATE_EFFECTS and of each effect's keys.
std::span<const EffectKeyName> effect_key_names() noexcept;

}  // namespace palpate
