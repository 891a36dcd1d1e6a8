#include "engine/accuracy/effect_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <utility>

#include "models/primitives.h"

namespace palpate {
namespace {

constexpr double kTextureTile_m = 2e-3;
constexpr std::uint32_t kTexels = 64;

constexpr std::string_view kEffects[] = {"stiffness", "damping",   "friction",    "texture",
                                         "shading",   "vibration", "restitution", "magnet",
                                         "viscosity", "gravity"};

struct SurfaceParameter {
  std::string_view effect;
  const char* key;
  double value;
};
constexpr SurfaceParameter kParameters[] = {
    {"stiffness", "stiffness", 800.0},
    {"damping", "damping", 1.5},
    {"friction", "staticFriction", 0.5},
    {"friction", "dynamicFriction", 0.4},
    {"texture", "textureHeight", 1e-4},
    {"shading", "creaseAngle", 60.0},
    {"vibration", "vibrationFrequency", 150.0},
    {"vibration", "vibrationAmplitude", 0.3},
    {"restitution", "restitution", 0.5},
    {"magnet", "magnetForce", 1.0},
    {"magnet", "magnetRange", 5e-3},
    {"viscosity", "viscosity", 2.0},  // on the surface only if the scene has no medium
};

MaterialParameter parameter(const char* key, MaterialValue value) {
  return {key, std::move(value), std::string("/materials/0/extras/palpate/") + key};
}

ImageDescription waves() {
  ImageDescription image{kTexels, kTexels, {}};
  for (std::uint32_t row = 0; row < kTexels; ++row) {
    for (std::uint32_t column = 0; column < kTexels; ++column) {
      const double phase = 2.0 * std::numbers::pi * (column + 0.5) / kTexels;
      const auto grey = static_cast<std::uint16_t>(32767.5 * (1.0 + std::sin(phase)));
      image.rgb.insert(image.rgb.end(), 3, grey);
    }
  }
  return image;
}

MeshDescription sphere_mesh(int subdivisions, double radius_m) {
  TriangleMesh sphere = icosphere(subdivisions, radius_m);
  return {"sphere", std::move(sphere.positions_m), std::move(sphere.triangles), {}, {}};
}

void add_node(SceneDescription& scene, const std::string& name, const Vec3& place_m) {
  NodeDescription node;
  node.name = name;
  node.mesh = static_cast<std::uint32_t>(scene.meshes.size() - 1);
  node.translation_m = place_m;
  node.tree_node = static_cast<std::uint32_t>(scene.tree.size());
  scene.nodes.push_back(node);
  scene.tree.push_back({name, node.tree_node, {}, true, place_m});
}

// Adds a medium and a field, for the effects that do not belong to a surface.
void add_surroundings(SceneDescription& scene, double radius_m, const EffectCase& effect_case) {
  if (effect_case.has("viscosity")) {
    RegionDescription region;
    region.name = "medium";
    region.element = "/nodes/0/extras/palpate";
    region.parameters = {parameter("medium", std::string("sphere")),
                         parameter("radius", 2.0 * radius_m), parameter("viscosity", 2.0)};
    region.linear_scene_node = Mat3::Identity();
    region.translation_m = Vec3::Zero();
    scene.regions.push_back(region);
  }
  if (effect_case.has("gravity")) {
    scene.scene_parameters.parameters = {parameter("gravity", std::vector<double>{0.0, 0.0, -9.81}),
                                         parameter("toolMass", 0.05)};
  }
}

// Adds the material of the last mesh.
void add_material(SceneDescription& scene, const EffectCase& effect_case) {
  MeshDescription& mesh = scene.meshes.back();
  MaterialDescription material;
  material.name = "material";
  material.element = "/materials/0";
  for (const SurfaceParameter& p : kParameters) {
    if (!effect_case.has(p.effect)) continue;
    const bool is_surface = p.effect != "viscosity" || effect_case.is_elsewhere;
    if (is_surface) material.parameters.push_back(parameter(p.key, p.value));
  }
  mesh.material_runs = {{0, 0}};
  if (effect_case.has("texture")) {
    scene.images.push_back(waves());
    HapticMap map;
    map.property = "vibrotactileTexture";
    map.texture.image = 0;
    map.texture.pixels = 0;
    scene.haptic_materials.push_back({"waves", {map}});
    mesh.haptic_material = 0;
    for (const Vec3& p : mesh.positions) {
      mesh.texture_uv.push_back({p.x() / kTextureTile_m, p.y() / kTextureTile_m});
    }
  }
  scene.materials.push_back(std::move(material));
}

EffectCase all_without(std::string name, std::string_view left_out) {
  EffectCase effect_case{std::move(name), {}};
  std::copy_if(std::begin(kEffects), std::end(kEffects), std::back_inserter(effect_case.effects),
               [&](std::string_view effect) { return effect != left_out; });
  return effect_case;
}

}  // namespace

std::span<const std::string_view> measured_effects() {
  return kEffects;
}

bool EffectCase::has(std::string_view effect) const {
  return std::find(effects.begin(), effects.end(), effect) != effects.end();
}

EffectCase only(std::string_view effect) {
  return {std::string(effect), {effect}};
}

EffectCase all_but(std::string_view effect) {
  return all_without("all but " + std::string(effect), effect);
}

EffectCase all_effects() {
  return all_without("all", "");
}

EffectCase effects_elsewhere() {
  EffectCase effect_case = all_without("elsewhere", "");
  effect_case.is_elsewhere = true;
  return effect_case;
}

EffectCase without_effects(const EffectCase& effect_case) {
  return {effect_case.name + ", without", {}, effect_case.is_elsewhere};
}

Result<Scene> effect_scene(int subdivisions, double radius_m, const EffectCase& effect_case) {
  SceneDescription scene;
  scene.meshes.push_back(sphere_mesh(subdivisions, radius_m));
  add_node(scene, "sphere", Vec3::Zero());
  if (effect_case.is_elsewhere) {
    scene.meshes.push_back(sphere_mesh(3, 0.1 * radius_m));
    add_node(scene, "other", Vec3(3.0 * radius_m, 0.0, 0.0));
  }
  if (!effect_case.effects.empty()) {
    add_material(scene, effect_case);
    if (!effect_case.is_elsewhere) add_surroundings(scene, radius_m, effect_case);
  }
  return Scene::compile(std::move(scene), {});
}

}  // namespace palpate
