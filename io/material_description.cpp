#include "io/material_description.h"

#include <algorithm>

namespace palpate {
namespace {

const TextureReference* first_map(const HapticMaterialDescription* haptic, const char* property) {
  if (haptic == nullptr) return nullptr;
  const auto map = std::find_if(haptic->maps.begin(), haptic->maps.end(),
                                [&](const HapticMap& m) { return m.property == property; });
  return map == haptic->maps.end() ? nullptr : &map->texture;
}

}  // namespace

const TextureReference* texture_map(const MaterialDescription& material,
                                    const HapticMaterialDescription* haptic) {
  if (const TextureReference* map = first_map(haptic, "vibrotactileTexture")) return map;
  const bool wants_texture =
      std::any_of(material.parameters.begin(), material.parameters.end(),
                  [](const MaterialParameter& p) { return p.key == "textureHeight"; });
  return wants_texture && material.normal_texture ? &*material.normal_texture : nullptr;
}

const TextureReference* friction_map(const HapticMaterialDescription* haptic) {
  return first_map(haptic, "friction");
}

}  // namespace palpate
