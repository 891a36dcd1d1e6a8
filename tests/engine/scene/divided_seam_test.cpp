// Texture coordinates of the pieces into which a seam divides triangles at T-junctions: on every
// piece they are those of the undivided triangle, so that a map has the same value on both sides of
// the seam, and the forces are those of a scene whose seam was not divided.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "engine/scene/surface_attributes.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::compiled;
using test::Random;

// A map of positions to texture coordinates.
using UvOf = Eigen::Matrix<double, 2, 3>;

// Strips of 1 m x 1 m on both sides of the border y = 0, z = 0. Each has vertices of its own on the
// border, at the given x; the T-junctions are where the other strip has none.
struct BorderedStrip {
  double side;            // 1 or -1: y of the other border
  std::vector<double> x;  // ascending, from 0 to 1
};

std::vector<double> random_stations_of_border(Random& random) {
  std::vector<double> x{0.0, 1.0};
  for (std::uint64_t n = random.index(5); n > 0; --n) {
    x.push_back(static_cast<double>(1 + random.index(1023)) / 1024.0);
  }
  std::sort(x.begin(), x.end());
  x.erase(std::unique(x.begin(), x.end()), x.end());
  return x;
}

void add_strip(const BorderedStrip& strip, const Mat3& linear, const UvOf& uv_of,
               MeshDescription& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto add = [&](double x, double y) {
    const Vec3 p = linear * Vec3(x, y, 0.0);
    mesh.positions.push_back(p.cast<float>().cast<double>());
    const Eigen::Vector2d uv = uv_of * p;
    mesh.texture_uv.push_back({uv[0], uv[1]});
    mesh.friction_uv.push_back({uv[1], -uv[0]});
  };
  add(0.0, strip.side);
  add(1.0, strip.side);
  for (const double x : strip.x) add(x, 0.0);
  const auto add_triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (strip.side < 0.0) std::swap(b, c);
    mesh.triangles.push_back({first + a, first + b, first + c});
  };
  const auto count = static_cast<std::uint32_t>(strip.x.size());
  for (std::uint32_t i = 0; i + 1 < count; ++i) add_triangle(0, 2 + i, 3 + i);
  add_triangle(0, count + 1, 1);
}

// Two strips, in one mesh or in two nodes, with a map.
SceneDescription divided_seam(Random& random, bool are_nodes, const Mat3& linear,
                              const UvOf& uv_of) {
  SceneDescription description;
  description.path = "made.glb";
  for (const double side : {-1.0, 1.0}) {
    if (description.meshes.empty() || are_nodes) {
      MeshDescription mesh;
      mesh.name = "mesh";
      mesh.haptic_material = 0;
      NodeDescription node;
      node.name = "node " + std::to_string(description.nodes.size());
      node.mesh = static_cast<std::uint32_t>(description.meshes.size());
      description.meshes.push_back(std::move(mesh));
      description.nodes.push_back(std::move(node));
    }
    MeshDescription& mesh = description.meshes.back();
    const auto first = static_cast<std::uint32_t>(mesh.triangles.size());
    add_strip({side, random_stations_of_border(random)}, linear, uv_of, mesh);
    mesh.material_runs.push_back({first, 0});
  }
  MaterialDescription cloth{"cloth", "/materials/0", {}, std::nullopt};
  cloth.parameters.push_back({"textureHeight", 0.01, "/materials/0/extras/palpate/textureHeight"});
  description.materials = {cloth};
  ImageDescription image{8, 8, {}};
  for (int i = 0; i < 3 * 8 * 8; ++i) {
    image.rgb.push_back(static_cast<std::uint16_t>(random.index(65536)));
  }
  description.images = {image};
  TextureReference texture;
  texture.pixels = 0;
  description.haptic_materials = {{"felt",
                                   {{"vibrotactileTexture", "Other", texture, "/maps/0"},
                                    {"friction", "Other", texture, "/maps/1"}}}};
  return description;
}

UvOf random_uv(Random& random) {
  UvOf uv_of;
  for (int i = 0; i < 6; ++i) uv_of(i / 3, i % 3) = random.uniform(-1.0, 1.0);
  return uv_of;
}

std::size_t divided_edges(const Scene& scene) {
  return scene.statistics().cleaning.divided_edges + scene.statistics().divided_edges;
}

TEST(DividedSeam, PiecesHaveTheCoordinatesOfTheirTriangle) {
  Random random(4530);
  for (const bool are_nodes : {false, true}) {
    std::size_t divided = 0;
    for (int round = 0; round < 40; ++round) {
      Mat3 linear = random.rotation().toRotationMatrix();
      linear.col(0) *= random.uniform(0.5, 2.0);
      const UvOf uv_of = random_uv(random);
      const Scene scene = compiled(divided_seam(random, are_nodes, linear, uv_of));
      divided += divided_edges(scene);
      for (std::size_t body = 0; body < scene.world().bodies.size(); ++body) {
        const AffineMap map = scene.map_body_mesh(body);
        const Mat3 mesh_from_body = map.linear.inverse();
        const SurfaceIndex& index = *scene.world().bodies[body].index;
        const SurfaceAttributes& attributes = *scene.world().effects->bodies[body].attributes;
        for (std::uint32_t slot = 0; slot < index.pack_count() * TrianglePack::kLanes; ++slot) {
          TriangleGeometry room;
          const TriangleGeometry& t = scene.world().bodies[body].triangle(slot, room);
          for (const Vec3& corner : {t.a, t.b, t.c}) {
            const Vec3 p = mesh_from_body * (corner - map.translation_m);
            const Eigen::Vector2d uv = uv_of * p;
            const auto texture_uv = attributes.texture_uv[slot].at(corner);
            const auto friction_uv = attributes.friction_uv[slot].at(corner);
            // The vertices of the border are off it by the rounding to floats, by up to twice that
            // after they were joined.
            constexpr double kRounding = 1e-6;
            ASSERT_NEAR(texture_uv[0], uv[0], kRounding) << "round " << round;
            ASSERT_NEAR(texture_uv[1], uv[1], kRounding) << "round " << round;
            ASSERT_NEAR(friction_uv[0], uv[1], kRounding) << "round " << round;
            ASSERT_NEAR(friction_uv[1], -uv[0], kRounding) << "round " << round;
          }
        }
      }
    }
    EXPECT_GT(divided, 50u) << are_nodes;
  }
}

// Without rounding, the twin whose seam is not divided has the same forces on both sides of it.
TEST(DividedSeam, ForcesOfAMapAreThoseOfAnUndividedSeam) {
  Random random(4531);
  for (const bool are_nodes : {false, true}) {
    std::size_t divided = 0;
    int contacts = 0;
    for (int round = 0; round < 10; ++round) {
      const UvOf uv_of = random_uv(random);
      const std::uint64_t seed = random.index(1u << 30);
      Random same(seed), again(seed);
      SceneSettings undivided;
      undivided.joins_within_rounding = false;
      const Scene scene = compiled(divided_seam(same, are_nodes, Mat3::Identity(), uv_of));
      const Scene twin =
          compiled(divided_seam(again, are_nodes, Mat3::Identity(), uv_of), undivided);
      divided += divided_edges(scene);
      ASSERT_EQ(divided_edges(twin), 0u);
      auto loop =
          test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
      auto other =
          test::made(HapticLoop::create(twin.world(), *ActuationModel::from_counts(3, 3), {}));
      for (int press = 0; press < 60; ++press) {
        const double y =
            (random.index(2) ? 1.0 : -1.0) * std::pow(10.0, random.uniform(-6.0, -0.5));
        const Vec3 place(random.uniform(0.05, 0.95), y, 0.0);
        for (const double height_m : {0.001, -0.005, -0.02, 0.001}) {
          const Vec3 goal = place + Vec3(0.0, 0.0, height_m);
          const TickRecord a = loop.tick(goal, test::kTick_s);
          const TickRecord b = other.tick(goal, test::kTick_s);
          contacts += a.contact != 0;
          const Vec3 force_N = vec3(a.force_device_N), twin_N = vec3(b.force_device_N);
          ASSERT_NEAR((force_N - twin_N).norm(), 0.0, 1e-9 * (1.0 + twin_N.norm()))
              << "round " << round << ", press at " << place.transpose();
        }
      }
    }
    EXPECT_GT(divided, 10u) << are_nodes;
    EXPECT_GT(contacts, 1000) << are_nodes;
  }
}

}  // namespace
}  // namespace palpate
