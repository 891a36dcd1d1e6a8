// Tests that bodies with a shared index give the same results as bodies whose index contains the
// deformed mesh. The oracles are triangles computed here from mesh and node in long double, and
// scenes in which every node has its own mesh, deformed in advance.
//
// The seed defines a scene: PALPATE_SEED=N runs scene N alone.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "engine/session/node_motions.h"
#include "haptics/check_settings.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::Corners;
using test::ExactJudge;
using test::HardKind;
using test::HardScene;
using test::in_soak_or_else;
using test::kEpsilon;
using test::Random;
using test::Soup;

using Wide = long double;
using Wide3 = Eigen::Matrix<Wide, 3, 1>;
using Wide33 = Eigen::Matrix<Wide, 3, 3>;

// Tolerance of the proxy, relative to the size of the scene.
constexpr double kExactPerSize = 1e-9;

enum class MapKind { kUniform, kMirror, kStretch, kShear, kAny };

Mat3 signs(Random& random, bool is_mirror) {
  const double y = random.index(2) ? 1 : -1;
  Vec3 s(random.index(2) ? 1 : -1, y, 1);
  s[2] = s[0] * s[1] * (is_mirror ? -1 : 1);
  return s.asDiagonal();
}

// A random map of size 1, with a ratio of singular values up to most_ratio.
Mat3 random_map(MapKind kind, double most_ratio, Random& random) {
  if (kind == MapKind::kAny) kind = static_cast<MapKind>(random.index(4));
  const auto turn = [&] {
    return random.index(3) ? Mat3(random.rotation().toRotationMatrix()) : Mat3(Mat3::Identity());
  };
  const Mat3 sign = signs(random, kind == MapKind::kMirror || random.index(4) == 0);
  const Mat3 first = turn() * sign;
  if (kind == MapKind::kUniform || kind == MapKind::kMirror) return first;
  Vec3 stretch;
  for (double& s : stretch) s = std::pow(most_ratio, -random.uniform(0.0, 1.0));
  stretch /= stretch.maxCoeff();
  const Mat3 second =
      kind == MapKind::kShear ? Mat3(random.rotation().toRotationMatrix()) : Mat3(Mat3::Identity());
  return first * stretch.asDiagonal() * second;
}

Wide3 exact(const NodeDescription& node, const Vec3& p_mesh) {
  return node.linear_scene_mesh.cast<Wide>() * p_mesh.cast<Wide>() +
         node.translation_m.cast<Wide>();
}

// The triangles of a node, in the solver frame, rounded once.
std::vector<Corners> exact_triangles(const SceneDescription& description,
                                     const NodeDescription& node, const ContactWorld& world) {
  const MeshDescription& mesh = description.meshes[node.mesh];
  const bool is_mirrored = node.linear_scene_mesh.determinant() < 0.0;
  std::vector<Corners> triangles;
  const auto corner = [&](std::uint32_t v) -> Vec3 {
    return (exact(node, mesh.positions[v]) - world.anchor_scene_m.cast<Wide>()).cast<double>();
  };
  for (const Triangle& t : mesh.triangles) {
    triangles.push_back(
        {corner(t[0]), corner(t[is_mirrored ? 2 : 1]), corner(t[is_mirrored ? 1 : 2])});
  }
  return triangles;
}

// The same scene, in which each node has its own mesh, deformed in advance.
SceneDescription baked(const SceneDescription& description) {
  SceneDescription alone = description;
  alone.meshes.clear();
  for (NodeDescription& node : alone.nodes) {
    MeshDescription mesh = description.meshes[node.mesh];
    for (Vec3& p : mesh.positions) {
      p = (node.linear_scene_mesh.cast<Wide>() * p.cast<Wide>()).cast<double>();
    }
    if (node.linear_scene_mesh.determinant() < 0.0) {
      for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
      // Texture coordinates belong to the original positions.
    }
    node.mesh = static_cast<std::uint32_t>(alone.meshes.size());
    node.linear_scene_mesh.setIdentity();
    node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
    alone.meshes.push_back(std::move(mesh));
  }
  return alone;
}

NodeDescription node_of_mesh(std::uint32_t mesh, const Mat3& linear, const Vec3& translation_m) {
  NodeDescription node;
  node.name = "node " + std::to_string(mesh);
  node.mesh = mesh;
  node.linear_scene_mesh = linear;
  node.translation_m = translation_m;
  node.product = TransformProduct::of(linear, translation_m);
  return node;
}

Scene compiled_for_proxy(SceneDescription description, double proxy_radius_m = 0.0) {
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  settings.joins_within_rounding = false;  // the oracles have the triangles of the file
  auto scene = Scene::compile(std::move(description), settings);
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

// ---- hard scenes, as a mesh that a node deforms ------------------------------------------------

struct HardNodes {
  SceneDescription description;
  HardScene scene;
};

// The first node is a hard scene: its mesh is the inverse image of that scene under the node's map.
// Two more nodes show the mesh with other deformations, small and far away, so that the
// deformations of its nodes differ.
HardNodes hard_nodes(HardKind kind, MapKind map_kind, Random& random) {
  HardNodes made;
  made.scene = test::hard_scene(kind, random);
  const double scale = std::pow(10.0, random.uniform(-3.0, 3.0));
  const Mat3 linear = scale * random_map(map_kind, 99.0, random);
  const Mat3 inverse = linear.inverse();
  MeshDescription mesh{"hard", {}, made.scene.soup.triangles};
  for (const Vec3& p : made.scene.soup.positions) mesh.positions.push_back(inverse * p);
  double reach = 0.0;
  for (const Vec3& p : mesh.positions) reach = std::max(reach, p.norm());
  made.description.path = "made.glb";
  made.description.meshes.push_back(std::move(mesh));
  made.description.nodes.push_back(node_of_mesh(0, linear, Vec3::Zero()));
  for (int i = 0; i < 2; ++i) {
    const Mat3 other = 2e-3 / reach * random_map(MapKind::kAny, 90.0, random);
    made.description.nodes.push_back(node_of_mesh(0, other, Vec3(0.4, 0.2 * i, 0)));
  }
  return made;
}

struct Judged {
  Judged(const HardNodes& nodes, double radius_m)
      : scene(compiled_for_proxy(nodes.description, radius_m)),
        triangles(exact_triangles(nodes.description, nodes.description.nodes[0], scene.world())),
        judge(triangles) {}

  Scene scene;
  std::vector<Corners> triangles;
  ExactJudge judge;
};

// The triangles that the engine uses, body frame.
std::vector<Corners> decided_triangles(const ContactBody& body) {
  std::vector<Corners> triangles;
  for (std::uint32_t pack = 0; pack < body.index->pack_count(); ++pack) {
    for (int lane = 0; lane < body.index->pack(pack).count; ++lane) {
      TriangleGeometry room;
      const TriangleGeometry& t = body.triangle(SurfaceIndex::slot(pack, lane), room);
      triangles.push_back({t.a, t.b, t.c});
    }
  }
  return triangles;
}

double farthest_from_solver(const ContactBody& body, const std::vector<Corners>& solver) {
  double farthest_m = 0.0;
  for (std::uint32_t pack = 0; pack < body.index->pack_count(); ++pack) {
    for (int lane = 0; lane < body.index->pack(pack).count; ++lane) {
      const std::uint32_t slot = SurfaceIndex::slot(pack, lane);
      TriangleGeometry room;
      const TriangleGeometry& t = body.triangle(slot, room);
      double least_m = std::numeric_limits<double>::infinity();
      for (const Corners& c : solver) {
        // For a mirrored body, the index has the corners in the order of the mesh.
        const bool is_turned = body.units_per_metre < 0.0;
        const double apart_m = std::max({(body.to_solver(t.a) - c.a).norm(),
                                         (body.to_solver(is_turned ? t.c : t.b) - c.b).norm(),
                                         (body.to_solver(is_turned ? t.b : t.c) - c.c).norm()});
        least_m = std::min(least_m, apart_m);
      }
      farthest_m = std::max(farthest_m, least_m);
    }
  }
  return farthest_m;
}

TEST(SharedIndex, DecidesOnTheTrianglesOfTheFile) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const auto kind = test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))];
    const HardNodes nodes = hard_nodes(kind, MapKind::kAny, random);
    const Scene scene = compiled_for_proxy(nodes.description);
    EXPECT_EQ(scene.statistics().indices, 1u);
    for (std::size_t n = 0; n < nodes.description.nodes.size(); ++n) {
      const auto triangles =
          exact_triangles(nodes.description, nodes.description.nodes[n], scene.world());
      const double size_m = scene.world().size_m;
      EXPECT_LE(farthest_from_solver(scene.world().bodies[n], triangles), 100 * kEpsilon * size_m)
          << test::name_of(kind);
    }
  }
}

TEST(SharedIndex, TransformsNormalsOfStretchesByTheInverseTranspose) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    SceneDescription description;
    description.meshes.push_back(
        {"mesh", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {1, 2, 3}}});
    for (int i = 0; i < 4; ++i) {
      description.nodes.push_back(
          node_of_mesh(0, random_map(MapKind::kAny, 99.0, random), random.in_box(3.0)));
    }
    const Scene scene = compiled_for_proxy(description);
    for (std::size_t n = 0; n < description.nodes.size(); ++n) {
      const ContactBody& body = scene.world().bodies[n];
      const Wide33 linear = description.nodes[n].linear_scene_mesh.cast<Wide>();
      for (std::uint32_t slot = 0; slot < 2; ++slot) {
        const Triangle face = description.meshes[0].triangles[body.index->face(slot)];
        const auto& p = description.meshes[0].positions;
        const Vec3 across = (p[face[1]] - p[face[0]]).cross(p[face[2]] - p[face[0]]);
        const Wide3 expected = (linear.inverse().transpose() * across.cast<Wide>()).normalized();
        TriangleGeometry room;
        const Vec3 normal = body.direction_to_solver(body.triangle(slot, room).normal);
        EXPECT_LE((normal.cast<Wide>() - expected).norm(), 1e-12L);
      }
    }
  }
}

// Goals near a surface: mostly near the proxy, or behind the touched surface.
Vec3 some_goal(const std::vector<Corners>& triangles, const Vec3& proxy, Random& random) {
  const Corners& t = triangles[random.index(triangles.size())];
  const Vec3 corners[] = {t.a, t.b, t.c, (t.a + t.b + t.c) / 3.0};
  const Vec3 aim = corners[random.index(4)];
  switch (random.index(4)) {
    case 0:
      return aim;
    case 1:
      return aim + 0.5 * (aim - proxy);
    case 2:
      return proxy + std::pow(10.0, random.uniform(-7.0, -2.0)) * random.unit_vector();
    default:
      return random.in_box(0.15);
  }
}

double hard_radius_m(bool is_sphere, Random& random) {
  constexpr double kRadii_m[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
  return is_sphere ? kRadii_m[random.index(std::size(kRadii_m))] : 0.0;
}

// Checks that no segment of a path touches a triangle. For a sphere, whose distance is much larger
// than rounding errors, these are the triangles of the file. For a point, these are the triangles
// that the engine uses, in the body frame; the tests above compare them with the file. In addition,
// the point stays on its side of closed surfaces in the solver frame, where both are rounded once
// more.
void expect_no_leaks(bool is_sphere, int ticks_per_kind) {
  constexpr int kTicksPerScene = 250;
  int contacts = 0;
  for (const HardKind kind : test::kAllHardKinds) {
    const int scenes = std::max(1, ticks_per_kind / kTicksPerScene);
    for (int n = 0; n < scenes; ++n) {
      Random random(static_cast<std::uint64_t>(n) + 1);
      const HardNodes nodes = hard_nodes(kind, MapKind::kAny, random);
      const double radius_m = hard_radius_m(is_sphere, random);
      const Judged judged(nodes, radius_m);
      const ContactWorld& world = judged.scene.world();
      const ContactBody& body = world.bodies[0];
      const ExactJudge own(decided_triangles(body));
      auto god_object = test::made(GodObject::create(world, {.radius_m = radius_m}));
      Vec3 start;
      do {
        start = random.in_box(0.2 + 2 * radius_m);
      } while (judged.judge.distance_m(start) < 1.1 * radius_m + 1e-6);
      god_object.place(start);
      // Repeated triangles have no defined parity.
      const bool has_sides = nodes.scene.is_closed && kind != HardKind::kRepeated;
      const bool was_inside = has_sides && judged.judge.is_inside(start);
      for (int tick = 0; tick < kTicksPerScene; ++tick) {
        contacts +=
            god_object.move_to(some_goal(judged.triangles, god_object.proxy(), random)).in_contact;
        const auto path = god_object.path();
        if (is_sphere) {
          const double least_m = radius_m - 200 * kEpsilon * world.size_m;
          const auto touch = judged.judge.touch_of_sphere(path, least_m);
          ASSERT_FALSE(touch) << test::name_of(kind) << ", tick " << tick << ", radius " << radius_m
                              << ", nearer by " << radius_m - touch->distance_m;
          continue;
        }
        std::vector<Vec3> path_body;
        for (const Vec3& p : path) path_body.push_back(body.to_body(p));
        ASSERT_FALSE(own.touch_of_point(path_body)) << test::name_of(kind) << ", tick " << tick;
        ASSERT_TRUE(!has_sides || judged.judge.is_inside(god_object.proxy()) == was_inside)
            << test::name_of(kind) << ", tick " << tick;
      }
    }
  }
  EXPECT_GT(contacts, 0);
}

TEST(SharedIndex, LetsNoPointThroughHardScenes) {
  expect_no_leaks(false, in_soak_or_else(100'000, 2'000));
}

TEST(SharedIndex, LetsNoSphereThroughHardScenes) {
  expect_no_leaks(true, in_soak_or_else(100'000, 1'000));
}

// ---- comparison with separate indices ----------------------------------------------------------

// A closed bumpy body, nearly convex, so that a proxy under light pressure has only one rest.
MeshDescription pebble(Random& random) {
  MeshDescription mesh{"pebble", {}, {}};
  constexpr std::uint32_t kRings = 9;
  constexpr std::uint32_t kAround = 12;
  for (std::uint32_t i = 0; i <= kRings; ++i) {
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double theta = std::numbers::pi * (i + 0.5) / (kRings + 1);
      const double phi = 2 * std::numbers::pi * j / kAround;
      mesh.positions.push_back(
          Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)) +
          0.01 * random.in_box(1.0) + Vec3(5, -3, 2));
      mesh.texture_uv.push_back({phi, theta});
    }
  }
  const auto at = [](std::uint32_t i, std::uint32_t j) { return i * kAround + j % kAround; };
  for (std::uint32_t i = 0; i < kRings; ++i) {
    for (std::uint32_t j = 0; j < kAround; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  for (std::uint32_t j = 1; j + 1 < kAround; ++j) {
    mesh.triangles.push_back({at(0, 0), at(0, j), at(0, j + 1)});
    mesh.triangles.push_back({at(kRings, 0), at(kRings, j + 1), at(kRings, j)});
  }
  return mesh;
}

SceneDescription pebbles(MapKind kind, double most_ratio, Random& random) {
  SceneDescription description;
  description.path = "made.glb";
  description.meshes.push_back(pebble(random));
  for (int i = 0; i < 12; ++i) {
    const double scale = std::pow(10.0, random.uniform(-1.5, 0.0));
    const Mat3 linear = scale * random_map(kind, most_ratio, random);
    const Vec3 place(3.0 * (i % 3), 3.0 * (i / 3 % 2), 3.0 * (i / 6));
    description.nodes.push_back(node_of_mesh(0, linear, place - linear * Vec3(5, -3, 2)));
  }
  return description;
}

MaterialDescription declared_material(std::vector<std::pair<std::string, double>> parameters) {
  MaterialDescription m{"felt", "/materials/0", {}, std::nullopt};
  for (const auto& [key, value] : parameters) {
    m.parameters.push_back({key, value, "/materials/0/extras/palpate/" + key});
  }
  std::sort(m.parameters.begin(), m.parameters.end(),
            [](const auto& a, const auto& b) { return a.key < b.key; });
  return m;
}

// A device that approaches from outside, presses lightly and slides, on one body after another.
class Strokes {
 public:
  Strokes(const SceneDescription& description, Random& random)
      : description_(&description), random_(&random) {}

  bool begins() const { return left_ == 0; }
  void begin() {
    const auto& nodes = description_->nodes;
    node_ = &nodes[random_->index(nodes.size())];
    out_ = random_->unit_vector();
    turn_ = 0.02 * random_->in_box(1.0);
    left_ = 40;
  }
  // The next device position in the scene, at a random height relative to the body's size.
  Vec3 next() {
    --left_;
    out_ = (out_ + turn_).normalized();
    const double height = left_ > 36 ? 0.3 : random_->uniform(-0.05, 0.01);
    const Vec3 from_middle = (1.0 + height) * out_;
    return node_->linear_scene_mesh * (from_middle + Vec3(5, -3, 2)) + node_->translation_m;
  }

 private:
  const SceneDescription* description_;
  Random* random_;
  const NodeDescription* node_ = nullptr;
  Vec3 out_ = Vec3::UnitX();
  Vec3 turn_ = Vec3::Zero();
  int left_ = 0;
};

struct Differences {
  double proxy = 0.0;  // relative to the size of the scene
  double force = 0.0;  // relative to the largest force
  int touches = 0;
  int ticks = 0;
  int apart = 0;  // strokes in which the two proxies rest on different faces
};

// Moves the same device through two scenes. If the proxies part at a corner where a rounding error
// decides, the rest of the stroke is skipped.
Differences compare(const SceneDescription& description, const Scene& shared, const Scene& alone,
                    double radius_m, int ticks, Random& random, WorldMover* mover_shared = nullptr,
                    WorldMover* mover_alone = nullptr) {
  const auto actuation = ActuationModel::from_counts(3, 3);
  HapticSettings settings;
  settings.god_object.radius_m = radius_m;
  settings.a4.enabled = false;
  settings.force = ForceMode::kFull;
  EXPECT_FALSE(check_settings(shared.world(), settings));
  Strokes strokes(description, random);
  std::optional<HapticLoop> loop_shared;
  std::optional<HapticLoop> loop_alone;
  Differences differences;
  const double size_m = shared.world().size_m;
  for (int tick = 0; tick < ticks; ++tick) {
    if (strokes.begins()) {
      strokes.begin();
      loop_shared = test::made(HapticLoop::create(shared.world(), *actuation, settings));
      loop_alone = test::made(HapticLoop::create(alone.world(), *actuation, settings));
    }
    if (mover_shared) mover_shared->move_bodies(1e-3 * tick, *loop_shared);
    if (mover_alone) mover_alone->move_bodies(1e-3 * tick, *loop_alone);
    const Vec3 goal = strokes.next();
    const TickRecord& a = loop_shared->tick(goal, 1e-3);
    const TickRecord& b = loop_alone->tick(goal, 1e-3);
    ++differences.ticks;
    differences.touches += b.contact;
    const double apart = (vec3(a.proxy_scene_m) - vec3(b.proxy_scene_m)).norm() / size_m;
    if (apart > kExactPerSize && a.contact && b.contact) {
      ++differences.apart;
      while (!strokes.begins()) strokes.next();
      continue;
    }
    differences.proxy = std::max(differences.proxy, apart);
    const double force_N = std::max(1.0, vec3(b.force_device_N).norm());
    differences.force = std::max(
        differences.force, (vec3(a.force_device_N) - vec3(b.force_device_N)).norm() / force_N);
  }
  return differences;
}

void expect_as_alone(MapKind kind, double most_ratio, double radius_m,
                     const std::optional<MaterialDescription>& material, std::uint64_t scenes,
                     int ticks) {
  int apart = 0;
  int touches = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    Random random(seed);
    SceneDescription description = pebbles(kind, most_ratio, random);
    if (material) {
      description.materials = {*material};
      description.meshes[0].material_runs = {{0, 0u}};
    }
    const Scene shared = compiled_for_proxy(description, radius_m);
    const Scene alone = compiled_for_proxy(baked(description), radius_m);
    const Differences d = compare(description, shared, alone, radius_m, ticks, random);
    EXPECT_LE(d.proxy, kExactPerSize) << "seed " << seed;
    EXPECT_LE(d.force, 1e-5) << "seed " << seed;
    apart += d.apart;
    touches += d.touches;
  }
  EXPECT_GT(touches, static_cast<int>(scenes) * ticks / 10);
  EXPECT_LE(apart * 200, static_cast<int>(scenes) * ticks) << "strokes that part";
}

TEST(SharedIndex, GivesAPointTheSameForcesAsASeparateIndex) {
  expect_as_alone(MapKind::kUniform, 1.0, 0.0, std::nullopt, 10, 1000);
  expect_as_alone(MapKind::kMirror, 1.0, 0.0, std::nullopt, 10, 1000);
  expect_as_alone(MapKind::kStretch, 99.0, 0.0, std::nullopt, 20, 1000);
  expect_as_alone(MapKind::kShear, 99.0, 0.0, std::nullopt, 20, 1000);
}

TEST(SharedIndex, GivesASphereTheSameForcesAsASeparateIndex) {
  expect_as_alone(MapKind::kUniform, 1.0, 0.02, std::nullopt, 5, 1000);
  expect_as_alone(MapKind::kMirror, 1.0, 0.02, std::nullopt, 5, 1000);
  expect_as_alone(MapKind::kAny, 9.0, 0.01, std::nullopt, 5, 1000);
}

TEST(SharedIndex, AttractsLikeASeparateIndex) {
  const auto magnet = declared_material({{"magnetForce", 1.0}, {"magnetRange", 0.5}});
  expect_as_alone(MapKind::kUniform, 1.0, 0.0, magnet, 5, 400);
  expect_as_alone(MapKind::kAny, 99.0, 0.0, magnet, 20, 400);
}

TEST(SharedIndex, HasShadingAndFrictionLikeASeparateIndex) {
  const auto smooth = declared_material(
      {{"creaseAngle", 180.0}, {"staticFriction", 0.2}, {"dynamicFriction", 0.1}});
  expect_as_alone(MapKind::kUniform, 1.0, 0.0, smooth, 5, 400);
  expect_as_alone(MapKind::kAny, 20.0, 0.0, smooth, 20, 400);
}

// Slopes are those of the relief in the scene, for every stretch of the map over the surface.
TEST(SharedIndex, HasTextureLikeASeparateIndex) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    SceneDescription description =
        pebbles(seed % 4 ? MapKind::kAny : MapKind::kUniform, 20.0, random);
    description.materials = {declared_material({{"textureHeight", 0.002}})};
    description.meshes[0].material_runs = {{0, 0u}};
    ImageDescription image{16, 16, {}};
    for (int i = 0; i < 3 * 16 * 16; ++i) {
      image.rgb.push_back(static_cast<std::uint16_t>(random.index(65536)));
    }
    description.images = {image};
    TextureReference texture;
    texture.pixels = 0;
    description.haptic_materials = {
        {"felt", {{"vibrotactileTexture", "Other", texture, "/maps/0"}}}};
    description.meshes[0].haptic_material = 0;
    const Scene shared = compiled_for_proxy(description);
    const Scene alone = compiled_for_proxy(baked(description));
    ASSERT_FALSE(shared.world().effects->maps.empty());
    const Differences d = compare(description, shared, alone, 0.0, 400, random);
    EXPECT_LE(d.force, 1e-5) << "seed " << seed;
    EXPECT_GT(d.touches, 40);
  }
}

TEST(SharedIndex, BoundsAMediumLikeASeparateIndex) {
  MaterialDescription medium = declared_material({{"viscosity", 2.0}});
  medium.parameters.push_back({"solid", false, "/materials/0/extras/palpate/solid"});
  std::sort(medium.parameters.begin(), medium.parameters.end(),
            [](const auto& a, const auto& b) { return a.key < b.key; });
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    SceneDescription description = pebbles(MapKind::kAny, 99.0, random);
    description.meshes.push_back(pebble(random));  // a solid body, far away
    description.materials = {medium};
    description.meshes[0].material_runs = {{0, 0u}};
    description.nodes.push_back(node_of_mesh(1, 0.01 * Mat3::Identity(), Vec3(9, 9, 9)));
    const Scene shared = compiled_for_proxy(description);
    const Scene alone = compiled_for_proxy(baked(description));
    EXPECT_EQ(shared.statistics().indices, 2u);
    description.nodes.pop_back();
    const Differences d = compare(description, shared, alone, 0.0, 1000, random);
    EXPECT_LE(d.force, 1e-9) << "seed " << seed;
  }
}

// First with the poses of the file, then with new poses of all bodies in every tick.
TEST(SharedIndex, MovesLikeASeparateIndex) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    SceneDescription description = pebbles(MapKind::kAny, 50.0, random);
    for (std::size_t n = 0; n < description.nodes.size(); ++n) {
      description.nodes[n].name = "n" + std::to_string(n);
    }
    const Scene shared = compiled_for_proxy(description);
    const Scene alone = compiled_for_proxy(baked(description));
    std::vector<SteadyMotion> motions;
    for (const NodeDescription& node : description.nodes) {
      motions.push_back({node.name, 0.02 * random.in_box(1.0), Vec3::Zero()});
    }
    auto move_shared = SteadyMotions::create(shared, motions);
    auto move_alone = SteadyMotions::create(alone, motions);
    ASSERT_TRUE(move_shared && move_alone);
    const Differences d =
        compare(description, shared, alone, 0.0, 400, random, &*move_shared, &*move_alone);
    EXPECT_LE(d.proxy, kExactPerSize) << "seed " << seed;
    EXPECT_GT(d.touches, 10);
    EXPECT_LE(d.apart, 4);
  }
}

// The point must be nearest in the scene, not in the index: compared with all triangles in the
// scene.
TEST(SharedIndex, FindsTheNearestPointOfAStretchedSurface) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const SceneDescription description = pebbles(MapKind::kAny, 99.0, random);
    const Scene scene = compiled_for_proxy(description);
    for (std::size_t n = 0; n < description.nodes.size(); ++n) {
      const ContactBody& body = scene.world().bodies[n];
      const ExactJudge judge(exact_triangles(description, description.nodes[n], scene.world()));
      for (int i = 0; i < 20; ++i) {
        const Vec3 p = body.T_solver_body.translation_m + random.in_box(2.0);
        const Vec3 p_body = body.to_body(p);
        const double range = body.length_to_body(10.0);
        const auto nearest = body.stretch ? closest_point(*body.index, *body.stretch, p_body, range)
                                          : body.index->closest_point(p_body, range);
        ASSERT_TRUE(nearest);
        EXPECT_NEAR(body.length_to_solver(nearest->distance_m), judge.distance_m(p), 1e-13);
        const auto farther = 0.999 * nearest->distance_m;
        EXPECT_FALSE(body.stretch ? closest_point(*body.index, *body.stretch, p_body, farther)
                                  : body.index->closest_point(p_body, farther));
      }
    }
  }
}

// ---- number and frame of indices ---------------------------------------------------------------

std::size_t indices_of(const SceneDescription& description, double radius_m = 0.0) {
  return compiled_for_proxy(description, radius_m).statistics().indices;
}

TEST(SharedIndex, IsTheSameForAllScalesOfAMesh) {
  Random random(1);
  SceneDescription description;
  description.meshes.push_back(pebble(random));
  for (int i = 0; i < 300; ++i) {
    const double scale = std::pow(10.0, random.uniform(-4.0, 4.0));
    description.nodes.push_back(
        node_of_mesh(0, scale * random_map(MapKind::kAny, 1.0, random), random.in_box(1e4)));
  }
  EXPECT_EQ(indices_of(description), 1u);
  for (NodeDescription& node : description.nodes) {
    node.linear_scene_mesh *= random_map(MapKind::kShear, 99.0, random);
  }
  EXPECT_EQ(indices_of(description), 1u);
}

TEST(SharedIndex, IsNotUsedForStretchesOfMoreThanAHundred) {
  Random random(2);
  SceneDescription description;
  description.meshes.push_back(pebble(random));
  description.nodes.push_back(node_of_mesh(0, Mat3::Identity(), Vec3::Zero()));
  description.nodes.push_back(node_of_mesh(0, Vec3(1, 1, 0.0101).asDiagonal(), Vec3(5, 0, 0)));
  EXPECT_EQ(indices_of(description), 1u);
  description.nodes.push_back(node_of_mesh(0, Vec3(1, 1, 0.0099).asDiagonal(), Vec3(10, 0, 0)));
  EXPECT_EQ(indices_of(description), 2u);
  description.nodes.push_back(node_of_mesh(0, Vec3(-3, 3, 0.0297).asDiagonal(), Vec3(15, 0, 0)));
  EXPECT_EQ(indices_of(description), 2u) << "the same, mirrored and larger";
}

TEST(SharedIndex, IsSharedWithinAFactorOfTwoForASphere) {
  Random random(3);
  SceneDescription description;
  description.meshes.push_back(pebble(random));
  for (int i = 0; i < 500; ++i) {
    const double scale = std::pow(10.0, random.uniform(-3.0, 0.0));
    description.nodes.push_back(
        node_of_mesh(0, scale * random_map(MapKind::kMirror, 1.0, random), random.in_box(10.0)));
  }
  EXPECT_LE(indices_of(description, 1e-3), 11u);
  description.nodes.resize(3);
  for (NodeDescription& node : description.nodes) {
    node.linear_scene_mesh = random_map(MapKind::kShear, 5.0, random);
  }
  EXPECT_EQ(indices_of(description, 1e-3), 3u);
}

// Bodies much smaller than the scene, and bodies of the largest size: nothing overflows, and the
// proxy finds contact with bodies of normal size.
TEST(SharedIndex, AcceptsScalesOfAnySize) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    SceneDescription description;
    description.meshes.push_back(pebble(random));
    const bool is_sphere = random.index(2);  // of no more than kLargestSweep_m
    const double size = std::pow(10.0, random.uniform(-50.0, is_sphere ? 15.0 : 50.0));
    description.nodes.push_back(node_of_mesh(0, size * Mat3::Identity(), Vec3::Zero()));
    for (int i = 0; i < 6; ++i) {
      const double scale = size * std::pow(10.0, -random.uniform(0.0, i % 2 ? 20.0 : 150.0));
      const Mat3 linear = scale * random_map(MapKind::kAny, 1e3, random);
      description.nodes.push_back(node_of_mesh(0, linear, size * random.in_box(5.0)));
    }
    const double radius_m = is_sphere ? size * 1e-3 : 0.0;
    const Scene scene = compiled_for_proxy(description, radius_m);
    auto god_object = test::made(GodObject::create(scene.world(), {.radius_m = radius_m}));
    const auto start = scene.world().to_solver(size * Vec3(5, -3, 3.5));
    god_object.place(start);
    const auto goal = scene.world().to_solver(size * Vec3(5, -3, 2));
    const ProxyState state = god_object.move_to(goal);
    EXPECT_TRUE(state.in_contact) << "seed " << seed;
    EXPECT_NEAR((state.proxy - goal).norm() / size, 1.0 + radius_m / size, 0.2);
    for (std::size_t n = 1; n < description.nodes.size(); ++n) {
      const Vec3 at = scene.objects()[n].T_scene_body.translation_m;
      const ProxyState other = god_object.move_to(scene.world().to_solver(at));
      EXPECT_TRUE(other.proxy.allFinite() && other.normal.allFinite());
    }
  }
}

// Every index has size 1: equal digits in single precision for every unit of the file.
TEST(SharedIndex, IsOfSizeOneAboutItsMiddle) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    SceneDescription description;
    description.meshes.push_back(pebble(random));
    const double scale = std::pow(10.0, random.uniform(-40.0, 40.0));
    description.nodes.push_back(node_of_mesh(0, scale * Mat3::Identity(), Vec3::Zero()));
    const Scene scene = compiled_for_proxy(description);
    const Box& box = scene.world().bodies[0].index->box();
    EXPECT_LE((box.high - box.low).maxCoeff(), 1.0);
    EXPECT_GE((box.high - box.low).maxCoeff(), 0.5);
    EXPECT_LE((box.high + box.low).norm(), 4 * kEpsilon * 10);
  }
}

}  // namespace
}  // namespace palpate
