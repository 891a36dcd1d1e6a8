#include "engine/scene/extras_keys.h"

#include <string>
#include <utility>
#include <vector>

#include "engine/scene/material_effects.h"
#include "engine/scene/surroundings.h"

namespace palpate {
namespace {

std::vector<KeyName> every_key() {
  std::vector<KeyName> keys{{std::string(kSolidKey), kOfMaterial},
                            {std::string(kMediumKey), kOfNode}};
  for (const EffectKeyName& key : effect_key_names()) {
    const bool is_of_media = key.key == ViscosityEffect::kKeys[0].key;
    keys.push_back({std::string(key.key), is_of_media ? kOfMaterial | kOfNode : kOfMaterial});
  }
  for (const ParameterKey& key : scene_keys()) keys.push_back({std::string(key.key), kOfScene});
  for (const ParameterKey& key : region_keys()) keys.push_back({std::string(key.key), kOfNode});
  return keys;
}

}  // namespace

const KeyNames& extras_keys() {
  static const KeyNames names(every_key());
  return names;
}

}  // namespace palpate
