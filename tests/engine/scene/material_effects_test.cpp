// Tests the effects compiled from a material's declarations, and the report of the declarations.

#include "engine/scene/material_effects.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/material_parameters.h"
#include "engine/scene/surroundings.h"
#include "haptics/effects/friction.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/restitution.h"
#include "haptics/effects/texture.h"
#include "haptics/effects/vibration.h"

namespace palpate {
namespace {

constexpr const char* kExtras = "/materials/2/extras/palpate";

MaterialParameter given(const std::string& key, MaterialValue value) {
  return {key, std::move(value), std::string(kExtras) + "/" + key};
}

MaterialDescription material_with(std::vector<MaterialParameter> parameters) {
  return {"wood", "/materials/2", std::move(parameters), std::nullopt};
}

HapticMaterialDescription haptic_with(const std::vector<std::string>& properties) {
  HapticMaterialDescription haptic{"felt", {}};
  for (std::size_t i = 0; i < properties.size(); ++i) {
    TextureReference texture;
    texture.texture = static_cast<std::uint32_t>(i);
    haptic.maps.push_back({properties[i], "Other", texture, "/maps/" + std::to_string(i)});
  }
  return haptic;
}

MaterialEffects compiled_material(const MaterialSources& sources) {
  auto effects = material_effects(sources);
  EXPECT_TRUE(effects) << effects.error().to_string();
  return effects ? std::move(*effects) : MaterialEffects{};
}

MaterialEffects compiled_material(std::vector<MaterialParameter> parameters) {
  const MaterialDescription material = material_with(std::move(parameters));
  return compiled_material(MaterialSources{&material});
}

Error refused(const MaterialSources& sources) {
  const auto effects = material_effects(sources);
  EXPECT_FALSE(effects);
  return effects ? Error{} : effects.error();
}

Error refused(std::vector<MaterialParameter> parameters) {
  const MaterialDescription material = material_with(std::move(parameters));
  return refused(MaterialSources{&material});
}

void expect_names(const Error& error, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    EXPECT_NE(error.to_string().find(name), std::string::npos)
        << "no " << name << " in: " << error.to_string();
  }
}

template <typename Effect>
typename Effect::Parameters parameters_of(const MaterialEffects& effects) {
  typename Effect::Parameters parameters;
  const auto* entry = effects.entry(Effect::kName);
  EXPECT_TRUE(entry) << Effect::kName;
  if (entry) std::memcpy(&parameters, entry->parameters.data(), sizeof parameters);
  return parameters;
}

// "key=value source" of each parameter, with the value in JSON notation.
std::vector<std::string> texts_of(const std::vector<HonouredParameter>& list) {
  std::vector<std::string> texts;
  for (const auto& p : list) {
    texts.push_back(p.key + "=" + value_text(p.value) + " " + p.source + (p.is_off ? " off" : ""));
  }
  std::sort(texts.begin(), texts.end());
  return texts;
}
std::vector<std::string> texts_of(const std::vector<DefaultedParameter>& list) {
  std::vector<std::string> texts;
  for (const auto& p : list) texts.push_back(p.key + "=" + value_text(p.value) + p.unit);
  std::sort(texts.begin(), texts.end());
  return texts;
}
std::vector<std::string> texts_of(const std::vector<IgnoredParameter>& list) {
  std::vector<std::string> texts;
  for (const auto& p : list) texts.push_back(p.key + " " + p.element);
  std::sort(texts.begin(), texts.end());
  return texts;
}

using Texts = std::vector<std::string>;

TEST(MaterialEffects, AreEmptyForAnEmptyDeclaration) {
  const MaterialEffects effects = compiled_material(std::vector<MaterialParameter>{});
  EXPECT_TRUE(effects.entries.empty());
  EXPECT_TRUE(effects.is_solid);
  EXPECT_TRUE(effects.report.empty());
}

// For every number of every effect: both limits are accepted; an error names a number beyond them.
TEST(MaterialEffects, AcceptEveryNumberInItsRangeOnly) {
  for (const EffectType& type : compiled_effects()) {
    for (const ParameterKey& key : type.keys) {
      if (key.kind != ParameterKey::Kind::kNumber) continue;
      SCOPED_TRACE(key.key);
      const std::string name(key.key);
      const double infinity = std::numeric_limits<double>::infinity();
      std::vector<MaterialValue> wrong = {std::nextafter(key.least, -infinity),
                                          std::nextafter(key.most, infinity),
                                          std::nan(""),
                                          infinity,
                                          true,
                                          std::string("much"),
                                          std::vector<double>{1.0}};
      if (key.least_is_excluded) wrong.emplace_back(key.least);
      for (const MaterialValue& value : wrong) {
        const Error error = refused({given(name, value)});
        EXPECT_EQ(error.code, ErrorCode::kInvalidContent);
        EXPECT_EQ(error.element, std::string(kExtras) + "/" + name);
        expect_names(
            error, {"wood", name, value_text(value), value_text(key.most), std::string(key.unit)});
      }
      for (const double good : {key.least, key.most, 0.5 * (key.least + key.most)}) {
        if (good == key.least && key.least_is_excluded) continue;
        const auto number = checked_number("material", given(name, good), key);
        ASSERT_TRUE(number) << good;
        EXPECT_EQ(*number, good);
      }
    }
  }
}

TEST(MaterialEffects, AcceptChoicesByName) {
  const auto hum = [](MaterialValue when) {
    return std::vector<MaterialParameter>{given("vibrationFrequency", 50.0),
                                          given("vibrationAmplitude", 0.2),
                                          given("vibrationWhen", std::move(when))};
  };
  EXPECT_EQ(parameters_of<VibrationEffect>(compiled_material(hum(std::string("contact")))).when,
            0.0);
  EXPECT_EQ(parameters_of<VibrationEffect>(compiled_material(hum(std::string("sliding")))).when,
            1.0);
  for (const MaterialValue& wrong :
       {MaterialValue(std::string("never")), MaterialValue(1.0), MaterialValue(true)}) {
    expect_names(refused(hum(wrong)),
                 {"wood", "vibrationWhen", "\"contact\" or \"sliding\"", "/materials/2/"});
  }
}

TEST(MaterialEffects, AreActiveIfTheirKeyIsNotZero) {
  const MaterialEffects off =
      compiled_material({given("magnetForce", 0.0), given("magnetRange", 0.1),
                         given("restitution", 0.0), given("viscosity", -0.0)});
  EXPECT_TRUE(off.entries.empty());
  EXPECT_EQ(texts_of(off.report.honoured),
            (Texts{"magnetForce=0 extras.palpate off", "magnetRange=0.1 extras.palpate off",
                   "restitution=0 extras.palpate off", "viscosity=-0 extras.palpate off"}));
  EXPECT_TRUE(off.report.defaulted.empty());
  // An effect without a key of the role kDeclares is active if its required key is given.
  EXPECT_EQ(compiled_material({given("stiffness", 0.0), given("damping", 0.0)}).effect_names(),
            (Texts{"damping", "stiffness"}));
  EXPECT_EQ(
      compiled_material({given("magnetForce", 2.0), given("magnetRange", 0.1)}).effect_names(),
      Texts{"magnet"});
}

TEST(MaterialEffects, RefuseAnIncompleteDeclaration) {
  expect_names(refused({given("impactMass", 0.1)}),
               {"wood", "impactMass is given without restitution",
                "/materials/2/extras/palpate/impactMass"});
  expect_names(refused({given("magnetForce", 1.0)}),
               {"magnetForce is given without magnetRange", "1000 m", "/magnetForce"});
  expect_names(refused({given("magnetRange", 1.0)}), {"magnetRange is given without magnetForce"});
  expect_names(refused({given("vibrationWhen", std::string("sliding"))}),
               {"vibrationWhen is given without vibrationAmplitude"});
  expect_names(refused({given("vibrationAmplitude", 1.0)}),
               {"vibrationAmplitude is given without vibrationFrequency", "5000 Hz"});
}

TEST(MaterialEffects, ReportEveryDefault) {
  const MaterialEffects tap = compiled_material({given("restitution", 0.5)});
  EXPECT_EQ(texts_of(tap.report.defaulted), (Texts{"impactDuration=0.005s", "impactMass=0.05kg"}));
  EXPECT_EQ(parameters_of<RestitutionEffect>(tap).mass_kg, 0.05);
  const MaterialEffects hum =
      compiled_material({given("vibrationFrequency", 50.0), given("vibrationAmplitude", 0.2)});
  EXPECT_EQ(texts_of(hum.report.defaulted), Texts{"vibrationWhen=\"contact\""});
}

TEST(MaterialEffects, UseASingleFrictionCoefficientForBoth) {
  for (const char* key : {"staticFriction", "dynamicFriction"}) {
    const MaterialEffects effects = compiled_material({given(key, 0.3)});
    const auto friction = parameters_of<FrictionEffect>(effects);
    EXPECT_EQ(friction.static_friction, 0.3);
    EXPECT_EQ(friction.dynamic_friction, 0.3);
    EXPECT_EQ(texts_of(effects.report.honoured), Texts{std::string(key) + "=0.3 extras.palpate"});
    ASSERT_EQ(effects.report.defaulted.size(), 1u);
    EXPECT_NE(effects.report.defaulted[0].key, key);
  }
  EXPECT_TRUE(compiled_material({given("staticFriction", 0.0)}).entries.empty());
}

TEST(MaterialEffects, RefuseFrictionThatGrowsWhileSliding) {
  expect_names(refused({given("staticFriction", 0.2), given("dynamicFriction", 0.3)}),
               {"wood", "dynamicFriction is larger than staticFriction", "/staticFriction",
                "/dynamicFriction"});
}

TEST(MaterialEffects, UsePhysicsForKeysThatTheMaterialLacks) {
  const PhysicsMaterialDescription physics{0.5, 0.4, 0.3};
  const MaterialDescription material =
      material_with({given("dynamicFriction", 0.2),
                     {"restitution", 0.9, "`SceneSettings::overrides` wood.restitution"}});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, &physics, "/physics/1"});
  const auto friction = parameters_of<FrictionEffect>(effects);
  EXPECT_EQ(friction.static_friction, 0.5);
  EXPECT_EQ(friction.dynamic_friction, 0.2);
  EXPECT_EQ(parameters_of<RestitutionEffect>(effects).restitution, 0.9);
  EXPECT_EQ(texts_of(effects.report.honoured),
            (Texts{"dynamicFriction=0.2 extras.palpate", "restitution=0.9 override",
                   "staticFriction=0.5 KHR_physics_rigid_bodies"}));
}

TEST(MaterialEffects, HaveNoRestitutionIfPhysicsHasNone) {
  const PhysicsMaterialDescription physics{0.0, 0.0, 0.0};
  const MaterialDescription material = material_with({});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, &physics, "/physics/1"});
  EXPECT_TRUE(effects.entries.empty());
  EXPECT_EQ(texts_of(effects.report.honoured),
            (Texts{"dynamicFriction=0 KHR_physics_rigid_bodies off",
                   "restitution=0 KHR_physics_rigid_bodies off",
                   "staticFriction=0 KHR_physics_rigid_bodies off"}));
}

// Tests the defaults of KHR_physics_rigid_bodies for coefficients that are not written.
TEST(MaterialEffects, AdaptUnwrittenPhysicsToTheWrittenCoefficient) {
  constexpr std::nullopt_t kNone = std::nullopt;
  const std::string physics_source = " KHR_physics_rigid_bodies";
  const struct {
    PhysicsMaterialDescription physics;
    std::vector<MaterialParameter> parameters;
    double still, sliding;
    Texts honoured, defaulted;
  } cases[] = {
      {{}, {}, 0.6, 0.6, {}, {"dynamicFriction=0.6", "staticFriction=0.6"}},
      {{kNone, kNone, 0.0},
       {},
       0.6,
       0.6,
       {"restitution=0" + physics_source + " off"},
       {"dynamicFriction=0.6", "staticFriction=0.6"}},
      {{0.3}, {}, 0.3, 0.3, {"staticFriction=0.3" + physics_source}, {"dynamicFriction=0.3"}},
      {{0.9}, {}, 0.9, 0.6, {"staticFriction=0.9" + physics_source}, {"dynamicFriction=0.6"}},
      {{kNone, 0.3},
       {},
       0.6,
       0.3,
       {"dynamicFriction=0.3" + physics_source},
       {"staticFriction=0.6"}},
      {{kNone, 0.9},
       {},
       0.9,
       0.9,
       {"dynamicFriction=0.9" + physics_source},
       {"staticFriction=0.9"}},
      {{},
       {given("staticFriction", 0.2)},
       0.2,
       0.2,
       {"staticFriction=0.2 extras.palpate"},
       {"dynamicFriction=0.2"}},
      {{0.3},
       {given("staticFriction", 0.2)},
       0.2,
       0.2,
       {"staticFriction=0.2 extras.palpate"},
       {"dynamicFriction=0.2"}},
      {{},
       {given("dynamicFriction", 0.8)},
       0.8,
       0.8,
       {"dynamicFriction=0.8 extras.palpate"},
       {"staticFriction=0.8"}},
  };
  for (const auto& c : cases) {
    const MaterialDescription material = material_with(c.parameters);
    const MaterialEffects effects =
        compiled_material(MaterialSources{&material, &c.physics, "/physics/1"});
    SCOPED_TRACE(testing::PrintToString(texts_of(effects.report.honoured)));
    const auto friction = parameters_of<FrictionEffect>(effects);
    EXPECT_EQ(friction.static_friction, c.still);
    EXPECT_EQ(friction.dynamic_friction, c.sliding);
    EXPECT_EQ(texts_of(effects.report.honoured), c.honoured);
    EXPECT_EQ(texts_of(effects.report.defaulted), c.defaulted);
  }
}

TEST(MaterialEffects, SwitchUnwrittenPhysicsOffIfStaticFrictionIsZero) {
  const PhysicsMaterialDescription physics;
  const MaterialDescription material = material_with({given("staticFriction", 0.0)});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, &physics, "/physics/1"});
  EXPECT_TRUE(effects.entries.empty());
  EXPECT_EQ(texts_of(effects.report.honoured), Texts{"staticFriction=0 extras.palpate off"});
  EXPECT_EQ(texts_of(effects.report.defaulted), Texts{"dynamicFriction=0"});
}

TEST(MaterialEffects, NameBothSourcesThatContradictEachOther) {
  const PhysicsMaterialDescription physics{0.6, 0.6};
  const MaterialDescription material = material_with({given("staticFriction", 0.3)});
  const Error error = refused(MaterialSources{&material, &physics, "/physics/1"});
  EXPECT_EQ(error.element, std::string(kExtras) + "/staticFriction");
  expect_names(error, {"wood", "staticFriction 0.3", "/physics/1/dynamicFriction", "0.6"});
}

TEST(MaterialEffects, ReportAWrongOverrideAsAnInvalidArgument) {
  const Error error = refused({{"stiffness", -1.0, "`SceneSettings::overrides` wood.stiffness"}});
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(error.element, "`SceneSettings::overrides` wood.stiffness");
}

TEST(MaterialEffects, UseDefaultsForMapsWithoutValues) {
  const HapticMaterialDescription haptic =
      haptic_with({"vibrotactileTexture", "friction", "stiffness", "friction"});
  const MaterialDescription material = material_with({});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, nullptr, "", &haptic, /*scale=*/10.0});
  EXPECT_EQ(effects.effect_names(), (Texts{"friction", "texture"}));
  EXPECT_EQ(parameters_of<TextureEffect>(effects).height_m, 10.0 * kDefaultTextureHeight_m);
  EXPECT_EQ(parameters_of<FrictionEffect>(effects).static_friction, kMapFriction);
  EXPECT_EQ(texts_of(effects.report.defaulted),
            (Texts{"dynamicFriction=1", "staticFriction=1", "textureHeight=1e-04m"}));
  EXPECT_EQ(texts_of(effects.report.honoured),
            (Texts{"friction=\"texture 1\" MPEG_haptic_material",
                   "vibrotactileTexture=\"texture 0\" MPEG_haptic_material"}));
  EXPECT_EQ(texts_of(effects.report.not_understood),
            (Texts{"friction /maps/3", "stiffness /maps/2"}));
}

TEST(MaterialEffects, RequireAMapForATexture) {
  expect_names(refused({given("textureHeight", 0.001)}),
               {"wood", "textureHeight", "without a map", "normalTexture"});
  MaterialDescription material = material_with({given("textureHeight", 0.001)});
  material.normal_texture = TextureReference{};
  const MaterialEffects carved = compiled_material(MaterialSources{&material});
  EXPECT_EQ(carved.effect_names(), Texts{"texture"});
  EXPECT_EQ(texts_of(carved.report.honoured),
            (Texts{"normalTexture=\"texture 0\" glTF", "textureHeight=0.001 extras.palpate"}));
  EXPECT_EQ(carved.report.honoured.back().element, "/materials/2/normalTexture");
  EXPECT_TRUE(compiled_material({given("textureHeight", 0.0)}).entries.empty());
}

TEST(MaterialEffects, ReportMapsWhoseEffectsAreOff) {
  const HapticMaterialDescription haptic = haptic_with({"vibrotactileTexture", "friction"});
  const MaterialDescription material =
      material_with({given("staticFriction", 0.0), given("textureHeight", 0.0)});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, nullptr, "", &haptic});
  EXPECT_TRUE(effects.entries.empty());
  EXPECT_EQ(texts_of(effects.report.honoured),
            (Texts{"friction=\"texture 1\" MPEG_haptic_material off",
                   "staticFriction=0 extras.palpate off", "textureHeight=0 extras.palpate off",
                   "vibrotactileTexture=\"texture 0\" MPEG_haptic_material off"}));
  EXPECT_TRUE(effects.report.not_understood.empty());
  // The same with a physics material without friction.
  const PhysicsMaterialDescription physics{0.0};
  const MaterialDescription plain = material_with({});
  const auto off =
      texts_of(compiled_material({&plain, &physics, "/physics/1", &haptic}).report.honoured);
  ASSERT_FALSE(off.empty());
  EXPECT_EQ(off.front(), "friction=\"texture 1\" MPEG_haptic_material off");
}

TEST(MaterialEffects, MultiplyOnlyLengthsByTheScale) {
  const MaterialDescription material = material_with(
      {given("magnetForce", 2.0), given("magnetRange", 0.1), given("stiffness", 300.0)});
  const MaterialEffects effects =
      compiled_material(MaterialSources{&material, nullptr, "", nullptr, 0.5});
  EXPECT_EQ(parameters_of<MagnetEffect>(effects).force_N, 2.0);
  EXPECT_EQ(parameters_of<MagnetEffect>(effects).range_m, 0.05);
}

TEST(MaterialEffects, ReportUnknownKeysOfAFile) {
  const MaterialEffects effects =
      compiled_material({given("Stiffness", 3.0), given("texture.amplitude", true)});
  EXPECT_TRUE(effects.entries.empty());
  EXPECT_EQ(texts_of(effects.report.not_understood),
            (Texts{std::string("Stiffness ") + kExtras + "/Stiffness",
                   std::string("texture.amplitude ") + kExtras + "/texture.amplitude"}));
}

TEST(MaterialEffects, RefuseUnknownKeysOfOverrides) {
  const Error error = refused({{"Stiffness", 3.0, "`SceneSettings::overrides` wood.Stiffness"}});
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(error.element, "`SceneSettings::overrides` wood.Stiffness");
  expect_names(error, {"wood", "\"Stiffness\""});
  for (const EffectKeyName& name : effect_key_names()) {
    EXPECT_NE(error.hint.find(name.key), std::string::npos) << name.key;
  }
}

TEST(MaterialEffects, AreOnlyAMediumIfTheMaterialIsNotSolid) {
  const MaterialEffects medium =
      compiled_material({given("solid", false), given("viscosity", 2.0)});
  EXPECT_FALSE(medium.is_solid);
  EXPECT_EQ(medium.effect_names(), Texts{"viscosity"});
  EXPECT_TRUE(compiled_material({given("solid", true)}).is_solid);
  expect_names(refused({given("solid", false)}), {"wood", "/solid", "no effect"});
  expect_names(refused({given("solid", false), given("viscosity", 0.0)}), {"no effect"});
  EXPECT_TRUE(compiled_material({given("solid", 1.0)}).is_solid);
  EXPECT_FALSE(compiled_material({given("solid", 0.0), given("viscosity", 2.0)}).is_solid);
  expect_names(refused({given("solid", 0.5)}), {"/solid", "true or false, or 1 or 0"});
  expect_names(refused({given("solid", false), given("viscosity", 2.0), given("stiffness", 2.0)}),
               {"stiffness", "solid is false"});
  // Values of the node's physics material do not contradict the material.
  const PhysicsMaterialDescription physics{0.6, 0.6};
  const MaterialDescription material =
      material_with({given("solid", false), given("viscosity", 2.0)});
  const MaterialEffects beside =
      compiled_material(MaterialSources{&material, &physics, "/physics/1"});
  EXPECT_EQ(beside.effect_names(), Texts{"viscosity"});
  EXPECT_EQ(texts_of(beside.report.not_understood),
            (Texts{"dynamicFriction /physics/1/dynamicFriction",
                   "staticFriction /physics/1/staticFriction"}));
}

// Compares the list of all keys, which serves to refuse effects that are not built, with the built
// effects.
TEST(MaterialEffects, KnowTheKeysOfEveryEffect) {
  const auto names = effect_key_names();
  std::size_t compiled_keys = 0;
  for (const EffectType& type : compiled_effects()) {
    for (const ParameterKey& key : type.keys) {
      ++compiled_keys;
      const auto known = std::find_if(names.begin(), names.end(),
                                      [&](const EffectKeyName& n) { return n.key == key.key; });
      ASSERT_NE(known, names.end()) << key.key;
      EXPECT_EQ(known->effect, type.name);
    }
  }
  for (const EffectKeyName& name : names) {
    if (effect_number(name.effect)) continue;
    // The effect is not in this build: a scene that declares it is refused.
    const Error error = refused({given(std::string(name.key), 0.5)});
    EXPECT_EQ(error.code, ErrorCode::kUnsupported);
    expect_names(error, {std::string(name.effect), "PALPATE_EFFECTS", "wood"});
    ++compiled_keys;
  }
  EXPECT_EQ(names.size(), compiled_keys);
}

// --- Scenes and regions --------------------------------------------------------------------------

MaterialDescription scene_with(std::vector<MaterialParameter> parameters) {
  return {"scene", "/scenes/0/extras/palpate", std::move(parameters), std::nullopt};
}

TEST(SceneFields, RequireAMassForGravity) {
  const std::vector<double> down{0.0, -9.81, 0.0};
  const auto fields =
      scene_fields(scene_with({given("gravity", down), given("toolMass", 0.1), given("x", 1.0)}));
  ASSERT_TRUE(fields);
  ASSERT_TRUE(fields->gravity);
  EXPECT_EQ(fields->gravity->mass_kg, 0.1);
  EXPECT_EQ(fields->gravity->gravity_m_per_s2[1], -9.81);
  EXPECT_EQ(texts_of(fields->report.not_understood), Texts{std::string("x ") + kExtras + "/x"});

  expect_names(scene_fields(scene_with({given("gravity", down)})).error(), {"toolMass", "kg"});
  expect_names(scene_fields(scene_with({given("toolMass", 0.1)})).error(), {"gravity"});
  expect_names(scene_fields(scene_with({given("gravity", 9.81), given("toolMass", 0.1)})).error(),
               {"gravity is 9.81", "three numbers"});
  expect_names(scene_fields(scene_with({given("gravity", std::vector<double>{0.0, 1.0}),
                                        given("toolMass", 0.1)}))
                   .error(),
               {"[0, 1]", "three numbers"});
}

TEST(SceneFields, AreAbsentForAnEmptyDeclaration) {
  const auto none = scene_fields(scene_with({}));
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->gravity);
  const auto zero = scene_fields(scene_with({given("constantForce", std::vector<double>(3, 0.0))}));
  ASSERT_TRUE(zero);
  EXPECT_FALSE(zero->gravity);
  EXPECT_EQ(texts_of(zero->report.honoured), Texts{"constantForce=[0, 0, 0] extras.palpate off"});
}

RegionDescription region_with(std::vector<MaterialParameter> parameters) {
  RegionDescription region;
  region.name = "pool";
  region.element = "/nodes/3/extras/palpate";
  region.parameters = std::move(parameters);
  return region;
}

TEST(NodeMedium, IsABoxOrASphere) {
  RegionDescription box =
      region_with({given("medium", std::string("box")),
                   given("size", std::vector<double>{2.0, 4.0, 6.0}), given("viscosity", 3.0)});
  box.linear_scene_node = Vec3(1.0, 2.0, -0.5).asDiagonal();
  box.translation_m = {10, 0, 0};
  const auto medium = node_medium(box, {9, 0, 0});
  ASSERT_TRUE(medium) << medium.error().to_string();
  EXPECT_EQ(medium->viscosity_Ns_per_m, 3.0);
  EXPECT_EQ(medium->region.half_m, Vec3(1, 2, 3));
  EXPECT_EQ(medium->region.p_region_solver(Vec3(1, 2, 0.5)), Vec3(0, 1, -1));
  EXPECT_DOUBLE_EQ(medium->region.least_scale, 0.5);
}

TEST(NodeMedium, RefusesWrongDeclarations) {
  const auto sphere = [](Mat3 linear) {
    RegionDescription region = region_with(
        {given("medium", std::string("sphere")), given("radius", 1.0), given("viscosity", 1.0)});
    region.linear_scene_node = linear;
    return node_medium(region, Vec3::Zero());
  };
  const Mat3 turned = Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_TRUE(sphere(-2.0 * turned));  // mirrored
  EXPECT_TRUE(sphere((2.0f * turned.cast<float>()).cast<double>()));
  expect_names(sphere(Vec3(1, 1, 1.01).asDiagonal()).error(), {"pool", "sphere", "same scale"});
  expect_names(sphere(Vec3(1, 1, 0).asDiagonal()).error(), {"pool", "singular"});

  const auto declared = [](std::vector<MaterialParameter> parameters) {
    return node_medium(region_with(std::move(parameters)), Vec3::Zero()).error();
  };
  const MaterialParameter box = given("medium", std::string("box"));
  const MaterialParameter size = given("size", std::vector<double>{1, 1, 1});
  expect_names(declared({given("medium", std::string("cone"))}), {"\"box\" or \"sphere\"", "cone"});
  expect_names(declared({box, given("viscosity", 1.0)}), {"pool", "box without size"});
  expect_names(declared({box, size}), {"has no viscosity"});
  expect_names(declared({box, given("radius", 1.0), given("viscosity", 1.0)}),
               {"a box has no radius"});
  expect_names(
      declared({box, given("size", std::vector<double>{1, 0, 1}), given("viscosity", 1.0)}),
      {"[1, 0, 1]", "above 0"});
  expect_names(declared({box, size, given("viscosity", -1.0)}), {"viscosity is -1", "N s/m"});
}

}  // namespace
}  // namespace palpate
