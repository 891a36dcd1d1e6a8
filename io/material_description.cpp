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

// The parameter "textureHeight"; null if absent.
const MaterialParameter* texture_height(const MaterialDescription& material) {
  const auto& parameters = material.parameters;
  const auto height =
      std::find_if(parameters.begin(), parameters.end(),
                   [](const MaterialParameter& p) { return p.key == "textureHeight"; });
  return height == parameters.end() ? nullptr : &*height;
}

}  // namespace

const TextureReference* texture_map(const MaterialDescription& material,
                                    const HapticMaterialDescription* haptic) {
  if (is_flat(material)) return nullptr;
  if (const TextureReference* map = first_map(haptic, "vibrotactileTexture")) return map;
  const bool wants_texture = texture_height(material) != nullptr;
  return wants_texture && material.normal_texture ? &*material.normal_texture : nullptr;
}

const TextureReference* friction_map(const HapticMaterialDescription* haptic) {
  return first_map(haptic, "friction");
}

bool is_flat(const MaterialDescription& material) {
  const MaterialParameter* height = texture_height(material);
  const double* number = height ? std::get_if<double>(&height->value) : nullptr;
  return number && *number == 0.0;
}

}  // namespace palpate
