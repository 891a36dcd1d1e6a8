// Tests that the JSON Schema of extras.palpate agrees with the engine: keys, units, ranges, choices
// and defaults. PALPATE_SCHEMA is the path of the schema.

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/scene/material_effects.h"
#include "engine/scene/surroundings.h"

namespace palpate {
namespace {

using nlohmann::json;

json schema() {
  std::ifstream file(PALPATE_SCHEMA);
  return json::parse(file);
}

void expect_range(const json& number, const ParameterKey& key) {
  const char* least = key.least_is_excluded ? "exclusiveMinimum" : "minimum";
  const char* other = key.least_is_excluded ? "minimum" : "exclusiveMinimum";
  EXPECT_EQ(number["type"], "number");
  EXPECT_EQ(number[least], key.least);
  EXPECT_EQ(number["maximum"], key.most);
  EXPECT_FALSE(number.contains(other));
  EXPECT_FALSE(number.contains("exclusiveMaximum"));
}

void expect_description(const json& property, const ParameterKey& key) {
  EXPECT_EQ(property.value("unit", ""), key.unit);
  EXPECT_TRUE(property["description"].get<std::string>().starts_with(key.what))
      << property["description"];
}

void expect_list(const json& property, const ParameterKey& key) {
  SCOPED_TRACE(key.key);
  expect_description(property, key);
  EXPECT_EQ(property["type"], "array");
  EXPECT_EQ(property["minItems"], 3);
  EXPECT_EQ(property["maxItems"], 3);
  expect_range(property["items"], key);
}

void expect_default(const json& property, const ParameterKey& key, const EffectType& type) {
  if (key.role != ParameterKey::Role::kOptional) {
    EXPECT_FALSE(property.contains("default"));
    return;
  }
  std::vector<std::byte> parameters(type.parameter_bytes);
  type.begin_parameters(parameters.data());
  double number = 0.0;
  std::memcpy(&number, parameters.data() + key.offset, sizeof number);
  if (key.kind == ParameterKey::Kind::kChoice) {
    EXPECT_EQ(property["default"], key.choices[static_cast<std::size_t>(number)]);
  } else {
    EXPECT_EQ(property["default"], number);
  }
}

std::set<std::string> keys_of(const json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

TEST(ExtrasSchema, HasTheKeysOfTheEffects) {
  const json properties = schema()["$defs"]["material"]["properties"];
  std::set<std::string> keys{std::string(kSolidKey)};
  for (const EffectKeyName& name : effect_key_names()) keys.emplace(name.key);
  EXPECT_EQ(keys_of(properties), keys);
  EXPECT_EQ(properties["solid"]["enum"], json({true, false, 1, 0}));
  EXPECT_EQ(properties["solid"]["default"], true);
  for (const EffectType& type : compiled_effects()) {
    for (const ParameterKey& key : type.keys) {
      SCOPED_TRACE(key.key);
      const json& property = properties[std::string(key.key)];
      expect_description(property, key);
      expect_default(property, key, type);
      if (key.kind == ParameterKey::Kind::kChoice) {
        EXPECT_EQ(property["enum"], json(key.choices));
      } else {
        expect_range(property, key);
      }
    }
  }
}

// {"if": key is given and matches `is`, "then": other is given}
json demand(const std::string& key, const json& is, const std::string& other) {
  return {{"if", {{"properties", {{key, is}}}, {"required", {key}}}},
          {"then", {{"required", {other}}}}};
}

TEST(ExtrasSchema, RequiresTheKeysThatEffectsRequire) {
  const json above_zero = {{"exclusiveMinimum", 0}};
  std::vector<json> demands;
  for (const EffectType& type : compiled_effects()) {
    for (const ParameterKey& switching : type.keys) {
      if (switching.role != ParameterKey::Role::kDeclares) continue;
      for (const ParameterKey& key : type.keys) {
        if (key.role != ParameterKey::Role::kRequired) continue;
        demands.push_back(demand(std::string(switching.key), above_zero, std::string(key.key)));
      }
    }
  }
  EXPECT_GE(demands.size(), 2u);
  json medium = demand("solid", {{"enum", {false, 0}}}, "viscosity");
  medium["then"]["properties"]["viscosity"] = above_zero;
  demands.push_back(medium);
  const json stated = schema()["$defs"]["material"]["allOf"];
  EXPECT_EQ(stated.size(), demands.size());
  for (const json& d : demands) EXPECT_EQ(std::count(stated.begin(), stated.end(), d), 1) << d;
}

// The form is the one that io/gltf/extras.cpp checks.
TEST(ExtrasSchema, LimitsTheFormOfKeys) {
  const json defs = schema()["$defs"];
  for (const char* part : {"material", "scene", "node"}) {
    EXPECT_EQ(defs[part]["propertyNames"], json({{"maxLength", 32}, {"pattern", "^[^.]*$"}}))
        << part;
  }
}

TEST(ExtrasSchema, HasTheKeysOfScenesAndNodes) {
  const json scene = schema()["$defs"]["scene"]["properties"];
  EXPECT_EQ(keys_of(scene), (std::set<std::string>{"gravity", "toolMass", "constantForce"}));
  for (const ParameterKey& key : scene_keys()) {
    const json& property = scene[std::string(key.key)];
    if (key.key != "toolMass") {
      expect_list(property, key);
    } else {
      expect_description(property, key);
      expect_range(property, key);
    }
  }
  const json node = schema()["$defs"]["node"]["properties"];
  EXPECT_EQ(keys_of(node), (std::set<std::string>{"medium", "size", "radius", "viscosity"}));
  EXPECT_EQ(node["medium"]["enum"], json(kMediumShapes));
  expect_list(node["size"], region_keys()[0]);
  expect_description(node["radius"], region_keys()[1]);
  expect_range(node["radius"], region_keys()[1]);
  expect_description(node["viscosity"], ViscosityEffect::kKeys[0]);
  expect_range(node["viscosity"], ViscosityEffect::kKeys[0]);
}

}  // namespace
}  // namespace palpate
