// Tests scenes that declare effects: the effect program of their world, and the resulting forces.

#include "engine/scene/scene_effects.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "engine/scene/surface_attributes.h"
#include "geometry/index/crease_normals.h"
#include "haptics/effects/friction.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/texture.h"
#include "haptics/effects/viscosity.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::compiled;
using test::kTick_s;
using test::Random;

MeshDescription box_mesh(const Vec3& half_extent_m, std::optional<std::uint32_t> material) {
  test::Soup soup = test::box_soup(half_extent_m);
  MeshDescription mesh{"box", std::move(soup.positions), std::move(soup.triangles)};
  mesh.material_runs = {{0, material}};
  return mesh;
}

MaterialDescription material(const std::string& name,
                             const std::vector<std::pair<std::string, MaterialValue>>& values) {
  MaterialDescription m{name, "/materials/" + name, {}, std::nullopt};
  for (const auto& [key, value] : values) {
    m.parameters.push_back({key, value, m.element + "/extras/palpate/" + key});
  }
  return m;
}

NodeDescription node(const std::string& name, std::uint32_t mesh, const Vec3& at_m = Vec3::Zero(),
                     const Mat3& linear = Mat3::Identity()) {
  return {name, mesh, linear, at_m};
}

SceneDescription described(std::vector<MeshDescription> meshes, std::vector<NodeDescription> nodes,
                           std::vector<MaterialDescription> materials) {
  SceneDescription scene;
  scene.path = "made.glb";
  scene.meshes = std::move(meshes);
  scene.nodes = std::move(nodes);
  scene.materials = std::move(materials);
  return scene;
}

void expect_refused(SceneDescription description, const std::vector<std::string>& names) {
  const auto scene = Scene::compile(std::move(description));
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().path, "made.glb");
  for (const std::string& name : names) {
    EXPECT_NE(scene.error().to_string().find(name), std::string::npos)
        << "no " << name << " in: " << scene.error().to_string();
  }
}

HapticLoop loop_in(const Scene& scene) {
  HapticSettings settings;
  settings.coupling = {1000.0, 0.0};
  return test::made(
      HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), settings));
}

// The force after the device moved along a straight line from one point to another.
TickRecord tick_along(HapticLoop& loop, const Vec3& from_m, const Vec3& to_m, int ticks = 200) {
  TickRecord record;
  for (int n = 0; n <= ticks; ++n) {
    record = loop.tick(from_m + (to_m - from_m) * (static_cast<double>(n) / ticks), kTick_s);
  }
  return record;
}

std::vector<std::uint32_t> slots_of(const SurfaceIndex& index) {
  std::vector<std::uint32_t> slots(index.pack_count() * TrianglePack::kLanes);
  for (std::uint32_t i = 0; i < slots.size(); ++i) slots[i] = i;
  return slots;
}

TEST(SceneEffects, AreAbsentIfASceneDeclaresNothing) {
  const Scene scene = compiled(described({box_mesh({1, 1, 1}, 0)}, {node("box", 0)},
                                         {material("plain", {{"colour", std::string("red")}})}));
  EXPECT_FALSE(scene.world().effects);
  EXPECT_TRUE(scene.effects().effects.empty());
  EXPECT_EQ(scene.statistics().memory.effects, 0u);
  ASSERT_EQ(scene.effects().materials.size(), 1u);
  ASSERT_EQ(scene.effects().materials[0].report.not_understood.size(), 1u);
  EXPECT_EQ(scene.effects().materials[0].report.not_understood[0].key, "colour");
}

TEST(SceneEffects, SurfacesHaveTheStiffnessOfTheirMaterial) {
  const Scene scene = compiled(described(
      {box_mesh({1, 1, 1}, 0), box_mesh({1, 1, 1}, std::nullopt)},
      {node("hard", 0), node("plain", 1, {5, 0, 0})}, {material("hard", {{"stiffness", 4000.0}})}));
  EXPECT_EQ(scene.effects().effects, std::vector<std::string>{"stiffness"});
  HapticLoop loop = loop_in(scene);
  EXPECT_NEAR(vec3(tick_along(loop, {0, 0, 1.1}, {0, 0, 0.999}).force_device_N).z(), 4.0, 1e-6);
  tick_along(loop, {0, 0, 0.999}, {0, 0, 1.5});
  tick_along(loop, {0, 0, 1.5}, {5, 0, 1.1});
  EXPECT_NEAR(vec3(tick_along(loop, {5, 0, 1.1}, {5, 0, 0.999}).force_device_N).z(), 1.0, 1e-6);
}

TEST(SceneEffects, OneMaterialOnTwoNodesUsesThePhysicsOfEachNode) {
  SceneDescription description =
      described({box_mesh({1, 1, 1}, 0)},
                {node("ice", 0), node("sand", 0, {5, 0, 0}), node("plain", 0, {9, 0, 0})},
                {material("stone", {})});
  description.physics_materials = {{0.1, 0.05, 0.0}, {0.9, 0.8, 0.0}};
  description.nodes[0].physics_material = 0;
  description.nodes[1].physics_material = 1;
  const Scene scene = compiled(std::move(description));
  const EffectProgram& program = *scene.world().effects;
  EXPECT_EQ(scene.statistics().indices, 1u);
  EXPECT_EQ(program.attributes.size(), 1u) << "one shape";
  std::vector<double> coefficients;
  for (const std::uint32_t body : {0u, 1u}) {
    const auto table = program.table(program.material(body, 0), EffectStage::kProxy);
    ASSERT_EQ(table.size(), 1u);
    FrictionEffect::Parameters p;
    std::memcpy(&p, program.parameters.data() + table[0].parameters, sizeof p);
    coefficients.push_back(p.static_friction);
  }
  EXPECT_EQ(coefficients, (std::vector<double>{0.1, 0.9}));
  EXPECT_EQ(program.material(2, 0), 0u);
  // The report has both.
  EXPECT_EQ(scene.effects().materials[0].report.honoured.size(), 6u);
  EXPECT_EQ(scene.material_calls().size(), 3u);
}

// Equal lines about a material are reported once, for any number of combinations.
TEST(SceneEffects, OneMaterialWithManyPhysicsMaterialsIsReportedOnce) {
  constexpr std::uint32_t kCount = 100;
  SceneDescription description = described(
      {box_mesh({1, 1, 1}, 0)}, {},
      {material("stone", {{"stiffness", 5.0}, {"solid", true}, {"hue", std::string("grey")}})});
  for (std::uint32_t i = 0; i < kCount; ++i) {
    description.nodes.push_back(node("n" + std::to_string(i), 0, {5.0 * i, 0, 0}));
    description.nodes.back().physics_material = i;
    description.physics_materials.push_back({0.5 + i, i % 2 ? 0.25 : 0.5});
  }
  const Scene scene = compiled(std::move(description));
  const MaterialReport& report = scene.effects().materials[0].report;
  // Two coefficients of each physics material, stiffness and solid.
  EXPECT_EQ(report.honoured.size(), 2 * kCount + 2);
  EXPECT_TRUE(report.defaulted.empty());
  EXPECT_EQ(report.not_understood.size(), 1u);
}

// Random triangles with several materials, some without area, some repeated.
MeshDescription patched_mesh(Random& random, std::uint32_t materials) {
  MeshDescription mesh{"patches", {}, {}};
  for (int i = 0; i < 120; ++i) mesh.positions.push_back(random.in_box(1.0));
  for (std::uint32_t t = 0; t < 90; ++t) {
    const auto vertex = [&] { return static_cast<std::uint32_t>(random.index(120)); };
    mesh.triangles.push_back(random.index(8) == 0 && t > 0
                                 ? mesh.triangles[random.index(t)]
                                 : Triangle{vertex(), vertex(), vertex()});
    if (t % 7 == 0) {
      mesh.material_runs.push_back({t, t / 7 % materials});
    }
  }
  return mesh;
}

Mat3 random_shear(Random& random, bool is_mirrored) {
  Mat3 linear = random.rotation().toRotationMatrix();
  linear.col(0) *= (is_mirrored ? -1.0 : 1.0) * random.uniform(0.5, 2.0);
  linear(0, 1) += 0.3;
  if ((linear.determinant() < 0.0) != is_mirrored) linear.col(0) = -linear.col(0);
  return linear;
}

// Every slot has the material of its face, and every corner has its own coordinates, also if a node
// mirrors the mesh.
TEST(SceneEffects, SlotsHaveTheirMaterialAndCornersTheirCoordinates) {
  Random random(20261101);
  for (int round = 0; round < 20; ++round) {
    MeshDescription mesh = patched_mesh(random, 3);
    // Texture coordinates from which the position can be computed.
    Eigen::Matrix<double, 2, 3> uv_of;
    for (int i = 0; i < 6; ++i) uv_of(i / 3, i % 3) = random.uniform(-1, 1);
    for (const Vec3& p : mesh.positions) {
      const Eigen::Vector2d uv = uv_of * p;
      mesh.texture_uv.push_back({uv[0], uv[1]});
      mesh.friction_uv.push_back({uv[1], -uv[0]});
    }
    mesh.haptic_material = 0;
    SceneDescription description =
        described({mesh},
                  {node("a", 0, Vec3(1, 2, 3), random_shear(random, false)),
                   node("b", 0, Vec3(-3, 2, 1), random_shear(random, true))},
                  {material("x", {{"stiffness", 1.0}}), material("y", {{"stiffness", 2.0}}),
                   material("z", {})});
    description.images = {{1, 1, {1, 2, 3}}};
    TextureReference texture;
    texture.pixels = 0;
    description.haptic_materials = {{"felt",
                                     {{"vibrotactileTexture", "Other", texture, "/maps/0"},
                                      {"friction", "Other", texture, "/maps/1"}}}};
    const Scene scene = compiled(std::move(description));
    const EffectProgram& program = *scene.world().effects;
    std::set<std::uint32_t> program_materials;
    for (std::uint32_t body = 0; body < 2; ++body) {
      const AffineMap map = scene.map_body_mesh(body);
      const SurfaceIndex& index = *scene.world().bodies[body].index;
      const SurfaceAttributes& attributes = *program.bodies[body].attributes;
      const Mat3 mesh_from_index = map.linear.inverse();
      for (const std::uint32_t slot : slots_of(index)) {
        const std::uint32_t face = index.face(slot);
        const auto of_file = *scene.material(body, face);
        program_materials.insert(program.material(body, slot));
        const auto table = program.table(program.material(body, slot), EffectStage::kForceMap);
        ASSERT_EQ(table.size(), of_file == 2 ? 0u : 1u);
        TriangleGeometry room;
        const TriangleGeometry& t = scene.world().bodies[body].triangle(slot, room);
        const Vec3 corners[3] = {t.a, t.b, t.c};
        for (std::size_t i = 0; i < 3; ++i) {
          const Vec3 p = mesh_from_index * (corners[i] - map.translation_m);
          const Eigen::Vector2d uv = uv_of * p;
          const auto texture_uv = attributes.texture_uv[slot].at(corners[i]);
          const auto friction_uv = attributes.friction_uv[slot].at(corners[i]);
          EXPECT_NEAR(texture_uv[0], uv[0], 1e-12);
          EXPECT_NEAR(texture_uv[1], uv[1], 1e-12);
          EXPECT_NEAR(friction_uv[0], uv[1], 1e-12);
          EXPECT_NEAR(friction_uv[1], -uv[0], 1e-12);
        }
      }
    }
    EXPECT_EQ(program_materials.size(), 3u);
    EXPECT_GT(scene.statistics().memory.effects, 90 * 2 * sizeof(UvMap));
  }
}

TEST(SceneEffects, PartsAreShadedByTheirOwnCreaseAngles) {
  Random random(20261102);
  const MeshDescription mesh = patched_mesh(random, 3);
  const double angles_deg[] = {180.0, 30.0};
  const Scene scene =
      compiled(described({mesh}, {node("a", 0, Vec3::Zero(), random_shear(random, true))},
                         {material("x", {{"creaseAngle", angles_deg[0]}}),
                          material("y", {{"creaseAngle", angles_deg[1]}}), material("z", {})}));
  const SurfaceIndex& index = *scene.world().bodies[0].index;
  const SurfaceAttributes& attributes = *scene.world().effects->bodies[0].attributes;
  for (const std::uint32_t slot : slots_of(index)) {
    const std::uint32_t face = index.face(slot);
    const std::uint32_t of_file = *scene.material(0, face);
    if (of_file == 2) continue;
    const auto expected = crease_normals(scene.mesh(0), scene.map_body_mesh(0),
                                         angles_deg[of_file] * std::numbers::pi / 180.0);
    EXPECT_EQ(attributes.corner_normals[slot], expected[face]);
  }
  EXPECT_TRUE(attributes.texture_uv.empty());

  std::vector<MaterialDescription> many;
  MeshDescription patches = mesh;
  patches.material_runs.clear();
  for (std::uint32_t i = 0; i < 17; ++i) {
    many.push_back(material("m" + std::to_string(i), {{"creaseAngle", 10.0 + i}}));
    patches.material_runs.push_back({4 * i, i});
  }
  expect_refused(described({patches}, {node("quilt", 0)}, many), {"quilt", "creaseAngle", "16"});
}

// --- Maps ----------------------------------------------------------------------------------------

SceneDescription mapped_scene(std::vector<MaterialDescription> materials, ImageDescription image) {
  MeshDescription mesh = box_mesh({1, 1, 1}, 0);
  mesh.texture_uv.assign(mesh.positions.size(), {0.5, 0.5});
  SceneDescription description = described({mesh}, {node("box", 0)}, std::move(materials));
  description.images = {std::move(image)};
  return description;
}

TEST(SceneEffects, GreyMapsAreTheMeanOfTheirColours) {
  SceneDescription description = mapped_scene({material("cloth", {{"textureHeight", 0.01}})},
                                              {2, 1, {65535, 65535, 65535, 0, 6553, 13107}});
  TextureReference texture;
  texture.pixels = 0;
  texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
  description.haptic_materials = {{"felt", {{"vibrotactileTexture", "Other", texture, "/maps/0"}}}};
  description.meshes[0].haptic_material = 0;
  const Scene scene = compiled(std::move(description));
  ASSERT_EQ(scene.world().effects->maps.size(), 1u);
  const HeightMap& map = scene.world().effects->maps[0];
  EXPECT_NEAR(map.value(0.25, 0.5, 0.0), 1.0, 1e-7);
  EXPECT_NEAR(map.value(0.75, 0.5, 0.0), 19660.0 / (3 * 65535), 1e-7);
  EXPECT_NEAR(map.value(5.0, 0.5, 0.0), 19660.0 / (3 * 65535), 1e-7) << "clamped";
}

// The normals of z = sin(2 pi x / n) texels: the highest texel is 1 and the lowest 0.
TEST(SceneEffects, NormalMapsBecomeHeightsFromZeroToOne) {
  constexpr std::uint32_t kSize = 32;
  ImageDescription image{kSize, kSize, {}};
  for (std::uint32_t i = 0; i < kSize * kSize; ++i) {
    const double phase = 2 * std::numbers::pi * ((i % kSize) + 0.5) / kSize;
    const Vec3 n = Vec3(-2 * std::numbers::pi / kSize * std::cos(phase), 0, 1).normalized();
    for (int c = 0; c < 3; ++c) {
      image.rgb.push_back(static_cast<std::uint16_t>(std::lround(65535 * (0.5 * n[c] + 0.5))));
    }
  }
  SceneDescription description =
      mapped_scene({material("cloth", {{"textureHeight", 0.01}})}, std::move(image));
  TextureReference texture;
  texture.pixels = 0;
  description.materials[0].normal_texture = texture;
  const Scene scene = compiled(std::move(description));
  const HeightMap& map = scene.world().effects->maps[0];
  double lowest = 1e9;
  double highest = -1e9;
  for (std::uint32_t x = 0; x < kSize; ++x) {
    const double u = (x + 0.5) / kSize;
    const double value = map.value(u, 0.5 / kSize, 0.0);
    EXPECT_NEAR(value,
                0.5 + 0.5 * std::sin(2 * std::numbers::pi * u) /
                          std::sin(2 * std::numbers::pi * (7.5 / kSize)),
                2e-3);
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  EXPECT_NEAR(lowest, 0.0, 1e-6);
  EXPECT_NEAR(highest, 1.0, 1e-6);
}

ImageDescription random_image(Random& random, std::uint32_t width, std::uint32_t height) {
  ImageDescription image{width, height, {}};
  for (std::uint32_t i = 0; i < 3 * width * height; ++i) {
    image.rgb.push_back(static_cast<std::uint16_t>(32768 + random.index(32768)));
  }
  return image;
}

// Only the sign of the scale matters, because heights are normalised to 0 to 1.
TEST(SceneEffects, NormalMapsAreMadeOnceForAllScalesOfOneSign) {
  Random random(20261103);
  const std::vector<ImageDescription> images = {random_image(random, 7, 5)};
  std::deque<HeightMap> maps;
  HeightMapMaker maker(images, maps);
  TextureReference texture;
  texture.pixels = 0;
  const auto of_scale = [&](double scale) {
    texture.scale = scale;
    const auto map = maker.from_normals(texture);
    EXPECT_TRUE(map);
    return *map;
  };
  const HeightMap* const raised = of_scale(1.0);
  const HeightMap* const sunk = of_scale(-1.0);
  const HeightMap* const flat = of_scale(0.0);
  for (const double scale : {1e-300, 1e-3, 2.0, 1e300}) {
    EXPECT_EQ(of_scale(scale), raised);
    EXPECT_EQ(of_scale(-scale), sunk);
  }
  EXPECT_EQ(of_scale(-0.0), flat);
  EXPECT_EQ(maps.size(), 3u);
  for (int i = 0; i < 35; ++i) {
    const double u = (i % 7 + 0.5) / 7;
    const double v = (i / 7 + 0.5) / 5;
    EXPECT_NEAR(raised->value(u, v, 0) + sunk->value(u, v, 0), 1.0, 1e-6);
    EXPECT_EQ(flat->value(u, v, 0), 1.0);
  }
}

TEST(SceneEffects, RefuseMapsBeyondTheLimitOnTexels) {
  Random random(20261104);
  const std::vector<ImageDescription> images = {random_image(random, 6, 4),
                                                random_image(random, 5, 5)};
  std::deque<HeightMap> maps;
  HeightMapMaker maker(images, maps, 2 * 24 + 24);
  TextureReference texture;
  texture.texture = 3;
  texture.pixels = 0;
  EXPECT_TRUE(maker.grey(texture));
  texture.wrap_u = TextureWrap::kClamp;
  EXPECT_TRUE(maker.from_normals(texture));
  texture.pixels = 1;
  const auto refused = maker.grey(texture);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_NE(refused.error().problem.find("texture 3 of 5 x 5"), std::string::npos);
  EXPECT_NE(refused.error().problem.find("72"), std::string::npos);
  EXPECT_EQ(maps.size(), 2u);
  texture.pixels = 0;
  EXPECT_TRUE(maker.from_normals(texture)) << "made before";
  texture.wrap_v = TextureWrap::kMirror;
  EXPECT_TRUE(maker.grey(texture)) << "exactly the limit";
  texture.wrap_u = TextureWrap::kMirror;
  EXPECT_FALSE(maker.grey(texture));
  EXPECT_EQ(maps.size(), 3u);
}

TEST(SceneEffects, RefuseMissingMaps) {
  SceneDescription description =
      mapped_scene({material("cloth", {{"textureHeight", 0.01}})}, {1, 1, {0, 0, 0}});
  description.materials[0].normal_texture = TextureReference{};
  expect_refused(description, {"cloth", "/materials/cloth", "no image"});
  description.materials[0].normal_texture->pixels = 0;
  description.meshes[0].texture_uv.clear();
  expect_refused(description, {"box", "texture coordinates"});
}

// --- Magnets -------------------------------------------------------------------------------------

// A box whose first side (x = -1) has material 0 and the others material 1.
MeshDescription two_faced_box() {
  MeshDescription mesh = box_mesh({1, 1, 1}, 0);
  mesh.material_runs = {{0, 0}, {2, 1}};
  return mesh;
}

TEST(SceneEffects, MagnetsConsistOfTheFacesOfTheirMaterial) {
  const std::vector<MaterialDescription> materials = {
      material("steel", {{"magnetForce", 2.0}, {"magnetRange", 0.5}}), material("wood", {})};
  const Scene scene =
      compiled(described({two_faced_box()}, {node("a", 0), node("b", 0, {10, 0, 0})}, materials));
  const EffectProgram& program = *scene.world().effects;
  ASSERT_EQ(program.magnets.size(), 2u);
  EXPECT_EQ(program.indices.size(), 1u) << "of one shape";
  EXPECT_EQ(program.magnets[0].index, program.magnets[1].index);
  const ContactBody& body = scene.world().bodies[0];
  const auto nearest = program.magnets[0].index->closest_point(
      body.length_to_body(1.0) * Vec3(0.9, 0, 0), body.length_to_body(10.0));
  ASSERT_TRUE(nearest);
  EXPECT_LE((body.length_to_solver(1.0) * nearest->point_m - Vec3(-1, 0, 0)).norm(), 1e-15);

  HapticLoop loop = loop_in(scene);
  const double distance_m = 0.1;
  const TickRecord near = tick_along(loop, {8, 0, 0}, {9 - distance_m, 0, 0});
  EXPECT_NEAR(vec3(near.force_device_N).x(), 2.0 * std::pow(1 - distance_m / 0.5, 2), 1e-9);
  tick_along(loop, {9 - distance_m, 0, 0}, {8, 3, 0});
  tick_along(loop, {8, 3, 0}, {12, 3, 0});
  EXPECT_EQ(vec3(tick_along(loop, {12, 3, 0}, {11.1, 0, 0}).force_device_N), Vec3::Zero());
}

TEST(SceneEffects, AMagnetOfAllFacesUsesTheIndexOfTheBody) {
  const Scene scene =
      compiled(described({box_mesh({1, 1, 1}, 0)}, {node("a", 0)},
                         {material("steel", {{"magnetForce", 2.0}, {"magnetRange", 0.5}})}));
  const EffectProgram& program = *scene.world().effects;
  ASSERT_EQ(program.magnets.size(), 1u);
  EXPECT_EQ(program.magnets[0].index, scene.world().bodies[0].index);
  EXPECT_TRUE(program.indices.empty());
}

TEST(SceneEffects, RefuseMagnetsBeyondTheLimit) {
  std::vector<NodeDescription> nodes;
  for (int i = 0; i <= 256; ++i) nodes.push_back(node("n" + std::to_string(i), 0, {3.0 * i, 0, 0}));
  expect_refused(described({box_mesh({1, 1, 1}, 0)}, nodes,
                           {material("steel", {{"magnetForce", 2.0}, {"magnetRange", 0.5}})}),
                 {"steel", "n256", "256", "/materials/steel/extras/palpate/magnetForce"});
}

// --- Media ---------------------------------------------------------------------------------------

// The drag at 1 m/s along x, at a point.
Vec3 drag_at(const Scene& scene, const Vec3& p_m) {
  HapticLoop loop = loop_in(scene);
  TickRecord record;
  for (int n = -10; n <= 0; ++n) record = loop.tick(p_m + Vec3(1e-3 * n, 0, 0), kTick_s);
  return vec3(record.force_device_N);
}

TEST(SceneEffects, AMediumActsInsideAClosedBody) {
  const Scene scene = compiled(described({box_mesh({1, 1, 1}, 0)}, {node("a", 0)},
                                         {material("jelly", {{"viscosity", 3.0}})}));
  EXPECT_NEAR(drag_at(scene, {0.2, 0, 0}).x(), -3.0, 1e-9);
  EXPECT_EQ(drag_at(scene, {1.2, 0, 0}), Vec3::Zero());
}

TEST(SceneEffects, RefuseAMediumInAnOpenSurface) {
  MeshDescription open = box_mesh({1, 1, 1}, 0);
  open.triangles.pop_back();
  const std::vector<MaterialDescription> jelly = {material("jelly", {{"viscosity", 3.0}})};
  expect_refused(described({open}, {node("bowl", 0)}, jelly),
                 {"bowl", "jelly", "open: 3 boundary edges", "/extras/palpate/viscosity",
                  "close the surface", "`SceneSettings::overrides` \"jelly.viscosity=0\""});
  const auto fog = material("fog", {{"viscosity", 3.0}, {"solid", false}});
  expect_refused(described({open}, {node("bowl", 0)}, {fog}),
                 {"`SceneSettings::overrides` \"fog.viscosity=0\" `SceneSettings::overrides` "
                  "\"fog.solid=true\""});
  expect_refused(described({two_faced_box()}, {node("box", 0)}, {jelly[0], material("wood", {})}),
                 {"box", "jelly", "one material for all faces"});
  expect_refused(
      described({two_faced_box()}, {node("box", 0)},
                {material("fog", {{"viscosity", 3.0}, {"solid", false}}), material("wood", {})}),
      {"box", "one material for all faces"});
}

TEST(SceneEffects, ANodeThatIsNotSolidIsARegionAndNotAnObject) {
  const Mat3 turned = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Scene scene = compiled(described(
      {box_mesh({1, 1, 1}, 0), box_mesh({1, 1, 1}, 1)},
      {node("first", 1), node("fog", 0, {5, 0, 0}, 0.5 * turned), node("last", 1, {10, 0, 0})},
      {material("fog", {{"viscosity", 3.0}, {"solid", false}}),
       material("stone", {{"stiffness", 500.0}})}));
  ASSERT_EQ(scene.objects().size(), 2u);
  ASSERT_EQ(scene.world().bodies.size(), 2u);
  EXPECT_EQ(scene.objects()[1].name, "last");
  EXPECT_EQ(scene.statistics().instances, 3u);
  EXPECT_NEAR(drag_at(scene, {5, 0, 0}).x(), -3.0, 1e-9);
  EXPECT_NEAR(drag_at(scene, Vec3(5, 0, 0) + 0.49 * turned.col(1)).x(), -3.0, 1e-9);
  EXPECT_EQ(drag_at(scene, Vec3(5, 0, 0) + 0.52 * turned.col(1)), Vec3::Zero());
  HapticLoop loop = loop_in(scene);
  const TickRecord through = tick_along(loop, {5, 5, 0}, {5, 0, 0}, 5000);
  EXPECT_FALSE(through.contact);
  EXPECT_NEAR(vec3(through.force_device_N).y(), 3.0, 1e-9);
}

TEST(SceneEffects, MediaActWithoutAnySurface) {
  const Scene scene =
      compiled(described({box_mesh({1, 1, 1}, 0)}, {node("fog", 0)},
                         {material("fog", {{"viscosity", 3.0}, {"solid", false}})}));
  EXPECT_TRUE(scene.world().bodies.empty());
  EXPECT_NEAR(drag_at(scene, {0.2, 0, 0}).x(), -3.0, 1e-9);
  EXPECT_EQ(drag_at(scene, {1.5, 0, 0}), Vec3::Zero());
}

RegionDescription region(const std::string& name, std::uint32_t tree_node,
                         const std::vector<std::pair<std::string, MaterialValue>>& values) {
  RegionDescription r;
  r.name = name;
  r.element = "/nodes/1/extras/palpate";
  for (const auto& [key, value] : values)
    r.parameters.push_back({key, value, r.element + "/" + key});
  r.tree_node = tree_node;
  return r;
}

SceneDescription pool_scene() {
  SceneDescription description = described({box_mesh({1, 1, 1}, std::nullopt)}, {node("a", 0)}, {});
  description.tree = {{"root", 0, {}, false, Vec3::Zero()},
                      {"a", 1, 0u, true, Vec3::Zero()},
                      {"pools", 2, 0u, false, Vec3::Zero()}};
  description.nodes[0].tree_node = 1;
  description.regions = {
      region("pool", 2,
             {{"medium", std::string("box")},
              {"size", std::vector<double>{2.0, 1.0, 1.0}},
              {"viscosity", 4.0}}),
      region("ball", 1, {{"medium", std::string("sphere")}, {"radius", 1.0}, {"viscosity", 5.0}})};
  description.regions[0].linear_scene_node = Vec3(1, -2, 1).asDiagonal();
  description.regions[0].translation_m = {5, 0, 0};
  description.regions[1].translation_m = {-5, 0, 0};
  return description;
}

TEST(SceneEffects, NodesCanBeRegions) {
  const Scene scene = compiled(pool_scene());
  ASSERT_EQ(scene.effects().regions.size(), 2u);
  EXPECT_EQ(scene.effects().regions[0].effects, std::vector<std::string>{"viscosity"});
  EXPECT_NEAR(drag_at(scene, {5.9, 0, 0}).x(), -4.0, 1e-9);
  EXPECT_NEAR(drag_at(scene, {5, 0.9, 0}).x(), -4.0, 1e-9);
  EXPECT_EQ(drag_at(scene, {5, 1.1, 0}), Vec3::Zero());
  EXPECT_EQ(drag_at(scene, {5, 0, 0.6}), Vec3::Zero());
  EXPECT_NEAR(drag_at(scene, {-5.9, 0, 0}).x(), -5.0, 1e-9);
  EXPECT_EQ(drag_at(scene, {-5.9, 0.9, 0}), Vec3::Zero());
}

TEST(SceneEffects, RegionsAreScaledAndSelectedWithTheScene) {
  SceneSettings settings;
  settings.scale = 10.0;
  const Scene large = compiled(pool_scene(), settings);
  EXPECT_NEAR(drag_at(large, {59, 0, 0}).x(), -4.0, 1e-9);
  EXPECT_EQ(drag_at(large, {5.9, 0, 11}), Vec3::Zero());
  settings = {};
  settings.node = "a";
  const Scene part = compiled(pool_scene(), settings);
  ASSERT_EQ(part.effects().regions.size(), 1u);
  EXPECT_EQ(part.effects().regions[0].name, "ball");
}

TEST(SceneEffects, LengthsAreScaledWithTheScene) {
  SceneSettings settings;
  settings.fit_size_m = 0.2;  // a tenth
  const Scene scene =
      compiled(described({box_mesh({1, 1, 1}, 0)}, {node("a", 0)},
                         {material("steel", {{"magnetForce", 2.0}, {"magnetRange", 0.5}})}),
               settings);
  const EffectProgram& program = *scene.world().effects;
  MagnetEffect::Parameters p;
  const auto calls = program.table(program.places);
  std::memcpy(&p, program.parameters.data() + calls[0].parameters, sizeof p);
  EXPECT_DOUBLE_EQ(p.range_m, 0.05);
  EXPECT_EQ(p.force_N, 2.0);
}

TEST(SceneEffects, ASceneCanDeclareGravityAndAForce) {
  SceneDescription description = described({box_mesh({1, 1, 1}, std::nullopt)}, {node("a", 0)}, {});
  description.scene_parameters = {"scene", "/scenes/0", {}, std::nullopt};
  description.scene_parameters.parameters = {
      {"constantForce", std::vector<double>{1.0, 0.0, 0.0}, "/scenes/0/c"},
      {"gravity", std::vector<double>{0.0, -10.0, 0.0}, "/scenes/0/g"},
      {"toolMass", 0.2, "/scenes/0/t"}};
  const Scene scene = compiled(std::move(description));
  EXPECT_EQ(scene.effects().scene.effects, std::vector<std::string>{"gravity"});
  HapticLoop loop = loop_in(scene);
  EXPECT_LE((vec3(loop.tick({3, 0, 0}, kTick_s).force_device_N) - Vec3(1, -2, 0)).norm(), 1e-15);
}

TEST(SceneEffects, RefuseFrequenciesTooHighForTheTickRate) {
  const Scene scene = compiled(
      described({box_mesh({1, 1, 1}, 0)}, {node("a", 0)},
                {material("motor", {{"vibrationAmplitude", 0.5}, {"vibrationFrequency", 400.0}})}));
  EXPECT_FALSE(check_tick_rate(scene.effects(), 1000.0));
  const auto error = check_tick_rate(scene.effects(), 800.0);
  ASSERT_TRUE(error);
  EXPECT_NE(error->to_string().find("motor"), std::string::npos);
  EXPECT_NE(error->to_string().find("vibrationFrequency is 400"), std::string::npos);
  EXPECT_NE(error->to_string().find("400 Hz"), std::string::npos);
}

}  // namespace
}  // namespace palpate
