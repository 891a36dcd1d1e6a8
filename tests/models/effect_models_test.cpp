// The scenes of haptic effects in models/. Needs PALPATE_MODELS_DIR, the folder of the model files.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <png.h>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/reader.h"
#include "models/effect_scenes.h"
#include "models/glb_writer.h"
#include "models/haptic_maps.h"
#include "models/model_files.h"
#include "models/png_writer.h"
#include "models/primitives.h"
#include "models/textured_slab.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::Random;

constexpr const char* kHaptic = "MPEG_haptic_material";
constexpr const char* kPhysics = "KHR_physics_rigid_bodies";

// ---- a reader independent of the writer ---------------------------------------------------------

struct Asset {
  Json root;
  std::string bin;
};

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return word;
}

Asset parse(const std::string& bytes) {
  const std::size_t json_size = word_at(bytes, 12);
  return {Json::parse(bytes.substr(20, json_size)), bytes.substr(28 + json_size)};
}

// The committed files, by name without ".glb".
std::map<std::string, Asset> committed_effects() {
  std::map<std::string, Asset> assets;
  for (const EffectScene& scene : effect_scenes()) {
    std::ifstream file(std::string(PALPATE_MODELS_DIR) + "/" + scene.name + ".glb",
                       std::ios::binary);
    EXPECT_TRUE(file.good()) << scene.name;
    if (file.good()) assets[scene.name] = parse({std::istreambuf_iterator<char>(file), {}});
  }
  return assets;
}

std::string view_bytes(const Asset& asset, std::size_t view) {
  const Json& object = asset.root["bufferViews"].at(view);
  return asset.bin.substr(object["byteOffset"], object["byteLength"]);
}

std::vector<Vec3> positions_m(const Asset& asset, const Json& mesh) {
  const std::size_t accessor = mesh["primitives"][0]["attributes"]["POSITION"];
  const std::string bytes = view_bytes(asset, asset.root["accessors"][accessor]["bufferView"]);
  std::vector<Vec3> positions;
  for (std::size_t at = 0; at < bytes.size(); at += 12) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = std::bit_cast<float>(word_at(bytes, at + 4 * k));
    positions.push_back(p);
  }
  return positions;
}

// Merges vertices at the same position.
TriangleMesh welded(const TriangleMesh& mesh) {
  std::map<std::array<double, 3>, std::uint32_t> places;
  TriangleMesh result;
  std::vector<std::uint32_t> of_vertex;
  for (const Vec3& p : mesh.positions_m) {
    const auto next = static_cast<std::uint32_t>(places.size());
    const auto [place, is_new] = places.try_emplace({p.x(), p.y(), p.z()}, next);
    if (is_new) result.positions_m.push_back(p);
    of_vertex.push_back(place->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    result.triangles.push_back({of_vertex[a], of_vertex[b], of_vertex[c]});
  }
  return result;
}

Vec3 unit_normal(const TriangleMesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.positions_m[t[0]];
  return (mesh.positions_m[t[1]] - a).cross(mesh.positions_m[t[2]] - a).normalized();
}

// The angles between the normals of neighbouring faces. Empty unless every edge has two faces that
// traverse it in opposite directions.
std::vector<double> edge_angles_deg(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> normals;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) normals[{t[k], t[(k + 1) % 3]}] = unit_normal(mesh, t);
  }
  if (normals.size() != 3 * mesh.triangles.size()) return {};
  std::vector<double> angles_deg;
  for (const auto& [edge, normal] : normals) {
    const auto other = normals.find({edge.second, edge.first});
    if (other == normals.end()) return {};
    angles_deg.push_back(std::acos(std::min(normal.dot(other->second), 1.0)) * 180.0 /
                         std::numbers::pi);
  }
  return angles_deg;
}

double signed_volume_m3(const TriangleMesh& mesh) {
  double sum_m3 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum_m3 += triple_product(mesh.positions_m[a], mesh.positions_m[b], mesh.positions_m[c]);
  }
  return sum_m3 / 6.0;
}

// The samples of a PNG file as read by libpng: 1 per grey pixel, 3 per colour pixel. Empty if
// libpng reports an error or a warning.
template <typename Sample>
std::vector<Sample> decoded_png(const std::string& bytes, std::size_t width, std::size_t height) {
  const bool is_grey = sizeof(Sample) == 2;
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()));
  EXPECT_EQ(image.format & PNG_FORMAT_FLAG_LINEAR, is_grey ? PNG_FORMAT_FLAG_LINEAR : 0u);
  EXPECT_EQ(image.format & PNG_FORMAT_FLAG_COLOR, is_grey ? 0u : PNG_FORMAT_FLAG_COLOR);
  EXPECT_EQ(image.width, width);
  EXPECT_EQ(image.height, height);
  image.format = is_grey ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_RGB;
  std::vector<Sample> samples(PNG_IMAGE_SIZE(image) / sizeof(Sample));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, samples.data(), 0, nullptr));
  EXPECT_EQ(image.warning_or_error, 0u) << image.message;
  png_image_free(&image);
  if (image.warning_or_error != 0) samples.clear();
  return samples;
}

std::string image_bytes(const Asset& asset, const Json& texture_info) {
  const Json& texture = asset.root["textures"].at(texture_info["index"].get<std::size_t>());
  const Json& image = asset.root["images"].at(texture["source"].get<std::size_t>());
  EXPECT_EQ(image["mimeType"], "image/png");
  return view_bytes(asset, image["bufferView"]);
}

// The image of the first map of the first haptic material.
std::string haptic_image_bytes(const Asset& asset, const char* property) {
  return image_bytes(asset,
                     asset.root["extensions"][kHaptic]["materials"][0][property][0]["texture"]);
}

// ---- declarations -------------------------------------------------------------------------------

const Json& mesh_of(const Asset& asset, const Json& node) {
  return asset.root["meshes"].at(node["mesh"].get<std::size_t>());
}

Json material_of(const Asset& asset, const Json& node) {
  if (!node.contains("mesh")) return Json::object();
  const Json& mesh = mesh_of(asset, node);
  return asset.root["materials"].at(mesh["primitives"][0]["material"].get<std::size_t>());
}

Json haptic_material_of(const Asset& asset, const Json& node) {
  if (!node.contains("mesh")) return Json::object();
  const Json& mesh = mesh_of(asset, node);
  if (!mesh.contains("extensions")) return Json::object();
  const std::size_t index = mesh["extensions"][kHaptic]["hapticMaterialIndex"];
  return asset.root["extensions"][kHaptic]["materials"].at(index);
}

// All declarations about each node and the "scene", with the declaring element.
Json declarations(const Asset& asset) {
  const auto palpate = [](const Json& object) {
    return object.value("extras", Json::object()).value("palpate", Json());
  };
  Json all;
  const Json scene = palpate(asset.root["scenes"][0]);
  if (!scene.is_null()) all["scene"]["scene"] = scene;
  for (const Json& node : asset.root["nodes"]) {
    Json declared;
    if (node.contains("extras")) declared["node"] = palpate(node);
    const Json material = material_of(asset, node);
    if (material.contains("extras")) declared["material"] = palpate(material);
    if (material.contains("normalTexture")) declared["maps"].push_back("normalTexture");
    for (const char* map : {"friction", "vibrotactileTexture"}) {
      if (haptic_material_of(asset, node).contains(map)) declared["maps"].push_back(map);
    }
    if (node.contains("extensions")) {
      const Json& collider = node["extensions"][kPhysics]["collider"];
      const std::size_t index = collider["physicsMaterial"];
      declared["physics"] = asset.root["extensions"][kPhysics]["physicsMaterials"].at(index);
    }
    all[node["name"].get<std::string>()] = declared;
  }
  return all;
}

std::map<std::string, Json> expected_declarations() {
  const auto material = [](const Json& palpate) { return Json{{"material", palpate}}; };
  const auto node = [](const Json& palpate) { return Json{{"node", palpate}}; };
  const Json impact = {{"impactMass", 0.05}, {"impactDuration", 0.004}};
  Json impact_by_extras = impact;
  impact_by_extras["restitution"] = 0.5;
  return {
      {"effect_stiffness",
       {{"stiffness_200", material({{"stiffness", 200}, {"damping", 0.5}})},
        {"stiffness_800", material({{"stiffness", 800}, {"damping", 1}})},
        {"stiffness_3000", material({{"stiffness", 3000}, {"damping", 2}})}}},
      {"effect_friction",
       {{"friction_slippery", material({{"staticFriction", 0.1}, {"dynamicFriction", 0.1}})},
        {"friction_sticking", material({{"staticFriction", 0.6}, {"dynamicFriction", 0.4}})},
        {"friction_physics", {{"physics", {{"staticFriction", 0.8}, {"dynamicFriction", 0.7}}}}}}},
      {"effect_friction_map", {{"friction_map", {{"maps", {"friction"}}}}}},
      {"effect_viscosity",
       {{"viscosity_box", material({{"solid", false}, {"viscosity", 5}})},
        {"viscosity_medium_sphere",
         node({{"medium", "sphere"}, {"radius", 0.015}, {"viscosity", 2}})},
        {"viscosity_medium_box",
         node({{"medium", "box"}, {"size", {0.03, 0.06, 0.03}}, {"viscosity", 10}})}}},
      {"effect_texture",
       {{"texture_sine",
         {{"material", {{"textureHeight", 0.0003}}}, {"maps", {"vibrotactileTexture"}}}},
        {"texture_bumps",
         {{"material", {{"textureHeight", 0.0003}}}, {"maps", {"normalTexture"}}}}}},
      {"effect_shading",
       {{"shading_sphere", material({{"creaseAngle", 40}})},
        {"shading_box", material({{"creaseAngle", 40}})}}},
      {"effect_magnet",
       {{"magnet_sphere", material({{"magnetForce", 1.5}, {"magnetRange", 0.015}})}}},
      {"effect_vibration",
       {{"vibration_contact", material({{"vibrationFrequency", 150},
                                        {"vibrationAmplitude", 0.3},
                                        {"vibrationWhen", "contact"}})},
        {"vibration_sliding", material({{"vibrationFrequency", 80},
                                        {"vibrationAmplitude", 0.3},
                                        {"vibrationWhen", "sliding"}})}}},
      {"effect_restitution",
       {{"restitution_half", material(impact_by_extras)},
        {"restitution_physics",
         {{"material", impact},
          {"physics", {{"restitution", 0.8}, {"staticFriction", 0}, {"dynamicFriction", 0}}}}}}},
      {"effect_gravity",
       {{"gravity_slab", nullptr},
        {"scene", {{"scene", {{"gravity", {0, 0, -9.81}}, {"toolMass", 0.05}}}}}}}};
}

TEST(EffectModels, DeclareOnlyTheEffectInTheirName) {
  const auto assets = committed_effects();
  for (const auto& [name, expected] : expected_declarations()) {
    ASSERT_EQ(assets.count(name), 1u) << name;
    EXPECT_EQ(declarations(assets.at(name)), expected) << name;
  }
  EXPECT_EQ(assets.size(), expected_declarations().size() + 1);  // plus the gallery
}

TEST(EffectModels, AreAllInTheGallery) {
  const auto assets = committed_effects();
  ASSERT_EQ(assets.count("gallery"), 1u);
  Json expected;
  std::size_t nodes = 0;
  for (const auto& [name, declared] : expected_declarations()) {
    expected.update(declared);
    nodes += assets.at(name).root["nodes"].size();
  }
  const Asset& gallery = assets.at("gallery");
  EXPECT_EQ(declarations(gallery), expected);
  EXPECT_EQ(gallery.root["nodes"].size(), nodes);
}

// A wrongly shifted index could still be valid, so the contents are compared.
TEST(EffectModels, HaveTheSameMeshesAndImagesInTheGallery) {
  const auto assets = committed_effects();
  const Asset& gallery = assets.at("gallery");
  for (const auto& [name, expected] : expected_declarations()) {
    const Asset& asset = assets.at(name);
    for (const Json& node : asset.root["nodes"]) {
      SCOPED_TRACE(node["name"].get<std::string>());
      const auto same = std::find_if(gallery.root["nodes"].begin(), gallery.root["nodes"].end(),
                                     [&](const Json& n) { return n["name"] == node["name"]; });
      ASSERT_TRUE(same != gallery.root["nodes"].end());
      if (!node.contains("mesh")) continue;
      EXPECT_EQ(positions_m(asset, mesh_of(asset, node)),
                positions_m(gallery, mesh_of(gallery, *same)));
      const Json haptic = haptic_material_of(asset, node);
      const Json haptic_there = haptic_material_of(gallery, *same);
      for (const char* map : {"friction", "vibrotactileTexture"}) {
        if (!haptic.contains(map)) continue;
        EXPECT_EQ(image_bytes(asset, haptic[map][0]["texture"]),
                  image_bytes(gallery, haptic_there[map][0]["texture"]));
      }
      const Json material = material_of(asset, node);
      if (!material.contains("normalTexture")) continue;
      EXPECT_EQ(image_bytes(asset, material["normalTexture"]),
                image_bytes(gallery, material_of(gallery, *same)["normalTexture"]));
    }
  }
}

// The keys of extras.palpate in a material, a node and a scene, and the valid ranges of their
// numbers.
TEST(EffectModels, UseOnlyKeysOfTheFormatWithValuesInRange) {
  const std::map<std::string, std::map<std::string, std::pair<double, double>>> ranges = {
      {"material",
       {{"stiffness", {0, 1e6}},
        {"damping", {0, 1e4}},
        {"staticFriction", {0, 1000}},
        {"dynamicFriction", {0, 1000}},
        {"viscosity", {0, 1e4}},
        {"textureHeight", {0, 1}},
        {"creaseAngle", {0, 180}},
        {"magnetForce", {0, 100}},
        {"magnetRange", {0, 1000}},
        {"vibrationFrequency", {0, 5000}},
        {"vibrationAmplitude", {0, 100}},
        {"restitution", {0, 1}},
        {"impactMass", {0, 10}},
        {"impactDuration", {0, 1}}}},
      {"node", {{"radius", {0, 1000}}, {"viscosity", {0, 1e4}}}},
      {"scene", {{"toolMass", {0, 10}}}}};
  const std::set<std::string> others = {"material.solid", "material.vibrationWhen", "node.medium",
                                        "node.size", "scene.gravity"};
  std::set<std::string> found;
  const auto check = [&](const std::string& place, const Json& declared) {
    for (const auto& [key, value] : declared.items()) {
      SCOPED_TRACE(key);
      found.insert(place + "." + key);
      if (others.count(place + "." + key) != 0) continue;
      ASSERT_EQ(ranges.at(place).count(key), 1u);
      ASSERT_TRUE(value.is_number());
      EXPECT_GT(value, ranges.at(place).at(key).first);
      EXPECT_LE(value, ranges.at(place).at(key).second);
    }
  };
  for (const auto& [name, asset] : committed_effects()) {
    const Json all = declarations(asset);
    for (const auto& [element, declared] : all.items()) {
      SCOPED_TRACE(name + ": " + element);
      for (const char* place : {"material", "node", "scene"}) {
        if (declared.contains(place)) check(place, declared[place]);
      }
    }
  }
  for (const auto& [place, keys] : ranges) {
    for (const auto& [key, range] : keys) {
      EXPECT_EQ(found.count(place + "." + key), 1u) << key << " has no scene";
    }
  }
  for (const std::string& key : others) EXPECT_EQ(found.count(key), 1u) << key;
}

TEST(EffectModels, AreReadWithoutAWarning) {
  for (const auto& [name, asset] : committed_effects()) {
    const auto scene = read_gltf(std::string(PALPATE_MODELS_DIR) + "/" + name + ".glb");
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
    const Json& nodes = asset.root["nodes"];
    EXPECT_EQ(scene->tree.size(), nodes.size()) << name;
    EXPECT_EQ(scene->nodes.size(), std::count_if(nodes.begin(), nodes.end(), [](const Json& node) {
                return node.contains("mesh");
              }));
    EXPECT_FALSE(asset.root.contains("extensionsRequired"));
  }
}

// ---- shapes -------------------------------------------------------------------------------------

TEST(EffectModels, HaveClosedMeshesThatFaceOutward) {
  for (const EffectScene& scene : effect_scenes()) {
    for (const MeshContent& mesh : scene.content.meshes) {
      SCOPED_TRACE(scene.name + ": " + mesh.name);
      const TriangleMesh one = welded(mesh.mesh);
      EXPECT_EQ(edge_angles_deg(one).size(), 3 * one.triangles.size());
      EXPECT_EQ(2 * one.positions_m.size(), one.triangles.size() + 4);  // Euler: one sphere
      EXPECT_GT(signed_volume_m3(one), 0.0);
    }
  }
}

Eigen::AlignedBox3d box_of(const Asset& asset, const Json& node) {
  Eigen::AlignedBox3d box;
  if (node.contains("mesh")) {
    for (const Vec3& p : positions_m(asset, mesh_of(asset, node))) box.extend(p);
  } else {
    const Json& medium = node["extras"]["palpate"];
    Vec3 half_m = Vec3::Constant(medium.value("radius", 0.0));
    for (int k = 0; k < 3 && medium["medium"] == "box"; ++k) {
      half_m[k] = medium["size"][static_cast<std::size_t>(k)].get<double>() / 2.0;
    }
    box.extend(half_m);
    box.extend(-half_m);
  }
  if (node.contains("translation")) {
    const Json& p = node["translation"];
    box.translate(Vec3(p[0], p[1], p[2]));
  }
  return box;
}

TEST(EffectModels, FitADesktopDeviceAndAreSeparateFromEachOther) {
  for (const auto& [name, asset] : committed_effects()) {
    SCOPED_TRACE(name);
    std::vector<Eigen::AlignedBox3d> boxes;
    Eigen::AlignedBox3d all;
    for (const Json& node : asset.root["nodes"]) {
      const Eigen::AlignedBox3d box = box_of(asset, node);
      for (const Eigen::AlignedBox3d& other : boxes) EXPECT_FALSE(box.intersects(other));
      boxes.push_back(box);
      all.extend(box);
    }
    const double limit_m = name == "gallery" ? 0.4 : 0.1;
    const double roundoff = 1.0 + 0x1p-23;  // of coordinates rounded to float
    EXPECT_LE(all.sizes().maxCoeff(), limit_m * roundoff);
    EXPECT_GE(all.sizes().maxCoeff(), limit_m / 2.0);
    EXPECT_LE(all.center().norm(), limit_m * 0x1p-20);
  }
}

TEST(EffectModels, SmoothTheSphereAndKeepTheCreasesOfTheBox) {
  for (const EffectScene& scene : effect_scenes()) {
    if (scene.name != "effect_shading") continue;
    for (const MeshContent& mesh : scene.content.meshes) {
      const double crease_deg = scene.content.materials[*mesh.material].palpate["creaseAngle"];
      const std::vector<double> angles_deg = edge_angles_deg(mesh.mesh);
      ASSERT_FALSE(angles_deg.empty());
      const double sharpest_deg = *std::max_element(angles_deg.begin(), angles_deg.end());
      if (mesh.name == "shading_sphere") {
        EXPECT_LT(sharpest_deg, crease_deg);
        EXPECT_GT(sharpest_deg, 15.0) << "too fine for a noticeable effect of shading";
      } else {
        EXPECT_NEAR(sharpest_deg, 90.0, 1e-3);
      }
    }
  }
}

// On every face, u points to the right and v down, in units of the tile.
TEST(TexturedSlab, IsABoxWithAnUprightImageToScaleOnEveryFace) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 size_m(random.uniform(0.01, 1.0), random.uniform(0.01, 1.0),
                      random.uniform(0.01, 1.0));
    const double tile_m = random.uniform(0.01, 1.0);
    const auto [mesh, uv] = textured_slab(size_m, tile_m);
    ASSERT_EQ(uv.size(), mesh.positions_m.size());
    EXPECT_EQ(mesh.triangles.size(), 12u);
    const TriangleMesh plain = box(size_m);
    for (const Vec3& p : mesh.positions_m) {
      EXPECT_EQ(std::count(plain.positions_m.begin(), plain.positions_m.end(), p), 1);
    }
    for (const Triangle& t : mesh.triangles) {
      const Vec3 ab = mesh.positions_m[t[1]] - mesh.positions_m[t[0]];
      const Vec3 ac = mesh.positions_m[t[2]] - mesh.positions_m[t[0]];
      const Point2 uv_ab = uv[t[1]] - uv[t[0]];
      const Point2 uv_ac = uv[t[2]] - uv[t[0]];
      const double det = uv_ab.x() * uv_ac.y() - uv_ac.x() * uv_ab.y();
      const Vec3 right = (uv_ac.y() * ab - uv_ab.y() * ac) / det / tile_m;
      const Vec3 up = -(uv_ab.x() * ac - uv_ac.x() * ab) / det / tile_m;
      const double tolerance = 16 * 0x1p-24;  // for rounding positions and coordinates to float
      EXPECT_NEAR(right.norm(), 1.0, tolerance);
      EXPECT_NEAR(up.norm(), 1.0, tolerance);
      EXPECT_LT((right.cross(up) - unit_normal(mesh, t)).norm(), tolerance);
      if (unit_normal(mesh, t).z() > 0.5) {
        EXPECT_LT((right - Vec3::UnitX()).norm(), tolerance);
      }
    }
    for (const Point2& p : uv) EXPECT_GE(std::min(p.x(), p.y()), 0.0);
  }
}

// ---- maps ---------------------------------------------------------------------------------------

TEST(EffectModels, HaveASineOfTwoMillimetresWithinHalfAUnit) {
  const Asset asset = committed_effects().at("effect_texture");
  const auto pixels =
      decoded_png<std::uint16_t>(haptic_image_bytes(asset, "vibrotactileTexture"), 64, 64);
  ASSERT_EQ(pixels.size(), 64u * 64u);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double u = (static_cast<double>(i % 64) + 0.5) / 64.0;
    const double value = 65535.0 * (0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * 4.0 * u));
    ASSERT_LE(std::abs(pixels[i] - value), 0.5) << i;
    // Far from a rounding tie: a sine with an error in its last bits gives the same pixel.
    ASSERT_LT(std::abs(pixels[i] - value), 0.5 - 1e-6) << i;
  }
  // 4 waves of 2 mm per image: 5 images of 8 mm on the slab's 40 mm.
  double widest = 0.0;
  const std::string uv = view_bytes(asset, 2);
  for (std::size_t at = 0; at < uv.size(); at += 8) {
    widest = std::max<double>(widest, std::bit_cast<float>(word_at(uv, at)));
  }
  EXPECT_NEAR(widest, 0.08 / 0.008, 1e-5);
}

TEST(EffectModels, HaveUnitNormalsOfBumpsOfTheDeclaredHeight) {
  const Asset asset = committed_effects().at("effect_texture");
  const auto samples = decoded_png<std::uint8_t>(
      image_bytes(asset, asset.root["materials"][1]["normalTexture"]), 64, 64);
  ASSERT_EQ(samples.size(), 3u * 64u * 64u);
  const double half_unit = 1.0 / 255.0;  // components from -1 to 1 in 255 steps
  const double image_m = 0.016;
  const auto height_m = [&](double u, double v) {
    return 0.00015 *
           (1.0 + std::sin(8.0 * std::numbers::pi * u) * std::sin(8.0 * std::numbers::pi * v));
  };
  for (std::size_t i = 0; i < 64u * 64u; ++i) {
    Vec3 normal;
    for (std::size_t k = 0; k < 3; ++k) normal[k] = 2.0 * samples[3 * i + k] / 255.0 - 1.0;
    ASSERT_NEAR(normal.norm(), 1.0, std::sqrt(3.0) * half_unit);
    const double u = (static_cast<double>(i % 64) + 0.5) / 64.0;
    const double v = (static_cast<double>(i / 64) + 0.5) / 64.0;
    const double step = 1e-5;
    const Vec3 surface(-(height_m(u + step, v) - height_m(u - step, v)) / (2.0 * step * image_m),
                       (height_m(u, v + step) - height_m(u, v - step)) / (2.0 * step * image_m),
                       1.0);
    const double difference = (normal - surface.normalized()).cwiseAbs().maxCoeff();
    ASSERT_LE(difference, half_unit * (1.0 + 1e-4)) << i;  // differences: relative error 1e-6
  }
}

TEST(BumpNormalMap, IsFarFromARoundingTieInEveryPixel) {
  const double steepest = std::numbers::pi * 4.0 * 0.0003 / 0.016;
  for (int i = 0; i < 16; ++i) {
    for (int j = 0; j < 16; ++j) {
      const double u_rad = 2.0 * std::numbers::pi * (i + 0.5) / 16.0;
      const double v_rad = 2.0 * std::numbers::pi * (j + 0.5) / 16.0;
      const Vec3 normal = Vec3(-steepest * std::cos(u_rad) * std::sin(v_rad),
                               steepest * std::sin(u_rad) * std::cos(v_rad), 1.0)
                              .normalized();
      for (const double c : normal) {
        const double stored = 255.0 * (c + 1.0) / 2.0;
        EXPECT_LT(std::abs(stored - std::round(stored)), 0.5 - 1e-6);
      }
    }
  }
}

TEST(EffectModels, HaveFrictionStripesOneCentimetreWide) {
  const Asset asset = committed_effects().at("effect_friction_map");
  const auto pixels = decoded_png<std::uint16_t>(haptic_image_bytes(asset, "friction"), 64, 64);
  ASSERT_EQ(pixels.size(), 64u * 64u);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double place_m = 0.04 * (static_cast<double>(i % 64) + 0.5) / 64.0;  // images of 40 mm
    const bool is_even = static_cast<int>(place_m / 0.01) % 2 == 0;
    ASSERT_NEAR(pixels[i] / 65535.0, is_even ? 0.1 : 0.8, 0.5 / 65535.0 + 1e-12) << i;
  }
}

// ---- PNG writer ---------------------------------------------------------------------------------

TEST(PngWriter, WritesPixelsThatLibpngReadsBack) {
  Random random(2);
  // The last image has rows with more bytes than a stored block can hold.
  for (const auto& [width, height] :
       {std::pair<std::size_t, std::size_t>(1, 1), {5, 3}, {1, 200}, {181, 181}, {40000 / 3, 6}}) {
    GreyImage grey{width, height, {}};
    RgbImage rgb{width, height, {}};
    std::vector<std::uint8_t> samples;
    for (std::size_t i = 0; i < width * height; ++i) {
      grey.pixels.push_back(static_cast<std::uint16_t>(random.index(65536)));
      std::array<std::uint8_t, 3> pixel{};
      for (auto& value : pixel) samples.push_back(value = random.index(256) & 0xffu);
      rgb.pixels.push_back(pixel);
    }
    EXPECT_EQ(decoded_png<std::uint16_t>(encode_png(grey), width, height), grey.pixels);
    EXPECT_EQ(decoded_png<std::uint8_t>(encode_png(rgb), width, height), samples);
  }
}

// The exact size at which a second block begins: 2 bytes per pixel and one for the row's filter.
TEST(PngWriter, FillsStoredBlocksToTheLastByte) {
  // 15 rows of 2 * 2184 + 1 bytes are 65535 bytes; one more row requires a second block.
  for (const auto& [height, blocks] : {std::pair<std::size_t, std::size_t>(15, 1), {16, 2}}) {
    const GreyImage image{2184, height, std::vector<std::uint16_t>(2184 * height, 7)};
    const std::string bytes = encode_png(image);
    const std::size_t rows = height * (2 * 2184 + 1);
    const std::size_t chunks = 8 + (12 + 13) + 12 + 12;  // signature, header, data, end
    EXPECT_EQ(bytes.size(), chunks + 2 + 5 * blocks + rows + 4);
    EXPECT_EQ(decoded_png<std::uint16_t>(bytes, 2184, height), image.pixels);
  }
}

// ---- GLB writer ---------------------------------------------------------------------------------

SceneContent small_scene() {
  SceneContent scene;
  scene.images = {encode_png(sine_height_map())};
  scene.materials.push_back({.name = "m", .base_color_image = 0, .normal_image = 0});
  scene.haptic_materials.push_back({.name = "h", .friction_image = 0, .vibrotactile_image = 0});
  scene.physics_materials.push_back(Json::object());
  const auto [mesh, uv] = textured_slab({1.0, 1.0, 1.0}, 1.0);
  scene.meshes.push_back({"b", mesh, uv, 0, 0});
  scene.nodes.push_back({.name = "n", .mesh = 0, .physics_material = 0});
  return scene;
}

TEST(GlbWriter, RejectsInvalidIndicesAndNamesTheElement) {
  ASSERT_TRUE(encode_scene(small_scene()).ok());
  const auto refuse = [](const char* element, auto spoil) {
    SceneContent scene = small_scene();
    spoil(scene);
    const auto bytes = encode_scene(scene);
    ASSERT_FALSE(bytes.ok()) << element;
    EXPECT_EQ(bytes.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(bytes.error().element, element);
  };
  refuse("/meshes/0", [](SceneContent& s) { s.meshes[0].material = 1; });
  refuse("/meshes/0", [](SceneContent& s) { s.meshes[0].haptic_material = 1; });
  refuse("/meshes/0", [](SceneContent& s) { s.meshes[0].texture_coordinates.pop_back(); });
  refuse("/meshes/0", [](SceneContent& s) { s.meshes[0].texture_coordinates[3].y() = 1e39; });
  refuse("/meshes/0", [](SceneContent& s) { s.meshes.clear(); });
  refuse("/materials/0", [](SceneContent& s) { s.materials[0].normal_image = 1; });
  refuse("/materials/0", [](SceneContent& s) { s.materials[0].base_color_image = 1; });
  const char* haptic = "/extensions/MPEG_haptic_material/materials/0";
  refuse(haptic, [](SceneContent& s) { s.haptic_materials[0].friction_image = 1; });
  refuse(haptic, [](SceneContent& s) { s.haptic_materials[0].vibrotactile_image = 1; });
  refuse("/nodes/0", [](SceneContent& s) { s.nodes[0].mesh = 1; });
  refuse("/nodes/0", [](SceneContent& s) { s.nodes[0].physics_material = 1; });
  refuse("/nodes/0", [](SceneContent& s) { s.nodes[0].translation_m.x() = HUGE_VAL; });
}

// Floats and 32-bit indices are at multiples of four bytes, regardless of the preceding views.
TEST(GlbWriter, AlignsEveryView) {
  SceneContent scene = small_scene();
  TriangleMesh odd = box({1.0, 1.0, 1.0});
  odd.triangles.resize(1);  // six bytes of indices
  scene.meshes.insert(scene.meshes.begin(), {.name = "odd", .mesh = odd});
  const auto bytes = encode_scene(scene);
  ASSERT_TRUE(bytes.ok()) << bytes.error().to_string();
  const Asset asset = parse(*bytes);
  std::size_t end = 0;
  for (const Json& view : asset.root["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
    EXPECT_EQ(view["byteOffset"], (end + 3) / 4 * 4);
    end = view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>();
  }
  EXPECT_EQ(asset.root["buffers"][0]["byteLength"], end);
  EXPECT_EQ(positions_m(asset, asset.root["meshes"][1]), scene.meshes[1].mesh.positions_m);
}

}  // namespace
}  // namespace palpate
