#include "engine/accuracy/sine_relief.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/session_pass.h"
#include "engine/scene/scene.h"
#include "geometry/base/random.h"
#include "haptics/record_vectors.h"
#include "models/textured_slab.h"

namespace palpate {
namespace {

// In waves: coordinates of the slab and of its texture are exact.
constexpr double kLengthInWaves = 32.0;
constexpr double kThicknessInWaves = 4.0;

constexpr double kMeanDepthInHeights = 4.0;
constexpr double kDepthSwingInHeights = 1.0;
constexpr std::size_t kReliefLeadIn = 10;

double steps_of(ImageDepth depth) {
  return depth == ImageDepth::k8Bit ? 255.0 : 65535.0;
}

// One wave, as a grey image has it: values of 8 bits are times 257.
ImageDescription sine_image(int texels, ImageDepth depth, double phase) {
  ImageDescription image{static_cast<std::uint32_t>(texels), 1, {}};
  for (int i = 0; i < texels; ++i) {
    const double x = 2.0 * std::numbers::pi * (i + 0.5) / texels + phase;
    const double level = std::round(steps_of(depth) * (0.5 + 0.5 * std::sin(x)));
    image.rgb.insert(image.rgb.end(), 3,
                     static_cast<std::uint16_t>(level * 65535.0 / steps_of(depth)));
  }
  return image;
}

Result<Scene> make_slab(const SineRelief& relief, ImageDescription image) {
  const Vec3 size_m = relief.wave_m * Vec3(kLengthInWaves, kLengthInWaves, kThicknessInWaves);
  TexturedMesh slab = textured_slab(size_m, relief.wave_m);
  SceneDescription scene;
  MeshDescription mesh{"slab", std::move(slab.mesh.positions_m), std::move(slab.mesh.triangles)};
  for (const Point2& uv : slab.texture_coordinates) mesh.texture_uv.push_back({uv.x(), uv.y()});
  mesh.material_runs = {{0, 0}};
  mesh.haptic_material = 0;
  scene.meshes.push_back(std::move(mesh));
  HapticMap map;
  map.property = "vibrotactileTexture";
  map.texture.image = 0;
  map.texture.pixels = 0;
  scene.haptic_materials.push_back({"sine", {map}});
  scene.images.push_back(std::move(image));
  MaterialDescription material;
  material.name = "relief";
  material.element = "/materials/0";
  material.parameters = {
      {"textureHeight", relief.height_m, "/materials/0/extras/palpate/textureHeight"}};
  scene.materials.push_back(std::move(material));
  scene.nodes.emplace_back();
  scene.nodes.back().name = "slab";
  scene.tree.resize(1);
  return Scene::compile(std::move(scene), {});
}

// Straight on over whole waves, at a depth that swings.
std::vector<Vec3> slide(const SineRelief& relief, SeededRandom& random) {
  const double step_m = relief.wave_m / static_cast<double>(relief.ticks_per_wave);
  const double aside = random.uniform(-0.5, 0.5);  // relative to the distance along x
  const Vec3 start_m(random.uniform(-4.0, 4.0) * relief.wave_m,
                     random.uniform(-4.0, 4.0) * relief.wave_m, 0.0);
  const double top_m = 0.5 * kThicknessInWaves * relief.wave_m;
  const std::size_t ticks = relief.waves * relief.ticks_per_wave;
  std::vector<Vec3> path_m;
  for (std::size_t n = 0; n < kReliefLeadIn + ticks; ++n) {
    const double share = static_cast<double>(n) / static_cast<double>(kReliefLeadIn + ticks);
    const double depth = kMeanDepthInHeights + kDepthSwingInHeights * std::sin(9.0 * share);
    Vec3 p_m = start_m + static_cast<double>(n) * step_m * Vec3(1.0, aside, 0.0);
    p_m.z() = top_m + (n == 0 ? 1.0 : -depth) * relief.height_m;
    path_m.push_back(p_m);
  }
  return path_m;
}

}  // namespace

double image_floor(ImageDepth depth) {
  return 0.5 / steps_of(depth);
}

Result<Scene> sine_slab(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                        double phase_rad) {
  return make_slab(relief, sine_image(texels_per_wave, depth, phase_rad));
}

Sample render_sine(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                   const Accuracy& accuracy, std::uint64_t seed) {
  SeededRandom random(seed);
  const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  const Result<Scene> scene = sine_slab(relief, texels_per_wave, depth, phase);
  if (!scene) return Sample{.failure = scene.error().to_string()};
  const std::vector<Vec3> path_m = slide(relief, random);
  const double K = relief.stiffness_N_per_m;
  const double top_m = 0.5 * kThicknessInWaves * relief.wave_m;
  RootMeanSquare off;
  const PassCost cost =
      run_path(scene->world(), PassSetup::fully_actuated({K, 0.0}, {0.0, accuracy}), path_m,
               relief.period_s, kReliefLeadIn, [&](const TickRecord& record) {
                 const Vec3& p_m = vec3(record.goal_scene_m);
                 const double x = 2.0 * std::numbers::pi * p_m.x() / relief.wave_m + phase;
                 const double height_m = 0.5 * relief.height_m * (std::sin(x) - 1.0);
                 const double exact_N = K * (top_m - p_m.z() + height_m);
                 off.add((vec3(record.force_device_N).z() - exact_N) / (K * relief.height_m));
               });
  return {off.value(), cost.tick_ns, cost.iterations, cost.ticks, failure_of(cost.faults)};
}

}  // namespace palpate
