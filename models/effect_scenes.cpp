#include "models/effect_scenes.h"

#include <utility>

#include "models/haptic_maps.h"
#include "models/png_writer.h"
#include "models/primitives.h"
#include "models/textured_slab.h"

namespace palpate {
namespace {

using nlohmann::json;
using Colour = std::array<double, 4>;

constexpr Colour kBlue = {0.10, 0.28, 0.65, 1.0};
constexpr Colour kGreen = {0.12, 0.50, 0.22, 1.0};
constexpr Colour kRed = {0.65, 0.12, 0.10, 1.0};
constexpr Colour kWhite = {0.90, 0.90, 0.90, 1.0};
constexpr Colour kGlass = {0.20, 0.55, 0.80, 0.35};

// Sizes and positions of two or three slabs side by side along x: 0.1 m in total.
const Vec3 kThird_m(0.03, 0.08, 0.01);
const Vec3 kHalf_m(0.04, 0.08, 0.01);
const Vec3 kWhole_m(0.08, 0.08, 0.01);
const Vec3 kLeft_m(-0.03, 0.0, 0.0);
const Vec3 kRight_m(0.03, 0.0, 0.0);
const Vec3 kMiddle_m(0.0, 0.0, 0.0);
const Vec3 kFarLeft_m(-0.035, 0.0, 0.0);
const Vec3 kFarRight_m(0.035, 0.0, 0.0);

constexpr double kTextureHeight_m = 0.0003;
constexpr double kSineTile_m = kMapWaves * 0.002;
constexpr double kBumpTile_m = kMapWaves * 0.004;
constexpr int kStripes = 4;
constexpr double kStripeTile_m = kStripes * 0.01;

struct Object {
  MeshContent& mesh;
  MaterialContent& material;
  NodeContent& node;
};

// Adds a node with its own mesh and material, all with the same name. The references are valid
// until the next object is added.
Object add_object(SceneContent& scene, const std::string& name, TriangleMesh mesh,
                  const Vec3& centre_m, const Colour& colour, json palpate) {
  scene.meshes.push_back(
      {.name = name, .mesh = std::move(mesh), .material = scene.materials.size()});
  scene.materials.push_back({.name = name, .palpate = std::move(palpate), .base_color = colour});
  scene.nodes.push_back({.name = name, .mesh = scene.meshes.size() - 1, .translation_m = centre_m});
  return {scene.meshes.back(), scene.materials.back(), scene.nodes.back()};
}

Object add_textured(SceneContent& scene, const std::string& name, TexturedMesh slab,
                    const Vec3& centre_m, json palpate) {
  const Object object =
      add_object(scene, name, std::move(slab.mesh), centre_m, kWhite, std::move(palpate));
  object.mesh.texture_coordinates = std::move(slab.texture_coordinates);
  return object;
}

SceneContent stiffness_scene() {
  SceneContent scene;
  add_object(scene, "stiffness_200", box(kThird_m), kFarLeft_m, kBlue,
             {{"stiffness", 200.0}, {"damping", 0.5}});
  add_object(scene, "stiffness_800", box(kThird_m), kMiddle_m, kGreen,
             {{"stiffness", 800.0}, {"damping", 1.0}});
  add_object(scene, "stiffness_3000", box(kThird_m), kFarRight_m, kRed,
             {{"stiffness", 3000.0}, {"damping", 2.0}});
  return scene;
}

SceneContent friction_scene() {
  SceneContent scene;
  add_object(scene, "friction_slippery", box(kThird_m), kFarLeft_m, kBlue,
             {{"staticFriction", 0.1}, {"dynamicFriction", 0.1}});
  add_object(scene, "friction_sticking", box(kThird_m), kMiddle_m, kGreen,
             {{"staticFriction", 0.6}, {"dynamicFriction", 0.4}});
  add_object(scene, "friction_physics", box(kThird_m), kFarRight_m, kRed, nullptr)
      .node.physics_material = 0;
  scene.physics_materials.push_back({{"staticFriction", 0.8}, {"dynamicFriction", 0.7}});
  return scene;
}

SceneContent friction_map_scene() {
  SceneContent scene;
  scene.images.push_back(encode_png(striped_friction_map(kStripes, 0.1, 0.8)));
  scene.haptic_materials.push_back({.name = "friction_map", .friction_image = 0});
  const Object slab = add_textured(scene, "friction_map", textured_slab(kWhole_m, kStripeTile_m),
                                   kMiddle_m, nullptr);
  slab.mesh.haptic_material = 0;
  slab.material.base_color_image = 0;
  return scene;
}

SceneContent viscosity_scene() {
  SceneContent scene;
  add_object(scene, "viscosity_box", box({0.03, 0.06, 0.03}), kFarLeft_m, kGlass,
             {{"solid", false}, {"viscosity", 5.0}});
  scene.nodes.push_back(
      {.name = "viscosity_medium_sphere",
       .translation_m = kMiddle_m,
       .extras = {{"palpate", {{"medium", "sphere"}, {"radius", 0.015}, {"viscosity", 2.0}}}}});
  scene.nodes.push_back(
      {.name = "viscosity_medium_box",
       .translation_m = kFarRight_m,
       .extras = {
           {"palpate",
            {{"medium", "box"}, {"size", std::array{0.03, 0.06, 0.03}}, {"viscosity", 10.0}}}}});
  return scene;
}

SceneContent texture_scene() {
  SceneContent scene;
  scene.images.push_back(encode_png(sine_height_map()));
  scene.images.push_back(encode_png(bump_normal_map(kTextureHeight_m / kBumpTile_m)));
  scene.haptic_materials.push_back({.name = "texture_sine", .vibrotactile_image = 0});
  const Object sine = add_textured(scene, "texture_sine", textured_slab(kHalf_m, kSineTile_m),
                                   kLeft_m, {{"textureHeight", kTextureHeight_m}});
  sine.mesh.haptic_material = 0;
  sine.material.base_color_image = 0;
  add_textured(scene, "texture_bumps", textured_slab(kHalf_m, kBumpTile_m), kRight_m,
               {{"textureHeight", kTextureHeight_m}})
      .material.normal_image = 1;
  return scene;
}

// Neighbouring faces of the sphere meet at 18 and 22.5 deg, those of the box at 90.
SceneContent shading_scene() {
  SceneContent scene;
  const json shading = {{"creaseAngle", 40.0}};
  add_object(scene, "shading_sphere", icosphere(1, 0.02), kLeft_m, kGreen, shading);
  add_object(scene, "shading_box", box({0.04, 0.04, 0.04}), kRight_m, kBlue, shading);
  return scene;
}

SceneContent magnet_scene() {
  SceneContent scene;
  add_object(scene, "magnet_sphere", icosphere(3, 0.025), kMiddle_m, kRed,
             {{"magnetForce", 1.5}, {"magnetRange", 0.015}});
  return scene;
}

SceneContent vibration_scene() {
  SceneContent scene;
  add_object(
      scene, "vibration_contact", box(kHalf_m), kLeft_m, kRed,
      {{"vibrationFrequency", 150.0}, {"vibrationAmplitude", 0.3}, {"vibrationWhen", "contact"}});
  add_object(
      scene, "vibration_sliding", box(kHalf_m), kRight_m, kBlue,
      {{"vibrationFrequency", 80.0}, {"vibrationAmplitude", 0.3}, {"vibrationWhen", "sliding"}});
  return scene;
}

// The draft of KHR_physics_rigid_bodies has no impact mass and no duration, and its friction is not
// zero by default.
SceneContent restitution_scene() {
  SceneContent scene;
  add_object(scene, "restitution_half", box(kHalf_m), kLeft_m, kGreen,
             {{"restitution", 0.5}, {"impactMass", 0.05}, {"impactDuration", 0.004}});
  add_object(scene, "restitution_physics", box(kHalf_m), kRight_m, kRed,
             {{"impactMass", 0.05}, {"impactDuration", 0.004}})
      .node.physics_material = 0;
  scene.physics_materials.push_back(
      {{"restitution", 0.8}, {"staticFriction", 0.0}, {"dynamicFriction", 0.0}});
  return scene;
}

SceneContent gravity_scene() {
  SceneContent scene;
  add_object(scene, "gravity_slab", box(kWhole_m), kMiddle_m, kGreen, nullptr);
  scene.extras["palpate"] = {{"gravity", std::array{0.0, 0.0, -9.81}}, {"toolMass", 0.05}};
  return scene;
}

Index shifted(const Index& index, std::size_t by) {
  return index ? Index(*index + by) : Index();
}

template <typename Content>
void append(std::vector<Content>& to, const std::vector<Content>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// Adds the content of `from`, translated by moved_m, to `to`. The scene extras of `from` are used
// if `to` has none.
void append(SceneContent& to, SceneContent from, const Vec3& moved_m) {
  for (MeshContent& mesh : from.meshes) {
    mesh.material = shifted(mesh.material, to.materials.size());
    mesh.haptic_material = shifted(mesh.haptic_material, to.haptic_materials.size());
  }
  for (MaterialContent& material : from.materials) {
    material.base_color_image = shifted(material.base_color_image, to.images.size());
    material.normal_image = shifted(material.normal_image, to.images.size());
  }
  for (HapticMaterialContent& material : from.haptic_materials) {
    material.friction_image = shifted(material.friction_image, to.images.size());
    material.vibrotactile_image = shifted(material.vibrotactile_image, to.images.size());
  }
  for (NodeContent& node : from.nodes) {
    node.mesh = shifted(node.mesh, to.meshes.size());
    node.physics_material = shifted(node.physics_material, to.physics_materials.size());
    node.translation_m += moved_m;
  }
  append(to.meshes, from.meshes);
  append(to.materials, from.materials);
  append(to.haptic_materials, from.haptic_materials);
  append(to.physics_materials, from.physics_materials);
  append(to.images, from.images);
  append(to.nodes, from.nodes);
  if (to.extras.is_null()) to.extras = from.extras;
}

// Rows of three in reading order, from the far left.
SceneContent gallery_of(const std::vector<EffectScene>& effects) {
  SceneContent gallery;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const auto column = static_cast<double>(i % 3);
    const auto row = static_cast<double>(i / 3);
    append(gallery, effects[i].content, {0.12 * (column - 1.0), 0.1 * (1.5 - row), 0.0});
  }
  return gallery;
}

}  // namespace

std::vector<EffectScene> effect_scenes() {
  std::vector<EffectScene> scenes = {{"effect_stiffness", stiffness_scene()},
                                     {"effect_friction", friction_scene()},
                                     {"effect_friction_map", friction_map_scene()},
                                     {"effect_viscosity", viscosity_scene()},
                                     {"effect_texture", texture_scene()},
                                     {"effect_shading", shading_scene()},
                                     {"effect_magnet", magnet_scene()},
                                     {"effect_vibration", vibration_scene()},
                                     {"effect_restitution", restitution_scene()},
                                     {"effect_gravity", gravity_scene()}};
  scenes.push_back({"gallery", gallery_of(scenes)});
  return scenes;
}

}  // namespace palpate
